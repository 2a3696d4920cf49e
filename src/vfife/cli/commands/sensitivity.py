"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path

from ...job.job import Interrupted
from ..job import CommandJob
from ..options import FileOptions, JobOptions, JsonOptions, LengthOptions, ModelOptions, option
from ..signals import NOT_STARTED
from ..terminal import end_interrupted, sentences

MEASURES = "*.force.max, *.torque.max and *.angular_acceleration.max"


class SensitivityOptions(ModelOptions, LengthOptions, FileOptions, JsonOptions, JobOptions):
    """Options of ``vfife sensitivity``."""

    of: list[str] | None = option(None, "Measures, * for any signs.", "MEASURE", show_default=MEASURES)
    to: list[str] | None = option(
        None, "Numbers of the model, * for any signs.", "PATH", show_default="all but points of tables"
    )
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
        options.refuse_files()
        mechanism = options.mechanism()
        from ...studies.methods.derivatives import sensitivity as compute

        length = {
            name: getattr(options, name) for name in ("turns", "duration", "step", "runs", "force_step")
        }
        companions = options.companions
        steps = int(companions) if companions is not None and companions.isdecimal() else companions
        job = CommandJob("sensitivity", Path(), options, saved=NOT_STARTED)
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
    options.write_files(result)
    from ...report.sensitivity import sensitivity as document

    options.answer(document(result, options.top))
    if not result.complete:
        end_interrupted(
            f": derivatives by {len(result.derivatives)} numbers are there, none of them checked."
        )
