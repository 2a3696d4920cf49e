"""``vfife fit``: numbers of a model from measured curves, or those of a contact law from a measured force
over penetration.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...files import write_text
from ...files.kinds import FileKindError, refuse_kind
from ...identification.fit_plan import is_plan, load_plan
from ...identification.fit_task import FitTask, plan_fit
from ...identification.lawfit import fit_law
from ...job.activity import ACTIVITY
from ...modelfile import dump, loads
from ...report.sensitivity import identification
from ...results.fit import Fit, FitFile, load_fit
from ...schema import Measure
from ...store.schemas import FIT
from ...units import assignments
from ..arguments.analyses import FitOptions
from ..job import CommandJob
from ..outputs import answer_file
from ..signals import ENDING
from ..terminal import end_interrupted, sentences, writing
from ..values import overrides, read_model, take_laws, tell_cautions, value_of_option

# Options that say what is fitted, which a fit plan and a fit file say themselves.
TASK = ("parameter", "own", "column", "weight", "offset", "width", "step", "set_")


def fit(options: FitOptions) -> None:
    """Run ``vfife fit``."""
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
            ACTIVITY("reading the data, assembling the model and forecasting the fit")
            place, task = place_of(options), task_of(options)
            tell_cautions(task.mechanism)
            job = CommandJob("fit", place, options)
            with job.at_work(str(place)):
                job.begin(task.forecast(place, options.force))
                result = task.run(place, job, replace=options.force)
            save_model(options.fitted, task.text, result)
    options.write_files(result)
    options.answer(identification(result), *([place] if place is not None else []))
    if result.status == "interrupted" and place is not None:
        end_interrupted(f". The result is the best point so far, without its confidence. {ENDING.saved}")


def task_of(options: FitOptions) -> FitTask:
    """Return the fit of a model to data, or that of a plan. Raises ValueError."""
    model, *data = options.files
    if not data and is_plan(model):
        refuse_options(options, (*TASK, "law"), "a fit plan contains this; write it there")
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
    usage = "a model and files of measured curves: vfife fit MODEL.toml DATA.csv -p PATH=A..B"
    if not file.exists():
        return f"there is no such file; name a file that vfife fit wrote, or {usage}"
    try:
        refuse_kind(file, "fit plan")
    except FileKindError as error:
        return f"{error}, or name {usage}"
    return f"this is not a fit file; name one that vfife fit wrote, or {usage}"


def load(options: FitOptions) -> Fit:
    """Return the fit in a fit file, and write the model with what was found. Raises RunFileError."""
    pair = "leave it out, or name model and data: vfife fit MODEL.toml DATA.csv ..."
    refuse_options(options, (*TASK, "target", "law", "force"), f"a fit file alone is shown as it is; {pair}")
    result = load_fit(options.files[0])
    with FitFile.open(options.files[0]) as file:
        save_model(options.fitted, file.spec["model"], result)
    return result


def save_model(place: Path | None, text: str, result: Fit) -> None:
    """Write the model with what was found."""
    if place is None:
        return
    with sentences(str(place)), writing(str(place)):
        write_text(place, dump(loads(text, set=result.set)))


def fit_of_law(options: FitOptions, law: str) -> Any:
    """Return a contact law fitted to a curve. Raises ValueError for options that this has no use for."""
    fixed = "the fit of a law does not use this; leave it out (--set NAME=VALUE fixes parameters of a law)"
    refuse_options(options, ("parameter", "column", "weight", "offset", "fitted", "target"), fixed)
    if len(options.files) != 1:
        raise ValueError("with --law name the measured curve alone: vfife fit --law NAME CURVE.csv")
    confidence, parameters = options.confidence / 100.0, dict(overrides(options.set_))
    return fit_law(law, options.files[0], parameters, confidence=confidence, seed=options.seed)


def refuse_options(options: FitOptions, names: tuple[str, ...], reason: str) -> None:
    """Raise ValueError where some of the options are used."""
    spelled = {"set_": "--set", "target": "-o"}
    used = [spelled.get(name, f"--{name}") for name in names if getattr(options, name) not in (None, False)]
    if used:
        raise ValueError(f"{', '.join(used)}: {reason}")


def place_of(options: FitOptions) -> Path:
    """Return the file of the fit. Raises ValueError for one that cannot be."""
    target = options.target
    if target is not None and target.suffix.lower() == ".toml":
        reason = "this names the fit file; to write the model with the identified values, use --fitted"
        raise ValueError(f"-o {target}: {reason} {target}")
    place = answer_file(FIT, target, options.files[0])
    options.refuse_files(("-o", place))
    return place
