"""Each number in the tables of the long answer is a range, has the digits that its range leaves, or stands in
a column of which a note says that it is not estimated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

import vfife
from support import with_settings
from vfife import gallery
from vfife.measures.forces import MODES
from vfife.numerics.outward import exponent
from vfife.report.digits import is_about_zero, sum_text, uncertainty
from vfife.report.run_file import _law_facts, impacts
from vfife.report.run_tables import tables
from vfife.report.summary import run_summary
from vfife.simulation.result import Result

Json = dict[str, Any]
NUMBER = r"[-+]?[\d,]+(?:\.\d+)?(?:e[-+]\d+)?"
UNITS = {"": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "m": 1e-3, "µ": 1e-6, "n": 1e-9}
PREFIXABLE = ("m/s", "MPa m/s", "Pa m/s", "Pa", "W", "N m", "N", "m", "s")


def contact_measures(*kinds: str) -> Callable[[Json, str], list[str]]:
    """Measures of a contact, or of all contacts of a joint."""

    def names(summary: Json, row: str) -> list[str]:
        return [
            f"{row}.{corner}{kind}"
            for kind in kinds
            for corner in ("", "1.", "2.", "3.", "4.")
            if f"{row}.{corner}{kind}" in summary["measures"]
        ]

    return names


# Measures of the columns by the beginning of a table's title, and of headings.
COLUMNS: dict[tuple[str, str], Callable[[Json, str], list[str]]] = {
    ("Largest reactions", "reaction"): contact_measures("force.max"),
    ("Largest reactions", "range of reaction"): contact_measures("force.max"),
    ("Largest reactions", "range"): contact_measures("force.max"),
    ("Largest reactions", "this run"): contact_measures("force.max"),
    ("Largest reactions", "change"): contact_measures("force.lip"),
    ("Largest reactions", "penetration"): contact_measures("penetration.max"),
    ("Contact", "deepest landing"): contact_measures("landing_depth.max"),
    ("Contact", "free flight"): contact_measures(f"share.{MODES[0]}"),
    ("Contact", "impact"): contact_measures(f"share.{MODES[1]}"),
    ("Contact", "contact"): contact_measures(f"share.{MODES[2]}"),
    ("Noise", "hardest knock"): contact_measures("approach_speed.max"),
    ("Noise", "hardest there"): contact_measures("approach_speed.max"),
    ("Noise", "power of the knocks"): contact_measures("impact_power.mean"),
    ("Losses", "friction"): contact_measures("friction_power.mean"),
    ("Losses", "impacts"): contact_measures("impact_power.mean"),
    ("Losses", "sliding"): contact_measures("sliding_velocity.max"),
    ("Losses", "line pressure"): contact_measures("contact_pressure.max"),
    ("Losses", "half-width"): contact_measures("contact_half_width.max"),
    ("Losses", "p v, mean"): contact_measures("pressure_velocity.mean"),
    ("Largest angular", "acceleration"): contact_measures("angular_acceleration.max"),
    ("Largest angular", "range of acceleration"): contact_measures("angular_acceleration.max"),
    ("Largest angular", "range"): contact_measures("angular_acceleration.max"),
    ("Largest angular", "this run"): contact_measures("angular_acceleration.max"),
    ("Largest angular", "change"): contact_measures("angular_acceleration.lip"),
}
COUNTS = {
    ("Contact", "impacts"): "impacts",
    ("Contact", "grazing"): "grazing",
    ("Contact", "landed too deep"): "deep_landings",
    ("Noise", "knocks"): "impacts",
}
WORDS = ("none", "about 0", "within 0.01 %", "")
PER_CENT_OF_VALUE = re.compile(rf"({NUMBER}) to ({NUMBER}) %")


def factor(unit: str, heading: str) -> float:
    """SI units, or per cent of a lip, in a unit of a cell."""
    if unit == "%":
        return 1.0 if heading == "change" else 0.01
    base = next((base for base in PREFIXABLE if unit.endswith(base) and unit[: -len(base)] in UNITS), unit)
    return UNITS[unit[: len(unit) - len(base)]]


def plain(number: str) -> float:
    return float(number.replace(",", ""))


def last_place(number: str) -> int:
    """Exponent of ten of the last digit that means something: 390 is known to tens, 390.0 to tenths."""
    if "." in number:
        return -len(number.rpartition(".")[2])
    digits = number.replace(",", "").lstrip("-+")
    return len(digits) - len(digits.rstrip("0"))


def fault(summary: Json, names: list[str], cell: str, heading: str) -> str:
    """What is wrong with a cell, "" if nothing."""
    text = cell.removesuffix(" *")
    if text in WORDS:
        return ""
    low, high = (max(summary["ranges"][name][end] for name in names) for end in ("low", "high"))
    if heading == "range":
        (first, last), value = PER_CENT_OF_VALUE.fullmatch(text).groups(), summary["measures"][names[0]]
        inside = value * (1.0 + plain(first) / 100.0) <= low and high <= value * (1.0 + plain(last) / 100.0)
        return "" if inside else f"{text} leaves out some of {low} to {high}"
    if found := re.fullmatch(rf"({NUMBER}) to ({NUMBER}) (.+)", text):
        unit = factor(found[3], heading)
        ends = plain(found[1]) * unit, plain(found[2]) * unit
        slack = 1e-9 * abs(high)
        return "" if ends[0] <= low + slack and high - slack <= ends[1] else f"{ends} leave out {low}, {high}"
    if not all(name not in summary["not_estimated"] for name in names):
        return "not estimated, and nothing says so"
    number, unit_text = re.fullmatch(rf"({NUMBER}) (.+)", text).groups()
    unit = factor(unit_text, heading)
    largest = max(names, key=summary["measures"].__getitem__)
    width = uncertainty(summary, largest) / unit
    if width <= 0.0 or is_about_zero(summary, largest):
        return ""
    # A number keeps its first digit, however wide its range is, if the range is shown beside it.
    first = exponent(plain(number)) if plain(number) else 0
    if last_place(number) < min(exponent(width), first):
        return f"{number} with a range of {width:.2g}"
    ranged_beside = heading in ("this run", "reaction", "acceleration")
    wide = (high - low) / unit > 0.1 * abs(plain(number)) * (1.0 + 1e-9) and (high - low) > 0.0
    return "" if ranged_beside or not wide else "two digits are not known, and no range is shown"


@cache
def compressor() -> Result:
    return vfife.simulate(with_settings(gallery.compressor(), turns=2.0))


@cache
def four_bar() -> Result:
    return vfife.simulate(with_settings(gallery.four_bar_case_c(), turns=2.0))


@pytest.mark.parametrize("build", [compressor, four_bar])
def test_every_number_of_the_tables_carries_its_error(build: Callable[[], Result]) -> None:
    summary, seen, faults = run_summary(build()), set(), []
    assert summary["trust"]
    for table in tables(summary):
        if table.title.startswith("Dead centres"):
            assert table.headings[-1] == "error" and all(row[-1] for row in table.rows)
            continue
        unknown = re.search(r"Not estimated: ([^.]*)\.", table.note)
        for k, heading in enumerate(table.headings[1:], 1):
            key = next(
                (key for key in (*COLUMNS, *COUNTS) if table.title.startswith(key[0]) and key[1] == heading),
                None,
            )
            seen.add(key)
            if unknown and heading in unknown[1]:
                continue
            if heading == "ideal":
                assert "Errors of the ideal mechanism are not estimated" in table.note
                continue
            assert key is not None, f"{table.title}: {heading} has no error, and no note names it"
            for row in table.rows:
                if key in COUNTS:
                    check_count(summary, row[0], heading, table.note, COUNTS[key])
                    continue
                names = COLUMNS[key](summary, row[0])
                if text := fault(summary, names, row[k], heading) if names else "":
                    faults.append(f"{table.title}, {row[0]}, {heading}: {row[k]}: {text}")
    assert not faults, "\n".join(faults)
    assert {("Contact", "deepest landing"), ("Noise", "power of the knocks"), ("Losses", "friction")} <= seen


def check_count(summary: Json, row: str, heading: str, note: str, kind: str) -> None:
    """A count has its range in the note, unless all runs counted the same."""
    names = contact_measures(kind)(summary, row)
    low, high = (sum(summary["ranges"][name][end] for name in names) for end in ("low", "high"))
    assert "Counts are those of this run" in note
    if math.floor(low) < math.ceil(high):
        told = note.partition(f"{heading} ")[2].partition(";")[0]
        assert re.search(rf"{math.floor(low)} to {math.ceil(high)} \([^)]*\b{re.escape(row)}\b", told), (
            row,
            note,
        )


def test_the_check_finds_bare_numbers() -> None:
    summary = run_summary(compressor())
    width = uncertainty(summary, "cylinder.friction_power.mean")
    names = ["cylinder.friction_power.mean"]
    value = summary["measures"][names[0]]
    assert width > 0.0 and fault(summary, names, f"{value:.4g} W", "friction")
    assert fault(summary, names, f"{value:.3g} to {value:.3g} W", "friction")
    assert fault(summary, ["cylinder.1.sliding_velocity.max"], "3.61 m/s", "sliding")
    deep = contact_measures("landing_depth.max")(summary, "cylinder")
    assert fault(summary, deep[:1], "1.242 nm", "deepest landing")


def test_single_impacts_say_that_they_are_not_estimated() -> None:
    page = impacts(compressor().impacts, 5)
    assert "not estimated" in page.parts[2].text and "--measures" in page.parts[2].text


def test_a_sum_is_a_range_where_two_digits_are_not_known() -> None:
    ranges = {"a": {"low": 0.04, "high": 0.06}, "b": {"low": 0.0, "high": 0.16}}
    told = {"measures": {"a": 0.05, "b": 0.05}, "ranges": ranges, "not_estimated": [], "trust": {"x": 1}}
    assert sum_text(told, ["a", "b"], "W") == "40 to 220 mW"
    assert sum_text(told | {"not_estimated": ["b"]}, ["a", "b"], "W") == "100 mW (not estimated)"
    ranges["a"], ranges["b"] = {"low": 0.0499, "high": 0.0501}, {"low": 0.05, "high": 0.0502}
    assert sum_text(told, ["a", "b"], "W") == "100.0 mW"


def test_the_list_of_measures_says_which_are_of_the_whole_run() -> None:
    """Energies are not: those of the last turn are less than what the ledger of the run has."""
    result = compressor()
    (part,) = (
        text for name, text in _law_facts({"laws": {}, "summary": result.summary}) if name == "Measures"
    )
    assert "energies" not in part and "landings and speeds of knocks are those of the whole run" in part
    energy = sum(value for name, value in result.measures.items() if name.endswith(".friction_energy.total"))
    assert 0.0 < energy < 0.7 * result.ledger.terms["friction_loss"][-1]
    contacts = result.record.assembly.contacts
    for row, name in zip(result.record.last("contact_onsets"), contacts, strict=True):
        assert result.measures[f"{name}.impacts"] == row
