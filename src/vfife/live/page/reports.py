"""Reports of runs and studies with a running mechanism; a case of a study is a position of the sliders."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ...errors import VfifeError
from ...files import path_of, write_text
from ...laws.stored import standing_in
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import loads
from ...plots.notebook import pictures as run_pictures
from ...plots.notebook import reported_figures
from ...plots.pdf import write_pdf
from ...plots.study import pictures, reported
from ...report import pages
from ...report.front import Front
from ...report.parts import Figure
from ...report.study import case_words
from ...results.study import Study
from ...simulation.result import Result
from ...solvers.status import Status
from ...store.studyfile import StudyCase
from .page import page_with_sliders, result_page
from .patches import GROUP_COMBINATIONS, SliderPatches, slider_patches
from .sliders import Slide

LARGEST_REPORT = 4_000_000  # bytes
CASE = "case"
MOST_CASES = 60  # of a slider over cases
Places = dict[int, dict[str, int]]


@dataclass(frozen=True)
class Cases(Slide):
    """A slider over cases: each position sets all numbers of one case; ``values`` are indices into
    ``picked``.
    """

    picked: tuple[Mapping[str, Any], ...] = ()
    words: tuple[str, ...] = ()

    @property
    def labels(self) -> tuple[str, ...]:
        """The parameter values of each case."""
        return tuple(self.words[int(value)] for value in self.values)

    def changes(self, position: int) -> list[tuple[str, Any]]:
        """Return the numbers of the case at a position."""
        return list(self.picked[int(self.values[position])].items())


class StudyPage(NamedTuple):
    """A page that runs cases of a study: ``places`` are the slider positions by case."""

    text: str
    places: Places
    notes: tuple[str, ...]


def study_page(study: Study) -> StudyPage:
    """Return the page of a study.

    All cases run with the number of steps per turn of the finest one, so a coarser case may differ from the
    study by its step error. Raises VfifeError if no case can run in a page.
    """
    done = [case for case in study.done if study.outcomes[case.number]["status"] == Status.COMPLETE]
    if not done:
        raise VfifeError("no case is complete yet")
    base = mechanism(study, done[0])
    turn = turn_of(base)
    steps = max(
        study.outcomes[case.number]["steps"] / max(study.outcomes[case.number]["turns"], 1) for case in done
    )
    if turn is None or not steps:
        raise VfifeError("its cases do not turn a crank evenly")
    slides: list[Slide] = list(by_parameters(study, done)) or [over_cases(study, slider_cases(study, done))]
    with standing_in(study.request["own_laws"]):
        patches = slider_patches(base, slides, turn / math.ceil(steps))
    return StudyPage(page_with_sliders(patches), places(study, patches), patches.notes)


def study_report(
    study: Study, live: bool = True, author: str = "", logo: str | Path | None = None
) -> tuple[str, tuple[str, ...]]:
    """Return the report of a study by an ``author``, with a ``logo``, and sentences on what it lacks."""
    front = Front(author, logo=logo)
    drawn = pictures(study)
    page = pages.study_page(study, drawn, front=front)
    if not live:
        return page, ()
    try:
        full = pages.study_page(study, drawn, *study_page(study), front=front)
    except VfifeError as error:
        return page, (f"no case runs in the report: {str(error).rstrip(chr(46))}.",)
    if len(full.encode("utf-8")) > LARGEST_REPORT:
        return page, ("the page in which a case runs is left out: with it the report would be too large.",)
    return full, ()


def mechanism(study: Study, case: StudyCase) -> Mechanism:
    """Return the mechanism of a case; user laws are those recorded in the file."""
    with standing_in(study.request["own_laws"]):
        return loads(study.request["text"], list(case.numbers.items()))


def by_parameters(study: Study, done: list[StudyCase]) -> list[Slide]:
    """Return a slider for each parameter if the cases form a grid of numbers that is not too large, else
    none.
    """
    axes = study.axes
    numbers = all(
        parameter.name in axes and not any(isinstance(value, str) for value in axes[parameter.name])
        for parameter in study.parameters
    )
    if not numbers or math.prod(len(values) for values in axes.values()) > GROUP_COMBINATIONS:
        return []
    first = dict(zip((parameter.name for parameter in study.parameters), study.at(done[0]), strict=True))
    return [
        Slide(
            parameter.name,
            parameter.paths,
            parameter.unit,
            tuple(axes[parameter.name]),
            axes[parameter.name].index(first[parameter.name]),
            complete=True,
        )
        for parameter in study.parameters
        if len(axes[parameter.name]) > 1
    ]


def slider_cases(study: Study, done: list[StudyCase]) -> list[StudyCase]:
    """Return the cases for a slider: the first, those with the extremes of each measure, and others evenly
    spaced.
    """
    if len(done) <= MOST_CASES:
        return done
    numbers = {done[0].number}
    for name in study.measures:
        values = [(study.outcomes[case.number]["measures"].get(name, math.nan), case.number) for case in done]
        finite = [pair for pair in values if math.isfinite(pair[0])]
        numbers |= {min(finite)[1], max(finite)[1]} if finite else set()
    for k in range(MOST_CASES):
        if len(numbers) < MOST_CASES:
            numbers.add(done[k * (len(done) - 1) // (MOST_CASES - 1)].number)
    return [case for case in done if case.number in numbers]


def over_cases(study: Study, picked: list[StudyCase]) -> Slide:
    """Return one slider over cases."""
    words = tuple(f"{case.number}: {case_words(study, case)}" for case in picked)
    return Cases(
        CASE,
        (),
        "1",
        tuple(float(k) for k in range(len(picked))),
        0,
        True,
        picked=tuple(case.numbers for case in picked),
        words=words,
    )


def places(study: Study, patches: SliderPatches) -> Places:
    """Return the slider positions of the cases that the page can run."""
    places: Places = {}
    slides = {slide.name: slide for slide in patches.slides}
    if isinstance(slides.get(CASE), Cases):
        slide: Any = slides[CASE]
        numbers = {tuple(sorted(case.numbers.items())): case.number for case in study.cases}
        return {
            numbers[tuple(sorted(slide.picked[int(value)].items()))]: {CASE: k}
            for k, value in enumerate(slide.values)
        }
    free = [
        parameter.name
        for parameter in study.parameters
        if parameter.name not in slides and len(study.axes.get(parameter.name, ())) > 1
    ]
    for case in study.cases if not free else ():
        at = dict(zip((parameter.name for parameter in study.parameters), study.at(case), strict=True))
        if all(at[name] in slide.values for name, slide in slides.items()):
            places[case.number] = {
                name: slide.values.index(float(at[name])) for name, slide in slides.items()
            }
    return places


def run_report(result: Result, running: bool = True, front: Front | None = None) -> tuple[str, list[str]]:
    """Return the report of a result as HTML, and sentences on why the mechanism does not run in it.

    ``front`` has author and logo.
    """
    mechanism, notes, page = result.record.assembly.mechanism, [], None
    if running:
        try:
            page = result_page(result)  # sliders take long to find: vfife live has them
        except VfifeError as error:
            notes.append(f"the mechanism does not run in the report: {error}.")
    drawn = run_pictures(result)
    text = pages.run_page(result, drawn, page, mechanism.source, front)
    if len(text.encode("utf-8")) > LARGEST_REPORT and page is not None:
        notes.append(
            "the page in which the mechanism runs is left out: with it the report would be too large."
        )
        text = pages.run_page(result, drawn, None, mechanism.source, front)
    return text, notes


def report(
    result: Result, path: str | Path, running: bool = True, author: str = "", logo: str | Path | None = None
) -> tuple[str, ...]:
    """Write the report of a result as HTML or PDF, as ``path`` ends. An existing file is replaced when the
    new one is complete.

    ``running``: the mechanism runs in an HTML page. ``author`` and ``logo``, a PNG or JPEG file, stand on the
    first page. Return sentences on what the report lacks. Raises VfifeError for another ending or logo.
    """
    path, front = path_of(path, "report"), Front(author, logo=logo)
    ending = report_ending(path)
    if ending == ".pdf":
        write_pdf_report(result, path, front)
        return ()
    text, notes = run_report(result, running, front)
    write_text(path, text)
    return tuple(notes)


def report_ending(path: Path) -> str:
    """Return the ending of a report's file. Raises VfifeError for one in which none is written."""
    ending = path.suffix.lower()
    if ending not in (".html", ".htm", ".pdf"):
        raise VfifeError(f"{path}: a report is written as .html or .pdf; change the ending")
    return ending


def write_pdf_report(result: Result, path: Path, front: Front) -> None:
    """Write the report of a result as PDF."""
    figures, logo = reported_figures(result), front.picture()
    parts = [Figure(title, str) for title in figures]
    document, introduction = pages.run_document(result, parts, None, result.record.assembly.mechanism.source)
    texts = [text for text in (front.line, *introduction) if text]
    write_pdf(path, document, texts, figures, logo[0] if logo else None, front.author)


def write_study_pdf(study: Study, path: Path, author: str = "", logo: str | Path | None = None) -> None:
    """Write the report of a study as PDF, without the page in which a case runs."""
    front = Front(author, logo=logo)
    drawn, picture = reported(study), front.picture()
    document, introduction = pages.study_document(study, [Figure(title, str) for title in drawn])
    texts = [text for text in (front.line, *introduction) if text]
    write_pdf(path, document, texts, drawn, picture[0] if picture else None, author)
