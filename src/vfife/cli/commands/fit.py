"""``vfife fit``: numbers of a model from measured curves, or those of a contact law from a measured force
over penetration.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...files import write_text
from ...store.schemas import FIT
from ..job import FIGURES, RUNS, CommandJob, refuse_endings
from ..options import JsonOption, LawsOption, SetOption, overrides, read_model, refuse_inputs, take_laws
from ..signals import NOW
from ..terminal import answer, print_line, sentences, tell, writing
from .run import Quiet, Step

if TYPE_CHECKING:
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


Files = Annotated[
    list[Path],
    typer.Argument(
        metavar="MODEL.toml DATA.csv",
        help="Model and measured curves; with --law the curve alone; or a fit file.",
    ),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option(
        "-p",
        "--parameter",
        metavar="PATH=A..B",
        help='What is looked for, and between which bounds: joint.C.clearance="0.1..1 mm".',
    ),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        "-c",
        "--column",
        metavar="COLUMN=CHANNEL",
        help="Which channel a column is; COLUMN~CHANNEL: only proportional to it.",
    ),
]
Weights = Annotated[
    list[str] | None,
    typer.Option("--weight", metavar="COLUMN=W", help="Weight of a column's residuals.", show_default="1"),
]
OffsetOption = Annotated[
    str | None,
    typer.Option(
        metavar="A..B",
        help="Where the first sample lies: free (in a turn), a number or two bounds.",
        show_default="free over time",
    ),
]
Skip = Annotated[
    float,
    typer.Option(metavar="TURNS", min=0.0, help="Turns before the data may begin, where the offset is free."),
]
Compare = Annotated[
    Compared, typer.Option(help="The curves, or of motions that do not repeat their envelope or spectrum.")
]
Width = Annotated[
    str | None,
    typer.Option(metavar="SPAN", help="Window of the envelope.", show_default="a fiftieth of the data"),
]
Screened = Annotated[int, typer.Option(metavar="N", min=1, help="Points that are tried first.")]
Starts = Annotated[int, typer.Option(metavar="N", min=1, help="The best of them, from which searches begin.")]
Confidence = Annotated[
    float, typer.Option(metavar="%", min=50.0, max=99.99, help="Of the limits that are told.")
]
By = Annotated[
    Derivatives,
    typer.Option(help="Carried along the run, or differences of runs; auto: the former where both agree."),
]
Law = Annotated[
    str | None, typer.Option("--law", metavar="NAME", help="Fit this contact law to force over penetration.")
]
Figure = Annotated[
    Path | None,
    typer.Option("--figure", metavar="FILE.png|svg|pdf", help="Draw the fit.", show_default=False),
]
Table = Annotated[
    Path | None,
    typer.Option("--csv", metavar="FILE.csv", help="Write measured and model's curves.", show_default=False),
]
Target = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="FILE.fit", help="Where to keep it.", show_default="runs/MODEL.fit"
    ),
]
Model = Annotated[
    Path | None,
    typer.Option(
        "--fitted", metavar="FITTED.toml", help="Write the model with what was found.", show_default=False
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace the fit that is in the file.")]
Yes = Annotated[bool, typer.Option("--yes", help="Run whatever it takes: hours, or half the disk.")]


def fit(
    files: Files,
    parameter: Parameters = None,
    column: Columns = None,
    weight: Weights = None,
    offset: OffsetOption = None,
    skip: Skip = 3.0,
    compare: Compare = Compared.curve,
    width: Width = None,
    step: Step = None,
    screened: Screened = 64,
    starts: Starts = 4,
    confidence: Confidence = 95.0,
    derivatives: By = Derivatives.auto,
    seed: Annotated[int, typer.Option(min=0, help="Of the points that are tried first.")] = 0,
    law: Law = None,
    set_: SetOption = None,
    laws: LawsOption = None,
    target: Target = None,
    model: Model = None,
    figure: Figure = None,
    csv: Table = None,
    force: Force = False,
    yes: Yes = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Find numbers of a model from measured curves: values with their confidence, how they hang together,
    what the data cannot tell.

    DATA.csv has time or crank_angle and channels of a result as columns (as vfife export writes them), units
    in brackets: "C.force [N]". With --law it has penetration and force, and unloading where it was measured.
    A forecast comes first. Every point is kept in a file: after Ctrl-C or a kill the same command goes on,
    and vfife fit FILE.fit shows it.
    """
    kept = len(files) == 1 and FIT.owns(files[0])
    with sentences(str(files[-1])):
        check_targets(figure, csv, model)
        refuse_inputs((("--figure", figure), ("--csv", csv), ("--fitted", model)), (*files, *(laws or ())))
        if kept:
            refuse_beside_file(parameter, column, weight, offset, width, step, set_, target, law, force)
            found: Any = shown(files[0], model)
        elif law is not None:
            refuse_beside_law(parameter, column, weight, offset, model, target)
            found = of_law(files, law, set_, laws, confidence / 100.0, seed)
    if law is None and not kept:
        with sentences(str(files[-1])):
            if len(files) != 2:
                raise ValueError(few_or_many(files))
            if width is not None and compare is not Compared.envelope:
                raise ValueError(
                    "--width: it is the window of an envelope; add --compare envelope, or leave it out"
                )
            place = placed(files[0], target, force, (*files, *(laws or ())))
            mechanism = read_model(files[0], set_, laws)
            from ...identification.fitting import planned

            task = planned(
                mechanism, files[1], parameter or (), columns=column, weights=weights_of(weight), offset=offset, skip=skip,
                compare=compare.value, width=width, step=step, screened=screened, starts=starts, confidence=confidence / 100.0,
                derivatives=derivatives.value, seed=seed,
            )  # fmt: skip
        job = CommandJob("fit", place, yes=yes, quiet=quiet)
        with job.at_work(str(place)):
            job.begin(task.forecast(place, force))
            found = task.run(place, job, replace=force)
        save_fitted(model, task.text, found)
    told(found, None if law is not None or kept else place, figure, csv, as_json, quiet)


