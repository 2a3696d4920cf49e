"""Options of commands as classes, groups of options shared by several commands, and parsing of
their texts.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from inspect import Parameter, Signature, cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any, dataclass_transform, get_type_hints

import typer
from typer.models import ArgumentInfo

from ..job.activity import ACTIVITY
from .outputs import RUNS, answer_file, own_figure, refuse_files, write_files
from .terminal import answer as print_answer
from .terminal import print_line

if TYPE_CHECKING:
    from ..report.document import Document
    from ..store.schemas import Schema


LAST = (
    "yes",
    "retry",
    "workers",
    "cluster",
    "device",
    "as_json",
    "quiet",
)  # options at the end of every help


def option(default: Any, help: str, metavar: str | None = None, *names: str, **settings: Any) -> Any:
    """Return a field of :class:`Options` for an option; ``settings`` as in ``typer.Option``."""
    return typer.Option(default, *names, metavar=metavar, help=help, **settings)


def flag(name: str, help: str, *short: str, default: bool = False) -> Any:
    """Return a field of :class:`Options` for a switch; ``name`` may include its opposite, as in
    --figures/--no-figures.
    """
    return typer.Option(default, name, *short, help=help)


def argument(help: str, metavar: str, default: Any = ..., **settings: Any) -> Any:
    """Return a field of :class:`Options` for a positional argument."""
    return typer.Argument(default, metavar=metavar, help=help, **{"show_default": False} | settings)


@dataclass_transform(kw_only_default=True, field_specifiers=(option, flag, argument))
class Options:
    """Base of the arguments and options of a command, a field for each; the docstring is its help.

    The help lists options of the class before those of its bases, and common ones last; positional arguments
    are in the order of the bases.
    """

    function = ""  # module and name in ``commands`` of what the command does, as in check.check

    def __init_subclass__(cls, function: str = "") -> None:
        cls.function = function or cls.function

    def __init__(self, **values: Any) -> None:
        vars(self).update(values)

    def answer(self, document: Document, *files: Path | None) -> None:
        """Print an answer: the value of ``--json``, or without ``--quiet`` words, tables and the files that
        were written.
        """
        as_json = getattr(self, "as_json", False)
        if as_json or not getattr(self, "quiet", False):
            print_answer(document, as_json)
            if files and not as_json:
                print_line(", ".join(str(path) for path in files if path is not None))


def typer_function(kind: type[Options]) -> Callable[..., None]:
    """Return the function of a command as typer reads it, with one parameter per field of its options; the
    module that does the work, and all that this imports, is loaded when it is called.
    """
    fields = get_type_hints(kind)
    declared = [list(vars(base).get("__annotations__", ())) for base in kind.__mro__]
    places = [
        name
        for names in reversed(declared)
        for name in names
        if isinstance(getattr(kind, name), ArgumentInfo)
    ]
    shared = [name for names in declared for name in names]
    shared.sort(key=lambda name: LAST.index(name) if name in LAST else -1)
    names = list(dict.fromkeys((*places, *shared)))
    module, _, function = kind.function.partition(".")

    def command(**values: Any) -> None:
        with ACTIVITY.watched(f"vfife {function.replace('_', ' ').strip()}", bool(values.get("quiet"))):
            getattr(import_module(f".commands.{module}", __package__), function)(kind(**values))

    paragraphs = cleandoc(kind.__doc__ or "").split("\n\n")
    command.__name__ = function
    command.__doc__ = "\n\n".join(" ".join(text.split()) for text in paragraphs)
    command.__annotations__ = {name: fields[name] for name in names}
    parameters = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=getattr(kind, name), annotation=fields[name])
        for name in names
    ]
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    return command


# --------------------------------------------------------------------------------------------- shared options

FIGURE_FILE = "FILE.png|svg|pdf"
TABLE_FILE = "FILE.csv|xlsx"
SET = 'Set a number of the model by its path, as in joint.C.clearance="0.5 mm".'
OWN_LAWS = "Python file with your own laws, which is executed; a model file never executes code."
COMPANIONS = "Repeat runs with contact at N other step sizes, 0 to 7, to estimate the error; auto: 3."
OF_MODEL = "the model's"


class LawOptions(Options):
    """Files with user laws."""

    laws: list[Path] | None = option(None, OWN_LAWS, "FILE.py")


class ModelOptions(LawOptions):
    """A model file, and changes of its numbers."""

    model: Path = argument("Model file.", "MODEL.toml")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Input files, which no output may replace."""
        return (self.model, *(self.laws or ()))


