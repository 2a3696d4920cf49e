"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...job.job import Interrupted
from ..job import CommandJob
from ..options import FileOptions, JobOptions, JsonOptions, LengthOptions, ModelOptions, option
from ..outputs import refuse_endings, refuse_inputs, write_files
from ..signals import NOTHING
from ..terminal import answer, end_interrupted, sentences

if TYPE_CHECKING:
    from ...results.derivatives import Sensitivity

MEASURES = "*.force.max, *.torque.max and *.angular_acceleration.max"


class SensitivityOptions(ModelOptions, LengthOptions, FileOptions, JsonOptions, JobOptions):
    """Options of ``vfife sensitivity``."""

    of: list[str] | None = option(None, "Measures, * for any signs.", "MEASURE", show_default=MEASURES)
    to: list[str] | None = option(None, "Numbers of the model, * for any signs.", "PATH", show_default="all")
    top: int = option(8, "So many numbers of each measure.", "N", "-n", "--top", min=1)
    runs: int | None = option(
        None,
        "So many runs with displaced steps, 1 to 8, have their mean taken.",
        "N",
        show_default="2 with contact",
    )


def sensitivity(options: SensitivityOptions) -> None:
    """Which number matters? The derivative of every measure by every number of the model, checked by finite
    changes of the number.

    Shown are elasticities: by how many per cent a measure changes with one per cent of a number. Measures are
    of the last turn. Each number is also changed by 1 % and 0.1 %, both ways, and all of it is repeated with
    steps 1.4, 1.7 and 2 times as long. The range of an elasticity covers what these runs differ by. Where
    finite changes contradict the derivative, the change for 1 % and its range stand in its place; where the
    sign is not known, a question mark.
    """
    with sentences(str(options.model)):
        refuse_endings(options.figure, options.csv)
        refuse_inputs((("--figure", options.figure), ("--csv", options.csv)), options.inputs)
        mechanism = options.mechanism()
        from ...studies.methods.derivatives import sensitivity as compute

        length = {
            name: getattr(options, name) for name in ("turns", "duration", "step", "runs", "force_step")
        }
        companions = options.companions
        steps = int(companions) if companions is not None and companions.isdecimal() else companions
        job = CommandJob("sensitivity", Path(), yes=options.yes, quiet=options.quiet, saved=NOTHING)
        with job.at_work(str(options.model)):
            try:
                result = compute(
                    mechanism,
                    options.of or None,
                    options.to or ("*",),
                    companions=steps,
                    progress=job,
                    **length,
                )
            except Interrupted as interrupted:
                result = interrupted.result
    write_files(result, options.figure, options.csv, lambda: bars(result))
    if options.as_json or not options.quiet:
        from ...report.sensitivity import sensitivity as document

        answer(document(result, options.top), options.as_json)
    if not result.complete:
        end_interrupted(
            f": derivatives by {len(result.derivatives)} numbers are there, none of them checked."
        )


def bars(result: Sensitivity) -> Any:
    """The figure of the elasticities."""
    from ...plots.sensitivity import tornado

    return tornado(result)