def told(
    found: Fit, place: Path | None, figure: Path | None, csv: Path | None, as_json: bool, quiet: bool
) -> None:
    """Writes and says what was found; ``place`` is where a fit that was under way is kept."""
    write(found, figure, csv)
    if as_json or not quiet:
        from ...report.sensitivity import identification

        answer(identification(found), as_json)
        if place is not None and not as_json:
            print_line(str(place))
    if found.status == "interrupted" and place is not None:
        tell("interrupted", f"{NOW.by}. What is told is the best so far, without its confidence. {NOW.saved}")
        raise typer.Exit(NOW.code)


def placed(model: Path, target: Path | None, force: bool, inputs: tuple[Path, ...]) -> Path:
    """Where a fit is kept. Raises ValueError for a place that cannot be, or that is of another file."""
    place = target if target is not None else RUNS / f"{model.stem}.fit"
    if place.suffix.lower() == ".toml":
        raise ValueError(
            f"-o {place}: a fit file is kept here; the model with what was found is written by --fitted"
            f" {place}"
        )
    if place.is_dir() or place.suffix.lower() in (*FIGURES, ".csv"):
        raise ValueError(
            f"-o {place}: a fit file is kept here; name a file that ends otherwise, as in"
            f" {place.stem or 'model'}.fit"
        )
    if place.exists() and not FIT.owns(place):
        raise ValueError(
            f"-o {place}: there is something else of this name, which is no fit file; name another one"
        )
    if target is not None and not place.absolute().parent.is_dir():
        raise ValueError(f"-o {place}: there is no folder {place.absolute().parent}; make it first")
    refuse_inputs((("-o", place),), inputs)
    return place


