"""``vfife fit``: numbers of a model from measured curves, or those of a contact law from a measured force
over penetration.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...files import write_text
from ...files.kinds import FileKindError, refuse_kind
from ...store.schemas import FIT
from ..job import CommandJob
from ..options import (
    OF_MODEL,
    SET,
    FileOptions,
    JobOptions,
    JsonOptions,
    LawOptions,
    argument,
    flag,
    option,
    overrides,
    read_model,
    take_laws,
    value_of_option,
)
from ..outputs import answer_file
from ..signals import ENDING
from ..terminal import end_interrupted, sentences, writing

if TYPE_CHECKING:
    from ...identification.fit_task import FitTask
    from ...results.fit import Fit

# Options that say what is fitted, which a fit plan and a fit file say themselves.
TASK = ("parameter", "own", "column", "weight", "offset", "width", "step", "set_")
Compared = StrEnum("Compared", "curve envelope spectrum")
Derivatives = StrEnum("Derivatives", "auto tangents differences")
StartOf = StrEnum("StartOf", "model data")


class FitOptions(FileOptions, LawOptions, JsonOptions, JobOptions):
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
    force: bool = flag("--force", "Replace the fit that is in the file.")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that are read, over which nothing may be written."""
        return (*self.files, *(self.laws or ()))

    def refuse(self, names: tuple[str, ...], reason: str) -> None:
        """Raise ValueError where some of the options are used."""
        spelled = {"set_": "--set", "target": "-o"}
        used = [spelled.get(one, f"--{one}") for one in names if getattr(self, one) not in (None, False)]
        if used:
            raise ValueError(f"{', '.join(used)}: {reason}")

    def place(self) -> Path:
        """Return the file of the fit. Raises ValueError for one that cannot be."""
        target = self.target
        if target is not None and target.suffix.lower() == ".toml":
            what = "a fit file is kept here; the model with what was found is written by --fitted"
            raise ValueError(f"-o {target}: {what} {target}")
        place = answer_file(FIT, target, self.files[0])
        self.refuse_files(("-o", place))
        return place


def fit(options: FitOptions) -> None:
    """Find numbers of a model from measured curves: values with their confidence and correlations, and
    what the data cannot decide.

    DATA.csv has time or crank_angle and channels of a result as columns (as vfife export writes them), units
    in brackets: "C.force [N]". Several records have the parameters in common; a fit plan, a TOML file with a
    table named record for each, says what each has of its own. With --law it has penetration and force, and
    unloading where it was measured.
    A forecast comes first. Every point is kept in a file: after Ctrl-C or a kill the same command goes on,
    and vfife fit FILE.fit shows it.
    """
    files, place = options.files, None
    with sentences(str(files[-1])):
        options.refuse_files(("--fitted", options.fitted))
        if options.fitted is not None and options.fitted.exists():
            raise ValueError(f"--fitted {options.fitted}: there is such a file; name another")
        take_laws(options.laws)
        if len(files) == 1 and FIT.owns(files[0]):
            result: Any = load(options)
        elif options.law is not None:
            result = fit_of_law(options, options.law)
        else:
            place, task = options.place(), task_of(options)
            job = CommandJob("fit", place, options)
            with job.at_work(str(place)):
                job.begin(task.forecast(place, options.force))
                result = task.run(place, job, replace=options.force)
            save_model(options.fitted, task.text, result)
    options.write_files(result)
    from ...report.sensitivity import identification

    options.answer(identification(result), *([place] if place is not None else []))
    if result.status == "interrupted" and place is not None:
        end_interrupted(f". The values are the best so far, without confidence limits. {ENDING.saved}")


def task_of(options: FitOptions) -> FitTask:
    """Return the fit of a model to data, or that of a plan. Raises ValueError."""
    from ...identification.fit_plan import is_plan, load_plan
    from ...identification.fit_task import plan_fit
    from ...schema import Measure
    from ...units import assignments

    model, *data = options.files
    if not data and is_plan(model):
        options.refuse((*TASK, "law"), "a fit plan says this itself; write it there")
        return load_plan(model)
    if not data:
        raise ValueError(no_pair(model))
    if options.width is not None and options.compare != "envelope":
        raise ValueError("--width: it is the window of an envelope; add --compare envelope, or leave it out")
    weights = assignments("--weight", options.weight, "acc=2", "not COLUMN=NUMBER")
    names = ("offset", "skip", "width", "step", "screened", "starts", "restarts", "seed", "own", "every")
    return plan_fit(
        read_model(model, options.set_, None), data, options.parameter or (), columns=options.column,
        weights={name: value_of_option(f"--weight {name}", Measure("1"), text) for name, text in weights},
        confidence=options.confidence / 100.0,
        **{name: getattr(options, name).value for name in ("compare", "start", "derivatives")},
        **{name: getattr(options, name) for name in names},
    )  # fmt: skip


def no_pair(file: Path) -> str:
    """Return what is wrong with one file alone that is neither a fit file nor a fit plan."""
    both = "a model and files of measured curves: vfife fit MODEL.toml DATA.csv -p PATH=A..B"
    if not file.exists():
        return f"there is no such file; name a file that vfife fit left, or {both}"
    try:
        refuse_kind(file, "fit plan")
    except FileKindError as error:
        return f"{error}, or name {both}"
    return f"this is no fit file; name one that vfife fit left, or {both}"


def load(options: FitOptions) -> Fit:
    """Return the fit in a fit file, and write the model with what was found. Raises RunFileError."""
    from ...results.fit import FitFile, load_fit

    pair = "leave it out, or name model and data: vfife fit MODEL.toml DATA.csv ..."
    options.refuse((*TASK, "target", "law", "force"), f"a fit file alone is shown as it is; {pair}")
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
    """Return a contact law fitted to a curve. Raises ValueError for options that this has no use for."""
    from ...identification.lawfit import fit_law

    fixed = "a law is fitted without; leave it out (numbers of a law are fixed by --set NAME=VALUE)"
    options.refuse(("parameter", "column", "weight", "offset", "fitted", "target"), fixed)
    if len(options.files) != 1:
        raise ValueError("with --law name the measured curve alone: vfife fit --law NAME CURVE.csv")
    confidence, parameters = options.confidence / 100.0, dict(overrides(options.set_))
    return fit_law(law, options.files[0], parameters, confidence=confidence, seed=options.seed)
