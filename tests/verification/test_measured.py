"""vfife beside measurements: the small part checks what the comparison rests on, the long one
its statements.
"""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from vfife.cli.app import app
from vfife_validation.measured import (
    double,
    hysteresis,
    independent,
    items,
    mechanisms,
    records,
    single,
    swings,
)


def test_the_records_are_those_of_the_authors():
    """First and last angles of some, as they stand in the authors' files (rad), and the
    licence beside them.
    """
    angles = records.angles()
    assert [sum(name.startswith(kind) for name in angles) for kind in ("single", "double")] == [4, 26]
    assert angles["single_pendulum_01"][[0, 1, 2, -1], 0].tolist() == pytest.approx(
        [1.523164, 1.525101, 1.527094, 3.030314], abs=1e-9
    )
    assert angles["double_pendulum_26"][[0, -1]].tolist() == [
        pytest.approx([3.023882, 2.93294], abs=1e-9), pytest.approx([3.154196, 3.172274], abs=1e-9)
    ]  # fmt: skip
    assert "MIT License" in records.FILE.with_name("LICENSE.multiarm-pendulum").read_text()


@pytest.mark.slow("compiles a step")
def test_a_swing_of_the_double_pendulum_is_that_of_lagranges_equations():
    data = records.record("double_pendulum_01", double.BODIES, 0.3, 20)
    start = [2.6, 3.5, 8.0, -2.0]
    paths = [f"start.{body}.{what}" for what in ("angle", "angular_velocity") for body in double.BODIES]
    (ours,) = swings.swings(mechanisms.double(), [data], [dict(zip(paths, start, strict=True))])
    numbers = {
        "upper arm": mechanisms.UPPER_ARM, "lower arm": mechanisms.LOWER_ARM,
        "upper inertia": mechanisms.UPPER_INERTIA, "lower inertia": mechanisms.LOWER_INERTIA,
        "pivot damping": mechanisms.UPPER_DAMPING, "elbow damping": mechanisms.LOWER_DAMPING,
        "pivot dry": 0.0, "elbow dry": 0.0,
    }  # fmt: skip
    assert np.abs(ours - independent.double(numbers, start, data.places)).max() < 2e-4
    wrong = {**numbers, "lower inertia": 1.01 * mechanisms.LOWER_INERTIA}
    assert np.abs(ours - independent.double(wrong, start, data.places)).max() > 1e-3


def test_the_loop_has_the_clearance_that_it_is_made_with():
    _, places, forces = hysteresis.loop(0, 0.0)
    inside = np.abs(places) < 0.99 * hysteresis.CLEARANCE
    assert np.abs(forces[inside]) == pytest.approx(hysteresis.DRAG)
    top = hysteresis.STIFFNESS * (places.max() - hysteresis.CLEARANCE)
    assert forces.max() == pytest.approx(top + hysteresis.DRAG, rel=1e-3)


def test_the_command_lists_what_it_compares():
    answer = CliRunner().invoke(app, ["verify", "measured", "--list", "--json"])
    assert json.loads(answer.stdout)["items"] == list(items.ITEMS)
    wrong = CliRunner().invoke(app, ["verify", "measured", "pendulums"])
    assert wrong.exit_code != 0


@pytest.mark.verify
def test_the_single_pendulum_is_identified():
    """Viscous and dry friction leave more of record 2 than fits of each record do; friction
    over speed less.
    """
    plain = single.identify("viscous and dry")
    square, error = single.frequency(plain.values[0].value, plain.values[0].error)
    assert 64.04 <= square <= 64.14 and error < 0.05
    assert plain.splits and plain.correlation[2, 1] < -0.9
    assert [one.residual for one in plain.records] == pytest.approx(
        [0.0054, 0.0072, 0.0030, 0.0028], rel=0.05
    )
    curve = single.identify("curve")
    assert max(one.residual for one in curve.records) < 0.003
    assert single.difference(plain) < 2e-3


@pytest.mark.verify
def test_records_are_foretold_by_the_numbers_of_others():
    pair, others = ("single_pendulum_02", "single_pendulum_04"), ("single_pendulum_01", "single_pendulum_03")
    assert max(one.ours for one in single.pair_by("curve", pair, others)) < 0.01


@pytest.mark.verify
def test_the_double_pendulum_is_foretold_better_than_by_the_authors_numbers():
    fit = double.identify()
    assert fit.share < 0.005 and all(one.determined for one in fit.values)
    foretold = double.foretold_by_halves()
    assert [one.name for one in foretold] == records.names("double")
    for k in range(2):
        ours, authors = (np.median([getattr(one, who)[k] for one in foretold]) for who in ("ours", "authors"))
        assert ours < authors and ours < (0.008, 0.015)[k]
    assert all(math.isinf(one.horizon) for one in foretold)
    assert min(one.lyapunov_time for one in foretold) == pytest.approx(1.05, abs=0.1)


@pytest.mark.verify
def test_limits_from_loops_with_noise_hold_the_truth():
    held, worst = hysteresis.coverage(items.SEEDS)
    assert worst["clearance"] < 0.05 and min(held.values()) >= 0.8 * items.SEEDS
