"""Whatever is a table goes to pandas and CSV, measures have units, and what a notebook shows of an answer
fits into a cell.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import vfife
from vfife.gallery import four_bar_case_b
from vfife.simulation.result import Result

LONGEST = 500  # characters of a line in a cell
GIVEN: dict[str, Any] = {"turns": 2, "dropped": 0, "step": 2e-6, "companions": 0, "confirm": True}


@cache
def result() -> Result:
    return vfife.simulate(four_bar_case_b(), turns=1, companions=0)


@cache
def answers() -> dict[str, Any]:
    """One of each kind of answer."""
    m, gap = four_bar_case_b(), "joint.C.clearance"
    return {
        "measures": result().measures,
        "impacts": result().impacts,
        "study": vfife.study(m, {gap: ["0.1 mm", "0.2 mm"]}, ["C.force.max"], turns=1),
        "comparison": vfife.compare(m, ["hertz"], turns=1),
        "sensitivity": vfife.sensitivity(m, ["C.force.max"], [gap], turns=1, companions=0),
        "bifurcation": vfife.bifurcation(
            m, gap, "0.1 mm", "0.2 mm", count=2, series=["C.penetration"], **GIVEN
        ),
    }


@pytest.mark.parametrize("name", ["measures", "impacts", "study", "comparison", "sensitivity", "bifurcation"])
def test_a_table_goes_to_pandas(name: str) -> None:
    found = answers()[name]
    table = found.to_dataframe()
    assert len(table) >= 1 and len(table.columns) >= 3
    assert (len(repr(found)) < LONGEST and "to_dataframe" in repr(found)) or name == "study"


def test_a_measure_has_its_unit() -> None:
    found = result().measures
    assert (found["C.force.max"].unit, found["C.penetration.max"].unit, found["C.impacts"].unit) == (
        "N",
        "m",
        "1",
    )
    assert " N (" in repr(found["C.force.max"])
    table = found.to_dataframe().set_index("measure")
    assert (
        table.loc["C.force.max", "unit"] == "N"
        and table.loc["C.force.max", "value"] == found["C.force.max"].value
    )


def test_a_mechanism_fits_into_a_line() -> None:
    assert (
        repr(four_bar_case_b())
        == "<Mechanism 'four-bar, case b': 3 bodies, 4 joints, 1 driver; see .check(), .plot(), .live()>"
    )


def test_a_comparison_is_drawn() -> None:
    """The figures that the command writes, with a line and a bar for each law."""
    figures = answers()["comparison"].plot()
    assert figures.keys() == {"forces", "bars"}
    assert all(len(axes.lines) > 0 for axes in figures["forces"].axes if axes.get_visible())
    assert [text.get_text() for text in figures["bars"].axes[0].get_yticklabels()] == ["hertz"]
