"""Trends over clearance and speed: how statements are judged, on numbers made by hand and on small runs."""

import itertools
import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife_validation.trends import contact_loss, items, mechanisms, runs, statements
from vfife_validation.trends.grid import INNER, PHASES, Grid, Steps, grid, steps

RISE = np.arange(PHASES)[:, None, None] * 0.01


def made(middles):
    """A grid whose values scatter a little about ``middles``, shape (clearances, speeds)."""
    values = {"x": np.asarray(middles, dtype=float)[None] + RISE}
    return Grid((1e-4,) * len(middles), (1.0,) * len(middles[0]), values, {"x": (0.0, 0.0)})


def test_the_interval_holds_the_median_in_97_9_percent_of_samples():
    """Each of ten values lies below the median with a chance of one half: all 1,024 cases are counted."""
    first, last = INNER.start, INNER.stop - 1
    below = [sum(one) for one in itertools.product((0, 1), repeat=PHASES)]
    held = sum(first < count <= last for count in below)
    assert held / 2**PHASES == pytest.approx(0.979, abs=5e-4)
    assert made([[1.0]]).interval("x")[0][0, 0] == pytest.approx(1.01)
    assert made([[1.0]]).interval("x")[1][0, 0] == pytest.approx(1.08)


def test_a_median_rises_only_beyond_both_intervals():
    assert steps(made([[1.0], [2.0], [3.0]]), "x", "clearance") == Steps(
        2, 0, 0, pytest.approx((2.914, 2.914), abs=1e-3)
    )
    assert steps(made([[1.0], [2.0], [1.5]]), "x", "clearance").holds is False
    assert steps(made([[1.0], [1.05], [1.1], [2.0]]), "x", "clearance").holds is None
    assert steps(made([[1.0, 3.0], [2.0, 1.0]]), "x", "speed") == Steps(
        1, 1, 0, pytest.approx((0.511, 2.914), abs=1e-3)
    )


def test_a_single_start_that_reverses_an_order_is_counted():
    one = made([[1.0], [2.0]])
    assert statements.reversal(one, "x").holds is False
    one.values["x"][0, 1, 0] = 0.5
    assert statements.reversal(one, "x").numbers.startswith("in 1 of 10 ")


def test_regions_and_places_of_a_turn():
    assert contact_loss.regions(np.array([])) == 0
    assert contact_loss.regions(np.array([359.0, 1.0, 5.0])) == 1
    assert contact_loss.regions(np.array([359.0, 1.0, 90.0, 95.0, 200.0])) == 3
    rate = np.zeros(contact_loss.OUTPUTS)
    rate[::4] = 1.0
    assert contact_loss.predicted(np.array([0.0, 2.0, 1.0]), rate) == 2


def test_counts_that_hardly_differ_leave_a_statement_open():
    assert statements.larger_count("", "", 10, 8, 12, "").holds is None
    assert statements.larger_count("", "", 12, 2, 12, "").holds is True
    assert statements.larger_count("", "", 2, 12, 12, "").holds is False


def test_the_command_lists_the_items():
    answer = CliRunner().invoke(app, ["verify", "trends", "--list", "--json"])
    assert json.loads(answer.stdout)["items"] == list(items.ITEMS)


@pytest.mark.slow("runs a slider-crank")
def test_peaks_grow_with_the_speed_unless_a_load_presses_the_block():
    """A load of 50 kN on the block hides the forces of inertia."""
    factors = []
    for load in (1.0, 5e4):
        mechanism = mechanisms.slider_crank(2e-4, load=load)
        one = grid(mechanism, ["pin"], [2e-4], [300.0, 600.0], [runs.PEAK], turns=2, last=1)
        factors.append(steps(one, runs.PEAK, "speed").factors[0])
    assert factors[0] == pytest.approx(4.0, rel=0.25)
    assert factors[1] < 1.2


@pytest.mark.slow("runs a slider-crank")
def test_the_force_of_an_ideal_pin_turns_fastest_where_it_is_smallest():
    """Without gravity only the block loads the pin: m r w^2 (1 + r/l) at the outer dead centre."""
    speed = 100.0
    rate = contact_loss.turning_rate(mechanisms.slider_crank(speed=speed), "pin")
    quarter = np.flatnonzero(rate >= np.quantile(rate, 0.75)) * 360.0 / contact_loss.OUTPUTS
    assert ((np.abs(quarter - 75.0) < 30.0) | (np.abs(quarter - 285.0) < 30.0)).all()


@pytest.mark.verify
def test_trends_are_what_the_documentation_says():
    """Growth with speed holds; with clearance it fails where there is friction; B matters most, D least."""
    by_name = {name: make() for name, make in items.ITEMS.items()}
    holds = {one.statement: one.holds for item in by_name.values() for one in item.verdicts}
    assert all(
        one.holds for one in by_name["clearance-and-speed"].verdicts if "with the speed" in one.statement
    )
    first, second = by_name["clearance-and-speed"].verdicts[:2]
    assert "friction 0.1" in first.statement and first.holds is False
    assert "no friction" in second.statement and second.holds is True
    last, crank = by_name["chain"].verdicts[:2]
    assert last.holds is False and crank.holds is True
    assert by_name["contact-loss"].data["predicted"] > 0.5 * by_name["contact-loss"].data["losses"]
    assert None in holds.values() or False in holds.values()
    assert math.isfinite(max(by_name["scatter"].data.values()))
