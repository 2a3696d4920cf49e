"""A reader of a study's report picks a case, and it runs with the numbers that assembly gives for it, to
the bit; every text is text.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import vfife
from live.browsers import needs_browser
from studies.studies import BASE
from vfife.cli.app import app
from vfife.errors import VfifeError
from vfife.live.page import reports as studied
from vfife.live.page.page_model import page_model, step_dividing_turn
from vfife.live.page.patches import SliderPatches, slider_patches
from vfife.live.page.reports import mechanism, study_page
from vfife.model.functions import turn_of
from vfife.report.pages import study_page as document

EVIL = "</script><script>alert(1)</script><b>"


@pytest.fixture(scope="module")
def grid() -> vfife.studies.Study:
    base = vfife.load(BASE)
    base.name = EVIL
    vary = {
        "play": {"path": "joint.C.clearance", "values": [1e-4, 2e-4]},
        "speed": {"path": "driver.crank.speed", "values": [100.0, 150.0]},
    }
    return vfife.study(base, vary, ["C.force.max"], turns=1, note=EVIL)


@pytest.fixture(scope="module")
def samples() -> vfife.studies.Study:
    vary = {
        "play": {"path": ["joint.C.clearance"], "from": "0.1 mm", "to": "0.3 mm"},
        "law": {"path": "joint.C.friction.coefficient", "from": 0.0, "to": 0.2},
    }
    return vfife.study(vfife.load(BASE), vary, ["C.force.max"], turns=1, method="random", count=25)


@pytest.mark.parametrize("kind", ["grid", "samples"])
def test_positions_have_the_numbers_of_their_members(
    kind: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    study: vfife.studies.Study = request.getfixturevalue(kind)
    seen: list[SliderPatches] = []
    monkeypatch.setattr(
        studied, "slider_patches", lambda *given: seen.append(slider_patches(*given)) or seen[-1]
    )
    _, places, notes = study_page(study)
    (found,) = seen
    assert notes == () and set(places) == {one.number for one in study.cases}
    own = found.base.assembly
    for case in study.cases[:: max(1, len(study.cases) // 4)]:
        at = [places[case.number][one.name] for one in found.slides]
        alone = mechanism(study, case)
        ideal = None if found.base.ideal is None else step_dividing_turn(found.base.ideal, turn_of(alone))
        wanted = page_model(alone, step_dividing_turn(own, turn_of(alone)), ideal, force=True)
        assert np.array_equal(found.vector(at).view(np.uint64), wanted.vector.view(np.uint64))
    steps = max(one["steps"] / one["turns"] for one in study.outcomes.values())
    assert own.choice.turn is not None and own.choice.turn / own.choice.step >= steps - 0.5, (
        "as fine as the finest case"
    )


def test_every_text_is_text_and_nothing_is_fetched(grid: vfife.studies.Study) -> None:
    page = document(grid, {}, *study_page(grid))
    assert EVIL not in page
    assert page.count("<button data-positions=") == len(grid.cases) == 4
    outside = re.sub(r'srcdoc="[^"]*"', "", page)
    assert not re.search(r"https?://|fetch\(|@import", outside)


@pytest.mark.system("a browser")
@needs_browser
def test_a_reader_picks_a_case_and_it_runs(browser, grid: vfife.studies.Study, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "page.html"
    path.write_text(document(grid, {}, *study_page(grid)), "utf-8")
    context = browser.new_context()
    try:
        page = context.new_page()
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(path.as_uri())
        page.locator("button[data-positions]").last.click()
        inside = page.frames[1]
        inside.wait_for_function("() => live.sliders.setting.positions.join() === '1,1'")
        inside.wait_for_function("() => live.running.store.end > 1")
        assert page.locator("#picked").text_content() == "3: play 200 µm, speed 150 rad/s"
        inside.evaluate("() => window.postMessage({ positions: { play: 7, speed: 'x' } }, '*')")
        assert inside.evaluate("() => live.sliders.setting.positions") == [1, 1], (
            "what is no position changes nothing"
        )
        assert faults == []
    finally:
        context.close()


def test_a_study_of_which_nothing_is_complete_has_no_page(samples: vfife.studies.Study) -> None:
    empty = vfife.studies.Study(None, samples.meta, samples.cases, {})
    with pytest.raises(VfifeError, match="no case is complete yet"):
        study_page(empty)


def test_a_report_of_a_study_has_its_author_date_and_logo(grid: vfife.studies.Study, tmp_path: Path) -> None:
    from datetime import date

    from vfife.live.page.reports import study_report

    logo = tmp_path / "logo.png"
    logo.write_bytes(b"\x89PNG\r\n\x1a\n")
    page, _ = study_report(grid, False, "J. Müller", logo)
    assert f"J. Müller · {date.today().isoformat()}" in page and 'class="logo"' in page


@pytest.mark.system("draws a report")
def test_a_report_of_a_study_is_printed_with_author_and_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from datetime import date

    from vfife.plots import pdf

    vary = {"play": {"path": "joint.C.clearance", "values": [1e-4, 2e-4]}}
    study = vfife.study(vfife.load(BASE), vary, ["C.force.max"], turns=1, file=tmp_path / "s.study")

    lines: list[str] = []
    put = pdf.Paper.put

    def kept(paper: pdf.Paper, x: float, y: float, text: str, size: float, **look: Any) -> None:
        lines.append(text)
        put(paper, x, y, text, size, **look)

    monkeypatch.setattr(pdf.Paper, "put", kept)
    target = tmp_path / "study.pdf"
    result = CliRunner().invoke(app, ["report", str(study.path), "-o", str(target), "--author", "J. Writer"])
    assert result.exit_code == 0, result.output
    assert target.read_bytes().startswith(b"%PDF") and f"J. Writer · {date.today().isoformat()}" in lines
    assert {"Results", "Parameters", "Figures", "Cases", "Inputs"} <= set(lines)
    case = study.done[-1]
    assert str(case.number) in lines, "every case has its row"
