"""Pieces of the limits of the step, each by hand: corners, mobilities, periods of contacts, rows of
constraints, arms.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.assembly.checks import idle_rows, redundant
from vfife.assembly.linearised import pulled_at
from vfife.assembly.stability import (
    CLOSED,
    _bent,
    arm_limits,
    at_once,
    attached_stiffness,
    constraint_rows,
    contact_limits,
    contact_periods,
    demands,
    joint_mobility,
    turning_errors,
)
from vfife.assembly.timestep import by_case
from vfife.laws import Material
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism
from vfife.model.springs import Spring


def started(m: Mechanism) -> Assembly:
    return assemble(m, 1e-7, duration=1e-3, force_step=True)


@pytest.mark.parametrize("turn", [0.0, math.pi, 0.3, -1.2, math.pi / 2.0])
def test_elements_meet_at_an_angle_where_they_are_not_in_line(turn: float) -> None:
    """Two in a row, the second turned: only the particle between them has a corner, and none where it goes
    straight on or back.
    """
    c, s = math.cos(0.4 + turn), math.sin(0.4 + turn)
    layout: Any = {"reference_cosine": np.array([0, 1]), "reference_sine": np.array([2, 3])}
    state = np.array([math.cos(0.4), c, math.sin(0.4), s])
    corner = abs(math.sin(turn)) > 1e-9
    assert _bent(layout, state, np.array([[0, 1], [1, 2]]), 4).tolist() == [False, corner, False, False]


def loose(offset: tuple[float, float] = (0.3, -0.4)) -> Assembly:
    """A body of 2 kg and 0.5 kg m^2 whose pin off its centre has clearance in a bearing on the ground."""
    m = Mechanism("loose", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("b", mass=2.0, inertia=0.5, pins={"p": offset})
    m.clearance_joint("J", "ground.O", "b.p", clearance=1e-4, bearing_radius=0.01, axial_length=0.02)
    return started(m)


def test_a_contact_meets_the_mass_and_the_arm_of_its_body() -> None:
    """1/m + r^2/I with r = 0.5 m; a stiffness k on it has half a period of pi/sqrt(k mobility) and the stable
    step 2/sqrt(k mobility).
    """
    one = loose()
    parts = one.layout, one.state, one.topology
    [mobility] = joint_mobility(*parts)
    assert mobility == pytest.approx(1.0 / 2.0 + 0.25 / 0.5, rel=1e-12)
    touch: Any = SimpleNamespace(
        name="J", joint=SimpleNamespace(name="J"), touching=SimpleNamespace(normal=(1.0, 0.0))
    )
    [(name, halves)] = contact_periods([touch], np.full((2, 1), 4e6), np.array([[mobility], [0.0]]))
    assert name == "J" and halves[1] == math.inf
    assert halves[0] == pytest.approx(math.pi / math.sqrt(4e6 * mobility), rel=1e-12)
    load = demands(*parts, attached_stiffness(*parts, np.array([4e6])))
    ((name, step),) = contact_limits([touch], *parts, load)
    stable = 2.0 / math.sqrt(4e6 * mobility)
    assert name == "contact of joint J" and 0.5 * stable < step <= stable


def test_corners_on_one_wall_share_its_stiffness() -> None:
    touches: Any = [
        SimpleNamespace(joint=SimpleNamespace(name=name), touching=SimpleNamespace(normal=normal))
        for name, normal in (("g", (0.0, 1.0)), ("g", (0.0, 1.0)), ("g", (0.0, -1.0)), ("J", (0.0, 1.0)))
    ]
    assert at_once(touches) == [2, 2, 1, 1]


def pendulum(angle: float = 0.7) -> Assembly:
    """A body of 2 kg and 0.5 kg m^2 on a pin 0.5 m from its centre."""
    m = Mechanism("pendulum", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.rigid_body("b", mass=2.0, inertia=0.5, angle=angle, pins={"p": (0.3, -0.4)})
    m.revolute("A", "ground.O", "b.p")
    return started(m)


def test_rows_of_a_pin_are_its_lever_wherever_the_body_is_turned() -> None:
    """x: (1, 0, -r_y), y: (0, 1, r_x), r from the body's particle to the pin; not turned unless said."""
    one = pendulum()
    parts = one.layout, one.state[None], one.topology
    theta = float(one.state[one.layout["particle_theta"]][1])
    for turn, [[rows]] in (
        (0.0, constraint_rows(*parts, [0, 1])),
        (0.4, constraint_rows(*parts, [0, 1], (0.4,))),
    ):
        c, s = math.cos(theta + turn), math.sin(theta + turn)
        rx, ry = 0.3 * c + 0.4 * s, 0.3 * s - 0.4 * c
        assert np.abs(rows[:, 3:]) == pytest.approx(
            np.abs(np.array([[1.0, 0.0, -ry], [0.0, 1.0, rx]])), abs=1e-12
        )
        assert rows[0, 3] * rows[0, 5] == pytest.approx(-ry, abs=1e-12) and rows[1, 4] * rows[
            1, 5
        ] == pytest.approx(rx, abs=1e-12)


