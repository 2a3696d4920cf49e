"""``vfife design``: which clearance matters, which fits keep a limit, how long joints last."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...files import write_text
from ...job.job import Interrupted
from ..job import CommandJob
from ..options import JobOptions, JsonOptions, ModelOptions, option, positive
from ..outputs import refuse_ending, refuse_files, refuse_folder
from ..signals import NOT_STARTED
from ..terminal import end_interrupted, json_text, sentences, writing

if TYPE_CHECKING:
    from ...report.document import Document

ENDINGS = (".html", ".pdf", ".json")


class DesignOptions(JsonOptions, ModelOptions, JobOptions):
    """Options of ``vfife design``."""

    of: str | None = option(
        None, "Measure that matters.", "MEASURE", show_default="the largest force of a joint with clearance"
    )
    limit: str | None = option(
        None, "Largest value of it, as in 2.6kN.", "VALUE", show_default="10 % above its value"
    )
    share: float = option(0.95, "Of all machines that shall keep the limit.", "SHARE")
    cost: list[str] | None = option(
        None, "Cost of a hole or a shaft of a grade; may be repeated.", "IT7=COST", show_default="IT7 to IT9"
    )
    turns: int | None = option(None, "Turns of each run.", "N", min=1, show_default="the model's")
    wear: str | None = option(None, "Coefficient of wear for joints without a table wear.", "1/Pa")
    wear_turns: float = option(1e6, "Turns over which wear is simulated.", "N", min=1, show_default="1e6")
    clearance: str | None = option(
        None, "Clearance that ends the life of a joint.", "LENGTH", show_default="twice its own"
    )
    target: Path | None = option(
        None, "Also write a page, a document for printing or data.", "FILE.html|pdf|json", "-o", "--output"
    )


def design(options: DesignOptions) -> None:
    """Which clearance matters, which ISO fits keep a limit, and how long do joints last? One page.

    The answer consists of checked sensitivities of a measure to every clearance, of the cheapest fits of ISO
    286 with which nearly all machines keep a limit, and of wear by Archard's law for joints with a table
    wear. It names what is not known, and the command for each next step. After Ctrl-C the parts that are
    complete are shown.
    """
    with sentences(str(options.model)):
        if options.target is not None:
            refuse_ending(options.target, ENDINGS)
            refuse_folder("-o", options.target)
            refuse_files([("-o", options.target)], options.inputs)
        mechanism = options.mechanism()
        keys = {name: getattr(options, name) for name in ("limit", "share", "turns", "wear", "wear_turns")}
        keys["clearance"] = positive("--clearance", options.clearance, "m")
        keys["cost"] = costs(options.cost)
        answer = compute(options, mechanism, keys)
    from ...report.design import document

    page = document(answer, str(options.model))
    if options.target is not None:
        with writing(str(options.target)):
            write_page(page, options.target)
    options.answer(page, options.target)
    if not answer.complete:
        end_interrupted(f": {', '.join(answer.missing)} not computed.")


def compute(options: DesignOptions, mechanism: Any, keys: dict[str, Any]) -> Any:
    """Return the answer, in part after a signal."""
    from ...assessment.design_work import design as assess

    job = CommandJob("design", Path(), options, saved=NOT_STARTED)
    with job.at_work(str(options.model)):
        try:
            return assess(mechanism, options.of, **keys, progress=job)
        except Interrupted as interrupted:
            return interrupted.result


def costs(texts: list[str] | None) -> dict[str, float] | None:
    """Return the costs by grade. Raises ValueError."""
    from ...studies.engine.study_engine import split_values

    if texts is None:
        return None
    pairs = dict(pair for text in texts for pair in split_values(text, "--cost"))
    try:
        return {name: float(value) for name, value in pairs.items()}
    except ValueError:
        raise ValueError(f"--cost {', '.join(texts)}: write costs as numbers, as in IT7=5") from None


def write_page(document: Document, target: Path) -> None:
    """Write the answer as a page, a document for printing, or data, by the ending of the file."""
    if target.suffix.lower() == ".json":
        write_text(target, json_text(document.data) + "\n")
    elif target.suffix.lower() == ".pdf":
        from ...plots.pdf import write_pdf

        write_pdf(target, document, (), {})
    else:
        from ...report.html import page

        write_text(target, page(document, ()))