class LengthOptions(Options):
    """Length and step of a run, which override those of the model."""

    step: str | None = option(
        None, 'Time step, such as 1e-6 or "1 us", or auto.', "SECONDS", show_default=OF_MODEL
    )
    turns: float | None = option(None, "Length in turns of the crank.", "N", show_default=OF_MODEL)
    duration: str | None = option(None, "Length in time instead of turns.", "SECONDS")
    companions: str | None = option(None, COMPANIONS, "N", show_default=OF_MODEL)
    force_step: bool = flag("--force-step", "Allow a step larger than the stable one.")


class OutputsOptions(Options):
    """Outputs of a run, which override those of the model."""

    outputs: int | None = option(
        None, "Outputs per turn, or per run without a crank.", "N", min=1, show_default=OF_MODEL
    )


class RunOptions(Options):
    """An existing run."""

    run: Path = argument("Run folder, or the run file in it.", "RUN")


class JsonOptions(Options):
    """Output as one JSON value."""

    as_json: bool = flag("--json", "Print one JSON value on standard output, and nothing else.")


class QuietOptions(Options):
    """Amount of output."""

    quiet: bool = flag("--quiet", "No progress line and no summary; warnings and errors are printed.", "-q")


class JobOptions(QuietOptions):
    """Confirmation of long work."""

    yes: bool = flag("--yes", "Confirm a job that takes hours, or half the memory or disk.")


class FileOptions(Options):
    """Files for the results."""

    figure: Path | None = option(None, "File of the figure.", FIGURE_FILE)
    csv: Path | None = option(None, "File of the table.", TABLE_FILE)

    def refuse_files(self, *outputs: tuple[str, Path | None], folder: Path | None = None) -> None:
        """Raise ValueError for files of these and ``outputs`` (option and path) that cannot be
        written; the folder ``folder`` will exist.
        """
        files = [("--figure", self.figure), ("--csv", self.csv), *outputs]
        refuse_files(files, getattr(self, "inputs", ()), folder)

    def write_files(self, result: Any, draw: Callable[[], Any] | None = None) -> None:
        """Draw a result and write its table, where they are wanted."""
        write_files(result, self.figure, self.csv, draw, getattr(self, "decimal", "point"))


class AnswerFileOptions(FileOptions):
    """The file that an answer is kept in; a figure is drawn beside it."""

    target: Path | None

    def answer_file(
        self,
        schema: Schema,
        source: Path,
        kind: str = "",
        ending: str = "",
        *outputs: tuple[str, Path | None],
    ) -> Path:
        """Return the file (see :func:`~vfife.cli.outputs.answer_file`), or the ``source`` that is one, and
        choose that of the figure.
        """
        shown = schema.owns(source)
        place = source if shown else answer_file(schema, self.target, source, kind, ending)
        self.figure = self.figure or own_figure(place, kind or schema.kind)
        folder = RUNS if self.target is None and not shown else None
        self.refuse_files(*([] if shown else [("-o", place)]), *outputs, folder=folder)
        return place


# ---------------------------------------------------------------------------------------- options of studies

ON_CARD = "Compute cases on an NVIDIA graphics card (extra gpu)."
CLUSTER = (
    "Run cases on a cluster of dask.distributed: the address of its scheduler, or local for processes of"
    " this machine."
)


class StudyFileOptions(Options):
    """An existing study file."""

    file: Path = argument("Result file of a study.", "FILE.study")


class RetryOptions(Options):
    """Whether failed cases are computed again."""

    retry: bool = flag("--retry", "Repeat failed cases.")


class ResourceOptions(Options):
    """Resources for computing cases."""

    workers: int | None = option(
        None, "Threads, or processes of a local cluster.", "N", min=1, show_default="one per core"
    )
    cluster: str | None = option(None, CLUSTER, "ADDRESS")
    device: str | None = option(None, ON_CARD, "cuda", show_default="the processor")


class CaseOptions(ResourceOptions, JsonOptions):
    """Options of every command that computes cases."""

    file: Path
    laws: list[Path] | None
    quiet: bool = flag("--quiet", "No progress line and no tables; warnings and errors are printed.", "-q")


class StudyRunOptions(CaseOptions, JobOptions, LawOptions):
    """Options of every command that computes cases from a study file in TOML."""

    file: Path = argument("Study file in TOML.", "STUDY.toml")
    output: Path | None = option(
        None, "Result file.", "FILE.study", "-o", "--output", show_default="runs/STUDY.study"
    )
    force: bool = flag("--force", "Replace an existing study.")
