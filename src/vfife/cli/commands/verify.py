"""``vfife verify``: the verification suite, case by case."""

from __future__ import annotations

import difflib
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ...job.progress import ProgressLine, on_terminal
from ...solvers.status import Progress
from ..options import JsonOptions, argument, flag, option
from ..terminal import answer, end_interrupted, fail
from .verify_page import PAGES, verify_page

if TYPE_CHECKING:
    from vfife_validation.verification import Case


class VerifyOptions(JsonOptions):
    """Options of ``vfife verify``."""

    names: list[str] | None = argument(
        "These cases only; measured, published or trends: write their page, with the items named after it.",
        "[CASE]...",
        None,
    )
    folder: Path | None = option(
        None, "Folder of the page, by default named as its group.", "FOLDER", "-o", "--output"
    )
    listed: bool = flag("--list", "List the cases and run none.")


def verify(options: VerifyOptions) -> None:
    """Run the verification suite: our numbers beside published ones, closed forms and independent
    integrations. Exit code 1 if any fails.

    `vfife verify measured` compares with measured pendulums and a hysteresis loop instead, `vfife verify
    published` with published studies of linkages with clearance, `vfife verify trends` with statements of the
    literature on clearance and speed; each writes a page.
    """
    group, *items = options.names or [""]
    if group.lower() in PAGES:
        verify_page(group.lower(), items, options.folder, options.listed, options.as_json)
        return
    from vfife_validation.verification import CASES, page

    cases = chosen(CASES, options.names or [])
    if options.listed:
        answer(page.listing(cases), options.as_json)
        return
    done: list[page.CaseRows] = []
    began, line = time.monotonic(), ProgressLine(quiet=not on_terminal())
    try:
        with line:
            for one in cases:
                line(Progress(len(done), len(cases), time.monotonic() - began, one.title))
                done.append((one, one.check()))
                if not options.as_json:
                    answer(page.document(*done[-1]))
    except KeyboardInterrupt:
        answer(page.conclusion(done, interrupted=True), options.as_json)
        end_interrupted(f" after {len(done)} of {len(cases)} cases.")
    answer(page.conclusion(done), options.as_json)
    if page.failed(done):
        raise typer.Exit(1)


def chosen(cases: Mapping[str, Case], names: Sequence[str]) -> list[Case]:
    """The cases named, all of them where none is; ends with suggestions for those that there are not."""
    wrong = [name for name in names if name.lower() not in cases]
    if wrong:
        sentences = []
        for name in wrong:
            near = difflib.get_close_matches(name.lower(), cases, 3, 0.4)
            sentence = (
                f"did you mean {' or '.join(repr(one) for one in near)}?"
                if near
                else "vfife verify --list names all there are"
            )
            sentences.append(f"there is no case {name!r}; {sentence}")
        fail("; ".join(sentences))
    return [cases[name] for name in dict.fromkeys(name.lower() for name in names)] or list(cases.values())
