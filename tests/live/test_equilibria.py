"""The page of a static analysis: the equilibria as Python found them, to the bit, with forces and load
factors.
"""

import dataclasses
from functools import cache

import numpy as np
import pytest

import vfife
from live.browsers import needs_browser
from live.pages import needs_node, run_by_node, scripts_of
from vfife import gallery
from vfife.live.page.page import LARGEST, live_page, result_page
from vfife.measures.forces import joint_force, joint_rows

READ = """
const setting = new Setting(), [rows] = step(setting, 0);
const reader = new Reader(own, setting.part("state"), setting);
const width = own.kept.length, data = Float64Array.from(rows);
const all = Array.from({ length: data.length / width }, (_, k) => k * width);
const forces = all.map((at) => Object.keys(own.joints).map((name) => reader.force(data, at, name)));
const bodies = all.map((at) => given.bodies.map((body) => reader.point(data, at, body.centre).slice(0, 2)));
return { rows: bits(data), forces, bodies, factors: given.factors };
"""


@cache
def pressed():
    return vfife.simulate(gallery.toggle_press(), reference=False)


@needs_node
def test_the_page_has_the_equilibria_of_python(tmp_path):
    result = pressed()
    record = result.record
    found = run_by_node(result_page(result), READ, tmp_path)
    assert found["factors"] == result.time.tolist() == [0.0, *record.assembly.mechanism.settings.load_factors]
    assert (
        np.allclose(found["forces"], joint_force(record), rtol=1e-12, atol=1e-9)
        and len(joint_rows(record)) > 3
    )
    rigid = [k for k, body in enumerate(record.assembly.bodies.values()) if not body.elements]
    places = np.stack([result.channels[f"body_{axis}"].values for axis in "xy"], axis=2)
    assert np.allclose(np.array(found["bodies"])[:, rigid], places[:, rigid], rtol=1e-12, atol=1e-15)


def test_the_page_is_small_and_carries_what_was_found():
    page = live_page(gallery.toggle_press())
    given = scripts_of(page)
    assert len(page) < LARGEST and given["slides"] == [] and given["outputs"] == len(given["factors"]) - 1
    assert pressed().live().page == page == gallery.toggle_press().live().page


def test_an_analysis_that_found_nothing_has_no_page():
    result = pressed()
    record = dataclasses.replace(
        result.record, steps=result.record.steps[:1], source=result.record.rows[:1], message="It snapped."
    )
    with pytest.raises(vfife.VfifeError, match="no load path to show. It snapped."):
        result_page(type(result)(record))


@needs_browser
def test_the_load_path_is_gone_along(browser, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(result_page(pressed()), "utf-8")
    faults = []
    page = browser.new_page()
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda told: faults.append(told.text) if told.type == "error" else None)
    page.goto(path.as_uri())
    page.wait_for_function("() => live.running.store.end === 5 && live.clock.sized")
    page.keyboard.press("End")
    page.wait_for_function("() => document.getElementById('time').textContent === 'load factor 1'")
    assert [figure.get_attribute("id") for figure in page.locator("#cards figure").all()] == [
        "forces",
        "path",
        "peaks",
    ]
    table = page.locator("#peak-table tbody tr").all_inner_texts()
    assert (
        any(line.startswith("force knee") for line in table) and not page.locator("#speed-row").is_visible()
    )
    page.close()
    assert faults == []
