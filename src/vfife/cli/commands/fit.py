"""``vfife fit``: numbers of a model from measured curves, or those of a contact law from a measured force
over penetration.
"""

from __future__ import annotations

from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...files import write_text
from ...files.kinds import FileKindError, refuse_kind
from ...store.schemas import FIT
from ..job import RUNS, CommandJob
from ..options import (
    FIGURE_FILE,
    OF_MODEL,
    SET,
    TABLE_FILE,
    JsonOptions,
    LawOptions,
    QuietOptions,
    argument,
    flag,
    option,
    overrides,
    read_model,
    take_laws,
)
from ..outputs import PICTURES, TABLES, refuse_endings, refuse_folder, refuse_inputs, write_files
from ..signals import NOW
from ..terminal import answer, end_interrupted, print_line, sentences, writing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...identification.fitting import FitTask
    from ...results.fit import Fit


class Compared(StrEnum):
    """What of the curves is compared."""

    curve = "curve"
    envelope = "envelope"
    spectrum = "spectrum"


class Derivatives(StrEnum):
    """Where derivatives come from."""

    auto = "auto"
    tangents = "tangents"
    differences = "differences"


class StartOf(StrEnum):
    """Where a record begins."""

    model = "model"
    data = "data"


class FitOptions(LawOptions, JsonOptions, QuietOptions):
    """Options of ``vfife fit``."""

    files: list[Path] = argument(
        "Model and measured records; a fit plan; with --law a curve alone; or a fit file.",
        "MODEL.toml DATA.csv...",
        show_default=True,
    )
    parameter: list[str] | None = option(
        None,
        'What is looked for, and between which bounds: joint.C.clearance="0.1..1 mm".',
        "PATH=A..B",
        "-p",
        "--parameter",
    )
    own: list[str] | None = option(
        None, "The same of a number of which each record has its own value.", "PATH=A..B", "--own"
    )
    start: StartOf = option(
        StartOf.model, "data: angles and speeds of bodies near the first samples are looked for."
    )
    every: int = option(1, "Every so many samples of a record count.", "N", min=1)
    column: list[str] | None = option(
        None,
        "Which channel a column is; COLUMN~CHANNEL: only proportional to it.",
        "COLUMN=CHANNEL",
        "-c",
        "--column",
    )
    weight: list[str] | None = option(None, "Weight of a column's residuals.", "COLUMN=W", show_default="1")
    offset: str | None = option(
        None,
        "Where the first sample lies: free (in a turn), a number or two bounds.",
        "A..B",
        show_default="free over time",
    )
    skip: float = option(3.0, "Turns before the data may begin, where the offset is free.", "TURNS", min=0.0)
    compare: Compared = option(
        Compared.curve, "The curves, or of motions that do not repeat their envelope or spectrum."
    )
    width: str | None = option(None, "Window of the envelope.", "SPAN", show_default="a fiftieth of the data")
    step: str | None = option(
        None, 'Time step, such as 1e-6 or "1 us", or auto.', "SECONDS", show_default=OF_MODEL
    )
    screened: int = option(64, "Points that are tried first.", "N", min=1)
    starts: int = option(4, "The best of them, from which searches begin.", "N", min=1)
    restarts: int = option(3, "Times that searches begin again where more than noise is left.", "N", min=0)
    confidence: float = option(95.0, "Of the limits that are told.", "%", min=50.0, max=99.99)
    derivatives: Derivatives = option(
        Derivatives.auto, "Carried along the run, or differences of runs; auto: the former where both agree."
    )
    seed: int = option(0, "Of the points that are tried first.", min=0)
    law: str | None = option(None, "Fit this contact law to force over penetration.", "NAME")
    set_: list[str] | None = option(None, SET, "PATH=VALUE", "--set")
    target: Path | None = option(
        None, "Where to keep it.", "FILE.fit", "-o", "--output", show_default="runs/MODEL.fit"
    )
    fitted: Path | None = option(None, "Write the model with what was found.", "FITTED.toml")
    figure: Path | None = option(None, "Draw the fit.", FIGURE_FILE)
    csv: Path | None = option(None, "Write measured and model's curves.", TABLE_FILE)
    force: bool = flag("--force", "Replace the fit that is in the file.")
    yes: bool = flag("--yes", "Run whatever it takes: hours, or half the disk.")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that are read, over which nothing may be written."""
        return (*self.files, *(self.laws or ()))

    def used_options(self, *names: str) -> str:
        """Those of the options that were given, as they are written."""
        spelled = {"set_": "--set", "target": "-o"}
        return ", ".join(
            spelled.get(name, f"--{name}") for name in names if getattr(self, name) not in (None, False)
        )

    def check(self) -> None:
        """Raise ValueError for a file that cannot be written, before anything is computed."""
        refuse_endings(self.figure, self.csv, self.fitted, model_option="--fitted")
        if self.fitted is not None and self.fitted.exists():
            raise ValueError(f"--fitted {self.fitted}: there is such a file; name another")
        refuse_inputs(
            (("--figure", self.figure), ("--csv", self.csv), ("--fitted", self.fitted)), self.inputs
        )


def fit(options: FitOptions) -> None:
    """Find numbers of a model from measured curves: values with their confidence, how they hang together,
    what the data cannot tell.

    DATA.csv has time or crank_angle and channels of a result as columns (as vfife export writes them), units
    in brackets: "C.force [N]". Several records have the parameters in common; a fit plan, a TOML file with a
    table named record for each, says what each has of its own. With --law it has penetration and force, and
    unloading where it was measured.
    A forecast comes first. Every point is kept in a file: after Ctrl-C or a kill the same command goes on,
    and vfife fit FILE.fit shows it.
    """
    files, place = options.files, None
    with sentences(str(files[-1])):
        options.check()
        if len(files) == 1 and FIT.owns(files[0]):
            result: Any = load(options)
        elif options.law is not None:
            result = fit_of_law(options, options.law)
        else:
            place = place_of(options)
            result = search(options, place)
    write_files(result, options.figure, options.csv, partial(draw, result))
    if options.as_json or not options.quiet:
        from ...report.sensitivity import identification

        answer(identification(result), options.as_json)
        if place is not None and not options.as_json:
            print_line(str(place))
    if result.status == "interrupted" and place is not None:
        end_interrupted(f". What is told is the best so far, without its confidence. {NOW.saved}")


def draw(result: Fit) -> Figure:
    """The figure of a fit."""
    from ...plots.sensitivity import fit_figure

    return fit_figure(result)


def search(options: FitOptions, place: Path) -> Fit:
    """Search for the numbers of a model, with a forecast first."""
    if len(options.files) == 1:
        task = plan_of(options)
    else:
        model, *data = options.files
        mechanism = read_model(model, options.set_, options.laws)
        from ...identification.fitting import planned

        names = ("offset", "skip", "width", "step", "screened", "starts", "restarts", "seed", "own", "every")
        task = planned(
            mechanism, data, options.parameter or (), columns=options.column,
            weights=weights_of(options.weight),
            compare=options.compare.value, confidence=options.confidence / 100.0, start=options.start.value,
            derivatives=options.derivatives.value,
            **{name: getattr(options, name) for name in names},
        )  # fmt: skip
    job = CommandJob("fit", place, yes=options.yes, quiet=options.quiet)
    with job.at_work(str(place)):
        job.begin(task.forecast(place, options.force))
        result = task.run(place, job, replace=options.force)
    save_model(options.fitted, task.text, result)
    return result


def plan_of(options: FitOptions) -> FitTask:
    """The fit that a plan asks for. Raises ValueError for options that it has no use for."""
    from ...identification.fit_plan import load_plan

    if unused := options.used_options(
        "parameter", "own", "column", "weight", "offset", "width", "step", "set_", "law"
    ):
        raise ValueError(f"{unused}: a fit plan says this itself; write it there")
    take_laws(options.laws)
    return load_plan(options.files[0])


def place_of(options: FitOptions) -> Path:
    """Where a fit is kept. Raises ValueError for files that make no fit, for a place that cannot be, or that
    is of another file.
    """
    files, target = options.files, options.target
    from ...identification.fit_plan import is_plan

    if len(files) < 2 and not is_plan(files[0]):
        raise ValueError(no_pair(files))
    if options.width is not None and options.compare is not Compared.envelope:
        raise ValueError("--width: it is the window of an envelope; add --compare envelope, or leave it out")
    place = target if target is not None else RUNS / f"{files[0].stem}.fit"
    if place.suffix.lower() == ".toml":
        raise ValueError(
            f"-o {place}: a fit file is kept here; the model with what was found is written by --fitted"
            f" {place}"
        )
    if place.is_dir() or place.suffix.lower() in (*PICTURES, *TABLES):
        raise ValueError(
            f"-o {place}: a fit file is kept here; name a file that ends otherwise, as in"
            f" {place.stem or 'model'}.fit"
        )
    if place.exists() and not FIT.owns(place):
        raise ValueError(
            f"-o {place}: there is something else of this name, which is no fit file; name another one"
        )
    if target is not None:
        refuse_folder("-o", place)
    refuse_inputs((("-o", place),), options.inputs)
    return place


def load(options: FitOptions) -> Fit:
    """The fit in a fit file, and the model with what was found. Raises RunFileError."""
    from ...results.fit import FitFile, load_fit

    if unused := options.used_options(
        "parameter", "own", "column", "weight", "offset", "width", "step", "set_", "target", "law", "force"
    ):
        raise ValueError(
            f"{unused}: a fit file alone is shown as it is; leave it out, or name model and data: vfife fit"
            " MODEL.toml DATA.csv ..."
        )
    result = load_fit(options.files[0])
    with FitFile.open(options.files[0]) as file:
        save_model(options.fitted, file.spec["model"], result)
    return result


def save_model(place: Path | None, text: str, result: Fit) -> None:
    """Write the model with what was found."""
    if place is None:
        return
    with sentences(str(place)), writing(str(place)):
        from ...modelfile import dump, loads

        write_text(place, dump(loads(text, set=result.set)))


def fit_of_law(options: FitOptions, law: str) -> Any:
    """A contact law fitted to a curve. Raises ValueError for options that this has no use for."""
    from ...identification.lawfit import fit_law

    if unused := options.used_options("parameter", "column", "weight", "offset", "fitted", "target"):
        raise ValueError(
            f"{unused}: a law is fitted without; leave it out (numbers of a law are fixed by --set"
            " NAME=VALUE)"
        )
    if len(options.files) != 1:
        raise ValueError("with --law name the measured curve alone: vfife fit --law NAME CURVE.csv")
    take_laws(options.laws)
    return fit_law(
        law,
        options.files[0],
        dict(overrides(options.set_)),
        confidence=options.confidence / 100.0,
        seed=options.seed,
    )


def no_pair(files: list[Path]) -> str:
    """What is wrong with one file alone that is neither a fit file nor a fit plan."""
    both = "a model and files of measured curves: vfife fit MODEL.toml DATA.csv -p PATH=A..B"
    if not files[0].exists():
        return f"there is no such file; name a file that vfife fit left, or {both}"
    try:
        refuse_kind(files[0], "fit plan")
    except FileKindError as error:
        return f"{error}, or name {both}"
    return f"this is no fit file; name one that vfife fit left, or {both}"


def weights_of(texts: list[str] | None) -> dict[str, float]:
    """Columns and weights. Raises ValueError."""
    weights = {}
    for text in texts or ():
        name, _, value = text.partition("=")
        try:
            weights[name.strip()] = float(value)
        except ValueError:
            raise ValueError(
                f"--weight {text}: this is not COLUMN=NUMBER; write it as in --weight acc=2"
            ) from None
    return weights
