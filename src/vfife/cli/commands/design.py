"""``vfife design``: which clearance matters, which fits keep a limit, how long joints last; ``vfife
sensitivity``: which numbers of a model matter.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...assessment import design_work
from ...files import write_text
from ...job.job import Interrupted
from ...report.design import document
from ...report.design import report as design_report
from ...report.design_words import missing_parts
from ...report.document import Document, Figure
from ...report.front import Front
from ...report.html import page
from ...report.sensitivity import sensitivity as sensitivity_document
from ...studies.engine.study_engine import split_values
from ...studies.methods.derivatives import sensitivity as derive
from ..arguments.studies import DesignOptions, SensitivityOptions
from ..job import CommandJob
from ..outputs import refuse_ending, refuse_existing, refuse_files
from ..signals import ANSWER_GRACE, DISCARDED_ANSWER, ENDING
from ..terminal import end_interrupted, json_text, sentences, writing
from ..values import clearance_limit, mechanism_of, separated

ENDINGS = (".html", ".pdf", ".json")


def design(options: DesignOptions) -> None:
    """Run ``vfife design``."""
    if options.target is not None:
        with sentences(f"-o {options.target}"):
            refuse_ending(options.target, ENDINGS)
            refuse_files([("-o", options.target)], options.inputs)
            refuse_existing(options.target, options.force)
    with sentences(str(options.model)):
        front = Front(options.author, logo=options.logo)
        front.picture()
        mechanism = mechanism_of(options)
        keys = {
            name: getattr(options, name)
            for name in ("limit", "share", "turns", "wear", "wear_turns", "same_fit", "ranking")
        }
        keys["joints"] = (
            None if options.joints is None else [name.strip() for name in options.joints.split(",")]
        )
        keys["clearance"] = clearance_limit(options.clearance, mechanism)
        keys["cost"] = costs(options.cost)
        answer = compute(options, mechanism, keys)
    page = document(answer, str(options.model))
    if options.target is not None:
        with writing(str(options.target)):
            write_page(page, answer, options, front)
    options.answer(page, options.target)
    if not answer.complete:
        force = "" if options.target is None or options.force else " with --force"
        end_interrupted(f": {missing_parts(answer)} not computed. The same command{force} begins again.")


def compute(options: DesignOptions, mechanism: Any, keys: dict[str, Any]) -> Any:
    """Return the answer, in part after a signal."""
    job = CommandJob("design", Path(), options, saved=DISCARDED_ANSWER)
    ENDING.grace = ANSWER_GRACE
    with job.at_work(str(options.model)):
        try:
            return design_work.design(mechanism, options.of, **keys, progress=job)
        except Interrupted as interrupted:
            return interrupted.result


def costs(texts: list[str] | None) -> dict[str, float] | None:
    """Return the costs by grade. Raises ValueError."""
    if texts is None:
        return None
    pairs = dict(pair for text in texts for pair in split_values(text, "--cost"))
    try:
        return {name: float(value) for name, value in pairs.items()}
    except ValueError:
        raise ValueError(f"--cost {', '.join(texts)}: write costs as numbers, as in IT7=5") from None


def write_page(document: Document, answer: Any, options: DesignOptions, front: Front) -> None:
    """Write the answer as a page, a document for printing, or data, by the ending of the file."""
    target = options.target or Path()
    if target.suffix.lower() == ".json":
        write_text(target, json_text(document.data) + "\n")
        return
    from ...plots import at_start
    from ...plots.notebook import sharp
    from ...plots.pdf import write_pdf

    title, drawing = "The mechanism", at_start(answer.mechanism)
    report = design_report(answer, str(options.model), Figure(title, lambda: sharp(drawing, title)))
    introduction = [text for text in (front.line, answer.mechanism.note, f"Model: {options.model}") if text]
    if target.suffix.lower() == ".pdf":
        logo = front.picture()
        write_pdf(target, report, introduction, {title: drawing}, logo[0] if logo else None, front.author)
    else:
        write_text(target, page(report, introduction, head=front.element().html))


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
        job = CommandJob("sensitivity", Path(), options, saved=DISCARDED_ANSWER)
        ENDING.grace = ANSWER_GRACE
        with job.at_work(str(options.model)):
            try:
                result = derive(
                    mechanism,
                    separated(options.of, mechanism) or None,
                    separated(options.to, mechanism) or ("*",),
                    companions=steps,
                    progress=job,
                    **length,
                )
            except Interrupted as interrupted:
                result = interrupted.result
    options.write_files(result)
    options.answer(sensitivity_document(result, options.top))
    if not result.complete:
        end_interrupted(
            f": derivatives by {len(result.derivatives)} numbers are available, none of them checked."
        )