@pytest.mark.parametrize("release", ["none", "start", "end", "both"])
@pytest.mark.parametrize("elements", [1, 3])
def test_limits_of_elements_go_with_the_root_of_mass_over_stiffness(release: str, elements: int) -> None:
    """A million times the mass and a quarter of Young's modulus: two thousand times the step, whichever ends
    are released.
    """

    def limits(mass: float, modulus: float) -> list[float]:
        m = Mechanism("beam", gravity=(0.0, 0.0))
        m.point("O", 0.0, 0.0)
        steel = Material(youngs_modulus=modulus)
        section = Section.square(4e-4)
        m.link(
            "l",
            length=0.6,
            mass=mass,
            model="elastic",
            elements=elements,
            section=section,
            material=steel,
            release=release,
        )
        m.revolute("A", "ground.O", "l.start")
        return [value for _, value in started(m).choice.limits]

    light, heavy = limits(1.0, 2e11), limits(1e6, 0.5e11)
    assert light and heavy == pytest.approx([2e3 * value for value in light], rel=1e-9)
    assert limits(1.0, 2e5) == pytest.approx([1e3 * value for value in light], rel=1e-9), (
        "so soft that EI/l is below 1 N m"
    )


def test_an_error_on_one_arm_grows_by_the_square_of_arm_over_radius_of_gyration() -> None:
    """r^2 m/I = 0.25 2/0.5."""
    one = pendulum()
    assert turning_errors(one.layout, one.state[None], one.topology)[0] == pytest.approx(1.0, rel=1e-4)


def test_rows_that_may_be_idle_are_of_unit_size_in_energy() -> None:
    """Row by row G M^-1 G^T is 1, whatever masses and inertias are; two pins of one body leave one reaction
    that moves nothing.
    """
    m = pendulum().mechanism
    door = Mechanism("door", gravity=(0.0, 0.0))
    door.point("O", 0.0, 0.0)
    door.point("P", 1.0, 0.0)
    door.rigid_body("b", mass=20.0, inertia=3.0, pins={"p": (0.0, 0.0), "q": (1.0, 0.0)}, position=(0.0, 0.0))
    door.revolute("A", "ground.O", "b.p")
    door.revolute("B", "ground.P", "b.q")
    for one, open_ in ((started(m), 0), (started(door), 1)):
        found = idle_rows(one.layout, one.state[None], one.topology)
        rows, joined, stress = (
            found.rows[0],
            found.joined,
            found.left[0, :, len(found.rows[0]) - found.deficient[0] :],
        )
        kinds = ("mass", "mass", "inertia")
        inverse = np.stack(
            [one.state[one.layout[f"particle_inverse_{kind}"]][joined] for kind in kinds], axis=1
        ).reshape(-1)
        assert (rows**2 * inverse).sum(axis=1) == pytest.approx(1.0, rel=1e-12)
        assert stress.shape[1] == open_ and list(redundant(one.layout, one.state[None], one.topology)) == [
            bool(open_)
        ]
        assert np.abs(rows.T @ stress * np.sqrt(inverse)[:, None]).max(initial=0.0) < 1e-12


def arms(one: Assembly, state: Any) -> list[tuple[str, float]]:
    return by_case(arm_limits(one.layout, state[None], one.topology, ["A"]), 1)[0]


def test_arms_limit_the_step_of_what_turns_and_nothing_at_rest() -> None:
    """w dt r/k = CLOSED, of the joint alone and of all together; k is the radius of gyration, sqrt(I/m)."""
    one = pendulum()
    assert arms(one, one.state) == []
    state = one.state.copy()
    state[one.layout["particle_w"][1]] = -8.0
    (name, step), (every, least) = arms(one, state)
    assert name == "small inertia on an arm at joint A" and step == pytest.approx(
        CLOSED * math.sqrt(0.5 / 2.0) / (0.5 * 8.0), rel=1e-12
    )
    assert every == "small inertia on arms of several joints" and least == pytest.approx(
        CLOSED / 8.0, rel=1e-4
    )
    state[one.layout["particle_w"][1]] = 0.5
    assert arms(one, state)[1] == (every, pytest.approx(CLOSED / 0.5, rel=1e-4))


def test_a_spring_pulls_its_pins_and_not_by_its_damper_at_rest() -> None:
    """0.5 m apart, free at 0.3 m, 100 N/m: 20 N towards each other, and their moments about
    both particles.
    """
    spring = Spring(name="k", first="ground.O", second="b.p", stiffness=100.0, damping=50.0, free_length=0.3)
    at = np.array([1.0, 2.0, 0.0, 1.0, 2.0, math.pi / 2.0])
    # The first pin is its particle; the second lies at (0.4, -0.3) of a body turned by a right angle: (0.3,
    # 0.4) in space.
    found = pulled_at(spring, 0.9, at, ((0, (0.0, 0.0)), (1, (0.4, -0.3))))
    assert found == pytest.approx(
        [12.0, 16.0, 0.0, -12.0, -16.0, 0.3 * -16.0 - 0.4 * -12.0], rel=1e-12, abs=1e-12
    )
