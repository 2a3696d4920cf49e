"""Ranges in answers: of changes by clearance, of means beyond their turns, and of knocks that may be none."""

from __future__ import annotations

import copy
import io
from functools import cache
from typing import Any

import pytest
from rich.console import Console

import vfife
from vfife import gallery
from vfife.measures.error_ranges import widen_influences
from vfife.measures.values import Measured, Measures
from vfife.report.document import Document, Table
from vfife.report.front import TERMS, conclusion
from vfife.report.overview import cautions, joint_table, overview
from vfife.report.run_file import change_text, side_by_side
from vfife.report.run_tables import MEANS, knock_texts, may_not_knock, tables
from vfife.report.sensitivity import _range
from vfife.report.terminal import as_text, write

Json = dict[str, Any]


@cache
def compressor() -> Json:
    return vfife.simulate(gallery.compressor(), turns=2, companions=3).summary


def altered(ranges: dict[str, tuple[float, float, float]]) -> Json:
    """The summary with values and ranges of some measures of the small end."""
    summary = copy.deepcopy(compressor())
    for measure, (value, low, high) in ranges.items():
        name = f"small-end.{measure}"
        summary["measures"][name] = value
        summary["ranges"][name] |= {"low": low, "high": high}
        if name.endswith(".lip"):
            summary["lip"][name.removesuffix(".lip")] = value
    return summary


def cell(table: Any, row: str, heading: str) -> str:
    (found,) = [cells for cells in table.rows if cells[0].startswith(row)]
    return found[table.headings.index(heading)]


def noise(summary: Json) -> str:
    console = Console(file=io.StringIO(), width=400)
    write(overview(summary), console)
    return next(line for line in console.file.getvalue().splitlines() if line.startswith("Noise"))


def test_a_change_by_clearance_has_its_range_and_one_name_everywhere() -> None:
    """With two known digits it is a number, otherwise a range, even where that contains zero."""
    summary = altered({"force.lip": (20.0, -8.6, 46.3)})
    short, long = joint_table(summary), tables(summary)[0]
    assert "change" in short.headings and "change" in long.headings and "change" in TERMS
    assert cell(short, "small-end", "change") == cell(long, "small-end", "change") == "-8.6 to 47 %"
    assert "LIP(F)" in long.note and "LIP(F)" in TERMS["change"]
    changes = altered({"force.lip": (1e4, 0.9e4, 1.3e4)})
    assert any("a change of 9,000 to 13,000 %" in text for text in conclusion(changes)), conclusion(changes)
    certain = altered({"force.lip": (20.0, 19.9, 20.1)})
    assert cell(joint_table(certain), "small-end", "change") == "20.0 %"


def test_an_ideal_force_or_acceleration_of_about_zero_has_no_change() -> None:
    """The quotient would be rounding: 3.5e22 %."""
    summary = copy.deepcopy(compressor())
    summary["joints"]["small-end"]["ideal_force.max"] = 1e-12
    summary["lip"]["small-end.force"] = 3.5e22
    name = next(name for name, body in summary["model"]["bodies"].items() if not body["driven"])
    summary["model"]["bodies"][name]["ideal_angular_acceleration.max"] = 1e-20
    summary["lip"][f"{name}.angular_acceleration"] = 3.5e22
    forces = tables(summary)[0]
    assert (cell(forces, "small-end", "ideal"), cell(forces, "small-end", "change")) == ("about 0", "")
    (bodies,) = [table for table in tables(summary) if "angular accelerations" in table.title.lower()]
    assert (cell(bodies, name, "ideal"), cell(bodies, name, "change")) == ("about 0", "")
    assert cell(joint_table(summary), "small-end", "change") == ""
    assert not any("small-end" in text for text in conclusion(summary)[1:2])


def test_two_runs_name_the_runs_that_have_cautions_and_how_a_change_gets_its_range() -> None:
    summary = altered({"force.max": (1.33e3, 1.02e3, 1.64e3)}) | {"warnings": ["w"], "contacts": {}}
    later = altered({"force.max": (2.2e3, 2.1e3, 2.3e3)}) | {"warnings": [], "contacts": {}}
    for one in (later, summary):
        one["run"] = one["run"] | {"notes": []}
        one |= {"turns": None, "conformal": [], "not_unique": []}
    calm = [name for name, one in {"b": later}.items() if not any(cautions(one))]
    said = as_text(Document(side_by_side({"a": summary, "b": later}).parts[-1:]), 200)
    assert calm == ["b"] and "Cautions: vfife info a. Figures" in said
    assert "difference of both ranges, in per cent of the value of the first run" in said
    assert change_text((summary, later), "small-end.force.max") == "34 to 97 %"
    reverse = as_text(Document(side_by_side({"b": later, "a": summary}).parts[-1:]), 200)
    assert "Cautions: vfife info a. Figures" in reverse
    assert "Cautions" not in as_text(Document(side_by_side({"b": later, "c": later}).parts[-1:]), 200)


