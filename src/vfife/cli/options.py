"""Arguments, options and files that several commands share, and what becomes of them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import Fault, LawError
from ..files import read_bytes
from ..store.schemas import STUDY
from .job import RUNS, CommandJob

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..schema import Value

ModelArgument = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="Model file.", show_default=False)]
RunArgument = Annotated[
    Path, typer.Argument(metavar="RUN", help="Run folder, or the run file in it.", show_default=False)
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help='Set a number of the model by its path, as in joint.C.clearance="0.5 mm".',
    ),
]
LawsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--laws",
        metavar="FILE.py",
        help="Python file with laws of your own, which is run; a model file itself never names code.",
    ),
]
ClusterOption = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help=(
            "Run members on a cluster of dask.distributed: the address of its scheduler, or local for"
            " processes of this machine."
        ),
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print one JSON value on standard output, and nothing else.")
]


def overrides(texts: Iterable[str] | None) -> list[tuple[str, str]]:
    """Paths and values of ``--set``."""
    items = []
    for text in texts or ():
        path, sign, value = text.partition("=")
        if not sign or not path.strip():
            raise ValueError(
                f'--set {text}: this is not PATH=VALUE; write it as in --set joint.C.clearance="0.5 mm"'
            )
        items.append((path.strip(), value.strip()))
    return items


def take_laws(files: Iterable[Path] | None) -> list[str]:
    """Runs the files of ``--laws``; names of the laws that they define."""
    found: list[str] = []
    for file in dict.fromkeys(files or ()):
        from ..laws.user import load_laws

        try:
            found += [law.name for law in load_laws(file)]
        except LawError as error:
            raise ValueError(f"--laws {error}") from None
    return found


def read_model(path: Path, texts: Iterable[str] | None, laws: Iterable[Path] | None = None) -> Mechanism:
    """The mechanism of a model file with what ``--set`` says, the laws of ``--laws`` being known."""
    from ..modelfile import load

    take_laws(laws)
    return load(path, set=overrides(texts))


def option(name: str, held: Value, text: Any) -> Any:
    """The value of an option by a field, a bare number being in SI units. Raises ValueError where the field
    does not take it.
    """

    try:
        return held.take(text, written=True)
    except Fault as fault:
        raise ValueError(str(Fault(f"{name} {text}", fault.what, "", fault.limit, fault.remedy))) from None


def positive(name: str, text: str, unit: str) -> float:
    """A quantity above zero given as an option."""
    from ..schema import Measure

    found: float = option(name, Measure(unit, above=0.0), text)
    return found


def with_options(mechanism: Mechanism, **options: Any) -> Mechanism:
    """The mechanism with the settings of a run that were given as options, so that its model file tells what
    was run; None: not given.
    """
    from ..solvers.arguments import SHARED, RunArguments

    given = {name: text for name, text in options.items() if text is not None}
    if {"turns", "duration"} <= given.keys():
        raise ValueError("--turns and --duration exclude each other; give one of them")
    if str(given.get("companions", "")).isdecimal():
        given["companions"] = int(given["companions"])
    return RunArguments(
        **{name: option(f"--{name}", SHARED[name], text) for name, text in given.items()}
    ).in_settings(mechanism)


MOST = 8_000_000  # bytes of a model that are looked through


def refuse_inputs(targets: Iterable[tuple[str, Path | None]], inputs: Iterable[Path | None]) -> None:
    """Raises ValueError with all targets (option and file) that would be written over an input, over each
    other, or that are folders.

    Inputs are the files that are named and the CSV files that models among them name.
    """
    read = [path for one in inputs if one is not None for path in (one, *tables_of(one))]
    said: list[str] = []
    seen: list[tuple[str, Path]] = []
    for option, path in targets:
        if path is None:
            continue
        if path.is_dir():
            said.append(f"{option} {path}: this is a folder; name a file")
        elif any(same(path, one) for one in read):
            said.append(f"{option} {path}: this file is read, and would be written over; name another file")
        elif (other := next((word for word, one in seen if same(path, one)), None)) is not None:
            said.append(f"{option} {path}: {other} is written there too; name another file")
        seen.append((option, path))
    if said:
        raise ValueError("; ".join(said))


def same(one: Path, other: Path) -> bool:
    """Whether two names are of one file, by links too."""
    try:
        return one.samefile(other)
    except (OSError, ValueError):
        return one.absolute() == other.absolute()


def tables_of(model: Path) -> list[Path]:
    """The CSV files that a model names, as far as it can be read."""
    try:
        if model.suffix.lower() != ".toml" or model.stat().st_size > MOST:
            return []
        raw = tomllib.loads(read_bytes(model).decode("utf-8"))
        return [model.parent / text for text in texts(raw) if text.lower().endswith(".csv")]
    except (OSError, ValueError, RecursionError):  # told when the model is read
        return []


def texts(value: Any) -> Iterator[str]:
    """All texts in a table of TOML."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from texts(one)


StudyArgument = Annotated[
    Path, typer.Argument(metavar="STUDY.toml", help="Study file in TOML.", show_default=False)
]
FileArgument = Annotated[
    Path, typer.Argument(metavar="FILE.study", help="What a study was kept in.", show_default=False)
]
Target = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="FILE.study", help="Where to keep it.", show_default="runs/STUDY.study"
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace the study that is in the file.")]
Yes = Annotated[bool, typer.Option("--yes", help="Run whatever it takes: hours, or half the disk.")]
Workers = Annotated[
    int | None,
    typer.Option(
        metavar="N", min=1, help="Threads, or processes of a local cluster.", show_default="one a core"
    ),
]
ON_CARD = "Step members on an NVIDIA card (extra gpu); we have not tried it on one."
Device = Annotated[str | None, typer.Option(metavar="cuda", help=ON_CARD, show_default="the processor")]
Retry = Annotated[bool, typer.Option("--retry", help="Try members again that failed before.")]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No progress line and no tables; warnings and errors are told.")
]


class StudyCommand(CommandJob):
    """The job of a command that computes members. Raises ValueError where something else has the name of the
    study file.
    """

    def __init__(self, file: Path, target: Path | None, yes: bool, quiet: bool, what: str = "study") -> None:

        place = target if target is not None else RUNS / f"{file.stem}.study"
        if place.exists() and not STUDY.owns(place):
            raise ValueError(
                f"-o {place}: there is something else of this name, which is no study file; name another one"
            )
        super().__init__(what, place, yes=yes, quiet=quiet)
        self.saved = f"Members that ended are kept in {place}; the same command goes on after them."
        self.kept = self.saved if place.exists() else ""
