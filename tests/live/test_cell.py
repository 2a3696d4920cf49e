"""A mechanism in the cell of a notebook: the page in a frame without access, also where the notebook is
exported to.
"""

import re
from html import unescape
from pathlib import Path

import pytest

import vfife
from live.browsers import needs_browser
from live.pages import scripts_of
from vfife import gallery

NAME = '<b>"bar"</b></iframe>'


def shown(cell) -> tuple[str, str]:
    """The attributes of the frame but for the page, and the page."""
    (found,) = re.findall(r'<iframe ([^>]*) srcdoc="([^"]*)"></iframe>', cell._repr_html_())
    return found[0], unescape(found[1])


def test_a_cell_shows_the_page_and_keeps_it_apart(tmp_path):
    mechanism = gallery.four_bar_case_b()
    mechanism.name = NAME
    cell = mechanism.live(["joint.C.clearance=0.1..0.3mm"])
    look, page = shown(cell)
    assert page == cell.page and 'sandbox="allow-scripts allow-downloads"' in look and NAME not in look
    assert [slide["name"] for slide in scripts_of(page)["slides"]] == ["joint.C.clearance"]
    cell.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text("utf-8") == page
    assert "save(path)" in repr(cell)
    with pytest.raises(ValueError, match="PATH=LOW"):
        mechanism.live(["joint.C.clearance"])
    with pytest.raises(vfife.VfifeError, match="static"):
        gallery.toggle_press().live(["body.ram.mass=1..2kg"])


def test_a_result_runs_with_its_step():
    result = vfife.simulate(
        gallery.four_bar_case_b(), turns=0.02, step=2e-6, companions=0, reference=False, loop="data-driven"
    )
    given = scripts_of(result.live().page)
    assert given["step"] == result.record.assembly.choice.step and given["slides"] == []


@pytest.mark.system("a browser")
@needs_browser
def test_cells_run_on_a_page_that_is_opened_from_disk(browser, tmp_path: Path):
    cells = [gallery.four_bar_case_b().live(()), gallery.quick_return().live(())]
    path = tmp_path / "notebook.html"
    path.write_text("<!doctype html>" + "".join(cell._repr_html_() for cell in cells), "utf-8")
    faults: list[str] = []
    context = browser.new_context(
        viewport={"width": 900, "height": 1600}
    )  # frames out of sight are not drawn
    context.route(
        "**/*",
        lambda route: (
            route.continue_() if route.request.url.startswith(("file:", "blob:", "about:")) else route.abort()
        ),
    )
    page = context.new_page()
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda told: faults.append(told.text) if told.type == "error" else None)
    page.goto(path.as_uri())
    for frame in page.frames[1:]:
        frame.wait_for_function("() => window.live?.running.store.end > 100 && live.frames.count > 3")
    assert len(page.frames) == 3
    context.close()
    assert faults == []
