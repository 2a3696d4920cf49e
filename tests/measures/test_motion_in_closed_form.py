"""Places, velocities and accelerations of bodies, pins and slides from rows that a test writes: rotation in
closed form.
"""

from __future__ import annotations

import numpy as np
import pytest

from made_records import STEP, made_record
from vfife.measures.motion import (
    body_motion,
    body_velocity,
    pin_path,
    pin_places,
    point_motion,
    slider_motion,
)
from vfife.model.mechanism import Mechanism

STEPS = np.arange(0, 30, 3)
TIME = STEP * STEPS
SPEED = 40.0  # rad/s
CENTRE, PIN = np.array([0.1, 0.2]), np.array([0.3, -0.15])


def turned(angle: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """An arm (m) in the frame of a body that stands at these angles (rad), global axes."""
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])


def crank() -> Mechanism:
    """A driven body whose centre lies off its axis both ways, the axis off the origin."""
    m = Mechanism("crank", gravity=(0.0, 0.0))
    m.point("O", 0.5, -0.25)
    m.rigid_body("b", mass=1.0, inertia=0.1, center=tuple(CENTRE), pins={"axis": (0.0, 0.0), "p": tuple(PIN)})
    m.revolute("O", "ground.O", "b.axis")
    m.drive("b", speed=SPEED)
    return m


def test_a_driven_body_carries_its_centre_and_its_pins_around() -> None:
    angle = 0.7 + SPEED * TIME
    record = made_record(crank(), {"particle_theta": np.stack([0.0 * TIME, angle], axis=1)}, STEPS)
    axis = np.array([0.5, -0.25])
    centre, pin = turned(angle, CENTRE), turned(angle, PIN)
    moved = body_motion(record)
    assert np.column_stack([moved["x"][:, 0], moved["y"][:, 0]]) == pytest.approx(axis + centre, rel=1e-12)
    assert moved["angle"][:, 0] == pytest.approx(angle) and moved["angular_velocity"][:, 0] == pytest.approx(
        SPEED
    )
    across = SPEED * np.column_stack([-centre[:, 1], centre[:, 0]])
    assert body_velocity(record)[:, 0] == pytest.approx(across, rel=1e-12)
    assert pin_path(record, "b", "p") == pytest.approx(axis + pin, rel=1e-12)
    assert pin_path(record, "ground", "O") == pytest.approx(np.tile(axis, (len(TIME), 1)))
    point = point_motion(record, "b.p")
    assert point.position == pytest.approx(axis + pin, rel=1e-12)
    assert point.velocity == pytest.approx(SPEED * np.column_stack([-pin[:, 1], pin[:, 0]]), rel=1e-12)
    assert point.acceleration == pytest.approx(-(SPEED**2) * pin, rel=1e-9)
    still = point_motion(record, "ground.O")
    assert still.position == pytest.approx(np.tile(axis, (len(TIME), 1))) and not still.velocity.any()
    with pytest.raises(ValueError, match=r"there are b\.center, b\.axis, b\.p"):
        point_motion(record, "b.q")


def test_a_body_that_slides_along_a_turning_one_is_seen_from_it() -> None:
    """At s = 0.2 + 3 t along a guide that turns with w: the block has the velocity 3 and no acceleration
    there, Coriolis' and all in space.
    """
    m = crank()
    m.rigid_body("block", mass=0.1, inertia=1e-3, position=(0.7, -0.25))
    m.slider("guide", "b.axis", "block.center", direction=(1.0, 0.0))
    angle, place, rate = SPEED * TIME, 0.2 + 3.0 * TIME, 3.0
    along, across = turned(angle, np.array([1.0, 0.0])), turned(angle, np.array([0.0, 1.0]))
    s = place[:, None]
    position = np.array([0.5, -0.25]) + s * along
    velocity = rate * along + SPEED * s * across
    acceleration = 2.0 * SPEED * rate * across - SPEED**2 * s * along
    after = velocity + 0.5 * STEP * acceleration  # rows hold the velocity half a step on
    blocks = {}
    for k, (x, u, a) in enumerate((("x", "u", "ax"), ("y", "v", "ay"))):
        first = np.full(len(TIME), (0.5, -0.25)[k])
        blocks[f"particle_{x}"] = np.stack([0.0 * TIME, first, position[:, k]], axis=1)
        blocks[f"particle_{u}"] = np.stack([0.0 * TIME, 0.0 * TIME, after[:, k]], axis=1)
        blocks[f"particle_{a}"] = np.stack([0.0 * TIME, 0.0 * TIME, acceleration[:, k]], axis=1)
    blocks["particle_theta"] = np.stack([0.0 * TIME, angle, angle], axis=1)
    blocks["particle_w"] = np.stack([0.0 * TIME, 0.0 * TIME + SPEED, 0.0 * TIME + SPEED], axis=1)
    record = made_record(m, blocks, STEPS)
    s_found, v_found, a_found = slider_motion(record, "guide")
    assert s_found == pytest.approx(place, rel=1e-12)
    assert v_found == pytest.approx(rate, rel=1e-9) and a_found == pytest.approx(0.0, abs=1e-9 * SPEED**2)
    assert pin_places(record, "joint", "journal").shape == (len(TIME), 1, 2)
    with pytest.raises(ValueError, match="there are guide"):
        slider_motion(record, "O")
