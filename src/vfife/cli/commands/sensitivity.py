"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path

from ...job.job import Interrupted
from ...report.sensitivity import sensitivity as document
from ...studies.methods.derivatives import sensitivity as compute
from ..arguments.studies import SensitivityOptions
from ..job import CommandJob
from ..signals import NOT_STARTED
from ..terminal import end_interrupted, sentences
from ..values import mechanism_of


def sensitivity(options: SensitivityOptions) -> None:
    """Run ``vfife sensitivity``."""
    with sentences(str(options.model)):
        options.refuse_files()
        mechanism = mechanism_of(options)
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
    options.answer(document(result, options.top))
    if not result.complete:
        end_interrupted(
            f": derivatives by {len(result.derivatives)} numbers are there, none of them checked."
        )
