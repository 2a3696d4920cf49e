"""A mechanism that runs in the cell of a notebook, and in the page that the notebook is exported to."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path

from ..errors import VfifeError
from ..files import write_text
from ..model.mechanism import Mechanism
from ..plots.notebook import pictures
from ..report.pages import run_page
from ..result import Result
from .page import live_page, result_page
from .sliders import asked_slides, default_slides

HEIGHT = 720  # pixels of a cell
LARGEST_REPORT = 4_000_000  # bytes


class Live:
    """A page in which a mechanism runs: shown by a notebook as the last line of a cell, kept by :meth:`save`. ``page`` is its text."""

    def __init__(self, page: str, name: str) -> None:
        self.page, self.name = page, name

    def __repr__(self) -> str:
        return (
            f"{self.name}, running, in {len(self.page.encode('utf-8')):,} bytes: the last line of a notebook's cell shows it, save(path) keeps it"
        )

    def _repr_html_(self) -> str:
        """What a notebook shows: the page in a frame that has no access to the notebook."""
        words = f"{self.name}, running"
        look = f"width: 100%; height: {HEIGHT}px; border: 1px solid #8884; border-radius: 6px"
        inside = f'sandbox="allow-scripts allow-downloads" srcdoc="{escape(self.page)}"'
        return f'<iframe title="{escape(words)}" style="{look}" {inside}></iframe>'

    def save(self, path: str | Path) -> None:
        """Writes the page; what is there gives way when it is whole. Raises OSError where it cannot be written."""
        write_text(Path(path), self.page)


def live(mechanism: Mechanism, slide: Iterable[str] | None = None, step: float | None = None) -> Live:
    """The mechanism running. ``slide``: ranges as in "joint.C.clearance=0.01..0.5mm", None for the usual sliders; ``step`` (s) is that of a run.

    Raises VfifeError for what cannot run in a page, ModelError and AssemblyError for what cannot run at all, ValueError for a slide that is none.
    """
    still = mechanism.settings.analysis == "static" and not slide
    slides = [] if still else default_slides(mechanism) if slide is None else asked_slides(mechanism, [slide] if isinstance(slide, str) else slide)
    return Live(live_page(mechanism, slides, step), str(mechanism.name))


def live_result(result: Result, slide: Iterable[str] | None = ()) -> Live:
    """The mechanism of a result, running with its step; of a static analysis its equilibria. Raises as :func:`live` does."""
    assembly = result.record.assembly
    if result.record.static and not slide:
        return Live(result_page(result), str(assembly.mechanism.name))
    return live(assembly.mechanism, slide, assembly.choice.step)


def reported(result: Result, running: bool = True) -> tuple[str, list[str]]:
    """The report of a result as one page, and sentences why the mechanism does not run in it where it was to."""
    mechanism, notes, page = result.record.assembly.mechanism, [], None
    if running:
        try:
            page = result_page(result)  # sliders take long to find: vfife live has them
        except VfifeError as error:
            notes.append(f"the mechanism does not run in the report: {error}.")
    drawn = pictures(result)
    text = run_page(result, drawn, page, mechanism.source)
    if len(text.encode("utf-8")) > LARGEST_REPORT and page is not None:
        notes.append("the page in which the mechanism runs is left out: with it the report would be too large.")
        text = run_page(result, drawn, None, mechanism.source)
    return text, notes


def report(result: Result, path: str | Path, running: bool = True) -> None:
    """Writes the report; what is there gives way when it is whole."""
    write_text(Path(path), reported(result, running)[0])
