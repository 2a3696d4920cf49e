"""Contacts that begin in the same step: corners of a block on a wall, balls in a row; against symmetry and an
independent integration.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from support import bits, go, particle, with_settings
from vfife.laws import Ambrosio, HuntCrossley
from vfife.model.mechanism import Mechanism

STIFFNESS, RESTITUTION, FLOOR = 1e9, 0.6, 1e-3
MASS, RADIUS, SPEED, STEP = 0.2, 0.02, 0.5, 4e-7
BALLS = ("a", "b", "c", "d", "e")
ROWS = tuple(zip(BALLS, BALLS[1:], strict=False))


def block(order: Sequence[str] = ("left", "right"), mirrored: bool = False) -> Mechanism:
    """A block falls flat on a wall that two of its corners meet at once; friction finds nothing to do."""
    m = Mechanism("block", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    side = -1.0 if mirrored else 1.0
    m.rigid_body("block", mass=1.0, inertia=2e-3, position=(side * 0.1, 0.0506), velocity=(0.0, -0.8, 0.0),
                 pins={"left": (-0.06, -0.05), "right": (0.06, -0.05)})  # fmt: skip
    for name in order:
        m.external_contact(name, "ground.O", f"block.{name}", journal_radius=5e-4,
                           contact=HuntCrossley(restitution=RESTITUTION, stiffness=STIFFNESS),
                           friction=Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2))  # fmt: skip
    return m


def row(pairs: Sequence[tuple[str, str]] = ROWS, side: float = 1.0) -> Mechanism:
    """Five equal balls in contact, the first of them moving; ``side`` -1 is its mirror image."""
    m = Mechanism("row")
    for k, name in enumerate(BALLS):
        start = SPEED if k == 0 else 0.0
        m.rigid_body(
            name,
            mass=MASS,
            inertia=1e-4,
            position=(side * 2.0 * RADIUS * k, 0.0),
            velocity=(side * start, 0.0, 0.0),
        )
    for first, second in pairs:
        m.external_contact(first + second, f"{first}.center", f"{second}.center", bearing_radius=RADIUS,
            journal_radius=RADIUS,
                           contact=HuntCrossley(restitution=RESTITUTION, stiffness=STIFFNESS),
                           impact_speed_floor=FLOOR)  # fmt: skip
    return m


@pytest.mark.parametrize("parts", [1, 8])
@pytest.mark.parametrize("order", [("left", "right"), ("right", "left")])
def test_a_block_that_meets_a_wall_with_two_corners_stays_upright(order, parts):
    record = go(with_settings(block(order), parts=parts), 2e-6, duration=3e-3, outputs=50)
    one = particle(record, "block")
    assert record.block("contact_onsets")[-1].min() >= 1 and one["v"][-1] > 0.3
    assert abs(one["theta"]).max() < 1e-15 and abs(one["w"]).max() < 1e-12


@cache
def velocities(
    pairs: tuple[tuple[str, str], ...] = ROWS, side: float = 1.0, step: float = STEP
) -> np.ndarray:
    record = go(row(pairs, side), step, duration=4e-4, outputs=20)
    return np.array([particle(record, name)["u"] for name in BALLS])


def test_a_row_of_balls_is_its_mirror_image_to_the_bit():
    assert (bits(velocities()) == bits(-velocities(side=-1.0))).all()
    turned = tuple((second, first) for first, second in reversed(ROWS))
    assert velocities(turned) == pytest.approx(velocities(), abs=1e-12)


@pytest.mark.parametrize("pairs", [ROWS[::-1], (ROWS[2], ROWS[0], ROWS[3], ROWS[1])])
def test_the_order_of_the_joints_does_not_matter(pairs):
    assert velocities(pairs) == pytest.approx(velocities(), abs=1e-12)


def independent() -> np.ndarray:
    """Hunt and Crossley's law in a row of points, each onset located: SPEED for the first pair, elsewhere the
    rate at the onset or the floor.
    """
    factor = 1.5 * (1.0 - RESTITUTION)
    onset = [SPEED, None, None, None]

    def forces(y: np.ndarray) -> np.ndarray:
        found = []
        for k in range(4):
            depth, rate = y[k] - y[k + 1], y[5 + k] - y[6 + k]
            speed = onset[k]
            found.append(
                0.0
                if depth <= 0.0 or speed is None
                else max(STIFFNESS * depth**1.5 * (1.0 + factor * rate / speed), 0.0)
            )
        return np.array(found)

    def rate(_t: float, y: np.ndarray) -> np.ndarray:
        f = forces(y)
        return np.concatenate([y[5:], np.diff(f, prepend=0.0, append=0.0) * -1.0 / MASS])

    y, t, end = np.concatenate([np.zeros(5), [SPEED], np.zeros(4)]), 0.0, 4e-4
    for k in range(1, 4):
        onset[k] = FLOOR  # pressed from rest: the rate at the first instant is none
    solved = solve_ivp(rate, (t, end), y, method="DOP853", rtol=1e-11, atol=1e-14, max_step=1e-5)
    return np.asarray(solved.y[5:, -1])


def test_a_row_of_balls_passes_an_impact_as_its_law_says():
    exact = independent()
    errors = [abs(velocities(step=step)[:, -1] - exact).max() for step in (STEP, STEP / 4)]
    assert velocities()[:, -1].sum() == pytest.approx(SPEED, rel=1e-12)
    assert errors[1] < 1e-4 * SPEED and errors[1] < 0.3 * errors[0]