def shown(file: Path, model: Path | None) -> Fit:
    """The fit in a fit file, and the model with what was found. Raises RunFileError."""
    from ...results.fit import FitFile, load_fit

    found = load_fit(file)
    with FitFile.open(file) as kept:
        save_fitted(model, kept.spec["model"], found)
    return found


def save_fitted(place: Path | None, text: str, found: Fit) -> None:
    """Writes the model with what was found."""
    if place is None:
        return
    with sentences(str(place)), writing(str(place)):
        from ...modelfile import dump, loads

        write_text(place, dump(loads(text, set=found.set)))


def of_law(
    files: list[Path], law: str, set_: list[str] | None, laws: list[Path] | None, confidence: float, seed: int
) -> Any:
    """A contact law fitted to a curve."""
    from ...identification.lawfit import fit_law

    if len(files) != 1:
        raise ValueError("with --law name the measured curve alone: vfife fit --law NAME CURVE.csv")
    take_laws(laws)
    return fit_law(law, files[0], dict(overrides(set_)), confidence=confidence, seed=seed)


def refuse_beside_law(
    parameter: list[str] | None,
    column: list[str] | None,
    weight: list[str] | None,
    offset: str | None,
    model: Path | None,
    target: Path | None,
) -> None:
    """Raises ValueError for options that the fit of a law has no use for."""
    given = {
        "--parameter": parameter,
        "--column": column,
        "--weight": weight,
        "--offset": offset,
        "--fitted": model,
        "-o": target,
    }
    if said := idle(given):
        raise ValueError(
            f"{said}: a law is fitted without; leave it out (numbers of a law are fixed by --set NAME=VALUE)"
        )


def refuse_beside_file(
    parameter: list[str] | None, column: list[str] | None, weight: list[str] | None, offset: str | None, width: str | None, step: str | None,
    set_: list[str] | None, target: Path | None, law: str | None, force: bool,
) -> None:  # fmt: skip
    """Raises ValueError for options that a fit which is only shown has no use for."""
    given = {
        "--parameter": parameter, "--column": column, "--weight": weight, "--offset": offset, "--width": width, "--step": step, "--set": set_,
        "-o": target, "--law": law, "--force": force or None,
    }  # fmt: skip
    if said := idle(given):
        raise ValueError(
            f"{said}: a fit file alone is shown as it is; leave it out, or name model and data: vfife fit"
            " MODEL.toml DATA.csv ..."
        )


def idle(given: Mapping[str, object]) -> str:
    """Names of the options that were given."""
    return ", ".join(option for option, value in given.items() if value is not None)


def few_or_many(files: list[Path]) -> str:
    """What is wrong with one file alone that is no fit file, or with more than two."""
    both = "a model and a file of measured curves: vfife fit MODEL.toml DATA.csv -p PATH=A..B"
    if len(files) > 1:
        return f"{len(files)} files are named; name {both}"
    if not files[0].exists():
        return f"there is no such file; name a file that vfife fit left, or {both}"
    return f"this is no fit file; name one that vfife fit left, or {both}"


def check_targets(figure: Path | None, csv: Path | None, model: Path | None) -> None:
    """Raises ValueError for a file that cannot be written, before anything is computed."""
    refuse_endings(
        (("--figure", figure, FIGURES), ("--csv", csv, (".csv",)), ("--fitted", model, (".toml",))),
        in_folder=True,
    )
    if model is not None and model.exists():
        raise ValueError(f"--fitted {model}: there is such a file; name another")


def weights_of(texts: list[str] | None) -> dict[str, float]:
    """Columns and weights. Raises ValueError."""
    found = {}
    for text in texts or ():
        name, _, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise ValueError(
                f"--weight {text}: this is not COLUMN=NUMBER; write it as in --weight acc=2"
            ) from None
    return found


def write(found: Fit, figure: Path | None, csv: Path | None) -> None:
    """The files that were asked for."""
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if figure is not None:
        with writing(str(figure)):
            from ...plots.style import saved

            saved(found.plot(), figure)