def test_no_change_is_below_the_loss_of_all() -> None:
    """Largest values are not negative, so that their changes are at least -100 %."""
    ranges = Measures()
    for name, value, low, high in (("C.force.max", 10.0, 0.0, 300.0), ("C.force.lip", 0.0, -400.0, 2000.0)):
        ranges[name] = Measured(value, low, high, estimated=True)
    widen_influences(ranges, {"C.force.max": 10.0})
    assert (ranges["C.force.lip"].low, ranges["C.force.lip"].high) == (-100.0, 2900.0)
    run = {"lip_force": 900.0, "lip_force.low": -100.0, "lip_force.high": 45_000.0}
    assert _range(run, "lip_force", 1.0) == "-100 to 45,000"
    low, high = (altered({"force.max": numbers}) for numbers in ((1.0, 0.5, 5.0), (9.0, 6.0, 12.0)))
    assert change_text((high, low), "small-end.force.max") == "-100 to -11 %"
    assert change_text((low, high), "small-end.force.max") == "100 to 1,200 %"


@pytest.mark.parametrize("low", [0.6, 0.8])
def test_a_range_beyond_all_turns_is_explained(low: float) -> None:
    """Only of a motion that does not repeat: there the turns are a sample."""
    name = "small-end.force.max"
    value = compressor()["measures"][name]
    summary = altered({"force.max": (value, low * value, 1.1 * value)})
    for measure in summary["measures"]:
        if measure.endswith(("force.max", "angular_acceleration.max")) and measure != name:
            bounds = summary["ranges"][measure]
            bounds |= {"lowest": 0.5 * bounds["low"], "highest": 2.0 * bounds["high"]}
    summary["ranges"][name] |= {"lowest": 0.7 * value, "highest": 1.2 * value}
    summary["turns"] |= {"motion": "not repeating", "count": 40, "first": 1, "last": 2}
    beyond = low < 0.7
    assert (MEANS in joint_table(summary).note) == (MEANS in tables(summary)[0].note) == beyond
    summary["turns"] |= {"motion": "periodic"}
    assert MEANS not in joint_table(summary).note + tables(summary)[0].note


def silent(count: int, speed: float, whole: float) -> Json:
    """The small end knocks ``count`` times in the turns of the measures, at ``speed`` (m/s), and at
    ``whole`` in the whole run, by far the hardest.
    """
    summary = altered({"approach_speed.max": (whole, whole, whole), "impacts": (17.0, 0.0, 35.0)})
    summary["knocks"]["small-end"] |= {"count": count, "speed": speed, "hardest": False, "overlap": False}
    return summary


def test_a_joint_without_knocks_in_the_table_is_not_called_a_knocker_without_a_word() -> None:
    summary = silent(0, 0.0, 5.0)
    assert knock_texts(summary, "small-end")[0] == "none"
    assert "(small-end, whole run; small-end not in the turns of the table)" in noise(summary)
    summary |= {"measures": summary["measures"] | {"small-end.impacts": 0.0}}
    summary["ranges"]["small-end.approach_speed.max"] |= {"low": 0.0, "high": 5.0}
    assert "whole run; small-end at other step sizes only)" in noise(summary)
    assert "step sizes only" not in noise(compressor()) and "not in the turns" not in noise(compressor())


def test_knocks_of_a_run_are_rounded_alike() -> None:
    """The hardest of the turns of the measures is never above that of the whole run."""
    summary = silent(3, 0.935, 0.936)
    assert knock_texts(summary, "small-end") == ("935 mm/s (not estimated)", "936 mm/s")
    summary["knocks"] = {name: entry | {"hardest": False} for name, entry in summary["knocks"].items()}
    said = "hardest knock 935 mm/s (small-end, not estimated), in the whole run 936 mm/s; at other step sizes"
    assert f"{said} it may not knock at all" in noise(summary)
    assert knock_texts(silent(3, 0.9358, 0.9359), "small-end")[0].startswith("935 mm/s"), "not 936"
    assert knock_texts(silent(3, 0.10354, 0.97), "small-end")[0] == "104 mm/s (not estimated)"


def test_a_number_of_knocks_from_zero_is_said_in_words() -> None:
    summary = silent(3, 0.9, 5.0)
    assert may_not_knock(summary, "small-end")
    assert "At other step sizes joint small-end may not knock at all." in " ".join(conclusion(summary))
    (table,) = [table for table in tables(summary) if table.title.startswith("Noise")]
    assert "At other step sizes small-end may not knock at all." in table.note
    summary["ranges"]["small-end.impacts"] |= {"low": 3.0}
    assert knock_texts(summary, "small-end")[0] == "900 mm/s (not estimated)"
    assert not may_not_knock(summary, "small-end")


def test_ranges_are_broken_before_their_upper_end_where_a_table_is_too_wide() -> None:
    rows = [("small-end 34 µm", "0.65 to 1.05 kN", "0.72 to 1.13 kN"), ("main", "643.8 N", "900 N")]
    table = Table(("joint", "largest, mean", "single turns"), rows, numbers=(1, 2))
    wide, narrow = (as_text(Document([table]), columns).splitlines() for columns in (60, 45))
    assert any("0.65 to 1.05 kN" in line and "0.72 to 1.13 kN" in line for line in wide)
    broken = [line for line in narrow if "kN" in line]
    assert broken and all(line.split()[-2:] != ["to", "kN"] for line in broken)
    assert all(line.strip() != "kN" for line in narrow) and any(
        line.endswith("to") for line in map(str.rstrip, narrow)
    )
