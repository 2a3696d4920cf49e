"""The step, outputs and lengths that follow from bounds which a test writes: arithmetic of turns, without any
mechanism's stiffness.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import StepChoice
from vfife.assembly.checks import missed
from vfife.assembly.timestep import (
    COARSE_STEPS,
    CONTACT_STEPS,
    FIRST_CONTACT_STEPS,
    SAFETY,
    TURN_STEPS,
    Bounds,
    StepRequest,
    Times,
    coarseness,
    length_of,
    size_of,
    spin_of,
    static_choice,
    step_within,
)
from vfife.errors import StepError
from vfife.model.mechanism import Mechanism, Settings
from vfife.model.springs import Spring

FREE = Bounds([], [], [])


def choice(
    bounds: Bounds = FREE,
    turn: float | None = 0.1,
    length: float = 0.2,
    step="auto",
    outputs: int = 100,
    **more,
) -> StepChoice:
    """The step of a run of 0.2 s with turns of 0.1 s and 100 outputs each, nothing else being prescribed."""
    times = Times(turn, length, more.pop("own", math.inf))
    return step_within(
        Settings(), bounds, times, lambda: iter(()), StepRequest(step, outputs=outputs, **more)
    )


def test_a_step_that_is_given_divides_a_turn_into_outputs() -> None:
    found = choice(step=1e-4)
    assert (found.step, found.outputs_every, found.outputs, found.steps, found.automatic) == (
        1e-4,
        10,
        200,
        2000,
        False,
    )
    assert (choice(step=1e-4, outputs=300).outputs_every, choice(step=1e-4, outputs=300).outputs) == (
        2,
        1000,
    ), "3.3 is none, 2 divides"
    half = choice(step=1e-4, length=0.05)
    assert (half.outputs_every, half.outputs) == (10, 50)
    short = choice(step=1e-4, length=3e-4)
    assert (short.outputs_every, short.outputs) == (3, 1), (
        "a run may be shorter than the time between two outputs"
    )


def test_an_automatic_step_is_nine_tenths_of_the_stable_one_and_divides_a_turn() -> None:
    stable = 1e-5
    found = choice(Bounds([("spring k", stable), ("beam", 2e-5)], [], []))
    every = math.ceil(0.1 / 100 / (SAFETY * stable))
    assert (found.outputs_every, found.outputs, found.step) == (
        every,
        200,
        0.1 / (100 * every),
    ) and found.automatic
    assert (found.stable, found.culprit) == (stable, "spring k")
    plain = choice()
    assert (
        plain.step == pytest.approx(0.1 / TURN_STEPS)
        and plain.culprit == f"{TURN_STEPS} steps a turn"
        and plain.stable == math.inf
    )
    own = choice(own=0.05)
    assert own.step == pytest.approx(0.05 / TURN_STEPS) and own.culprit == "the motion itself"
    assert choice(own=0.1).culprit == f"{TURN_STEPS} steps a turn", (
        "a turn as long as the own period names itself"
    )
    still = choice(turn=None, length=0.35, own=0.1)
    assert still.step <= 0.1 / TURN_STEPS and still.step * still.steps == pytest.approx(0.35)


def test_contacts_have_their_steps_and_only_the_shortest_arm_counts() -> None:
    found = choice(Bounds([], [], [("J", 1e-3), ("K", 4e-4)]))
    assert found.step <= 4e-4 / CONTACT_STEPS < 1.1 * found.step and "joint K, 80 steps" in found.culprit
    fewer = choice(Bounds([], [], [("J", 1e-3), ("K", 4e-4)]), contact_steps=16)
    assert fewer.step <= 4e-4 / 16 < 1.1 * fewer.step
    search = choice(Bounds([], [], [("J", 1e-3), ("K", 4e-4)]), contact_steps=FIRST_CONTACT_STEPS)
    assert search.step <= 0.5 * 4e-4 / FIRST_CONTACT_STEPS < 1.1 * search.step, (
        "half of it, so that a companion has all of it"
    )
    assert "joint K, 40 steps" in search.culprit, "as docs/trust.md says"
    arms = choice(Bounds([("s", 3e-5)], [("long", 2e-5), ("short", 1e-5)], []))
    assert arms.limits == (("s", 3e-5), ("short", 1e-5)) and arms.stable == 1e-5


def test_what_is_too_large_or_endless_is_refused_unless_forced() -> None:
    bounds = Bounds([("spring k", 1e-5)], [], [])
    assert choice(bounds, step=9e-6).step == 9e-6
    with pytest.raises(StepError, match="spring k allows 1e-05 s"):
        choice(bounds, step=9.1e-6)
    assert choice(bounds, step=9.1e-6, force_step=True).step == 9.1e-6
    with pytest.raises(StepError, match="longer than the whole run"):
        choice(step=0.41)
    assert choice(step=0.39).steps == 1 == choice(step=0.41, force_step=True).steps
    with pytest.raises(StepError, match="no run does more"):
        choice(step=1e-18)


def test_runs_last_as_long_as_is_said() -> None:
    m = four_bar()
    assert [
        length_of(m, *said)
        for said in ((3.0, None, 0.1), (None, 0.7, 0.1), (None, None, 0.1), (None, None, None))
    ] == pytest.approx([0.3, 0.7, 0.2, 1.0])
    m = replace(m, settings=replace(m.settings, turns=5.0))
    assert length_of(m, None, None, 0.1) == pytest.approx(0.5) and length_of(m, None, 0.3, 0.1) == 0.3
    loads = replace(m, settings=replace(m.settings, analysis="static", load_factors=(0.5, 1.0)))
    assert (static_choice(loads).step, static_choice(loads).outputs) == (1.0, 2)


def test_coarse_steps_are_corrected_more_often() -> None:
    """By one for each of 1500, 500 and 250 steps a turn that there are fewer."""
    at = replace(choice(step=1e-4), step=1.0)
    assert [coarseness(at, 2.0 * math.pi / steps) for steps in (1600, 1400, 600, 400, 260, 240)] == [
        0,
        1,
        1,
        2,
        2,
        3,
    ]
    assert len(COARSE_STEPS) == 3


def free_body(**changes) -> Mechanism:
    m = Mechanism("free", gravity=changes.pop("gravity", (0.0, 0.0)))
    m.rigid_body("b", mass=1.0, inertia=0.1, pins={"p": (0.3, 0.4)}, **changes)
    return m


def test_a_free_motion_resolves_its_own_period() -> None:
    """2 pi over the spin, 2 pi size over the speed, 2 pi sqrt(size/g), or the run, the least of them, in 3600
    steps; the size is 0.5 m.
    """
    assert size_of(free_body()) == 0.5
    periods = {
        math.tau / 30.0: free_body(velocity=(0.0, 0.0, 30.0)),
        math.tau * 0.5 / 5.0: free_body(velocity=(3.0, -4.0, 0.0)),
        math.tau * math.sqrt(0.5 / 5.0): free_body(gravity=(3.0, -4.0)),
        10.0: free_body(),
    }
    for period, m in periods.items():
        found = assemble(m, duration=10.0, outputs=1000).choice
        assert found.step <= period / TURN_STEPS * (1.0 + 1e-9) and found.step > 0.7 * period / TURN_STEPS
    spinning = assemble(free_body(velocity=(0.0, 0.0, -30.0)), duration=1.0)
    said = (spinning.mechanism, spinning.layout, spinning.state)
    assert spin_of(None, *said) == 30.0 and spin_of(0.5, *said) == pytest.approx(4.0 * math.pi)
    assert missed(spinning.mechanism, spinning.choice, *said[1:]) == ()


def test_the_speed_of_a_body_without_extent_leaves_the_steps_of_a_turn_alone() -> None:
    """A mass whose pin is its centre has no size; a basin over its velocity took 14 times the steps that one
    over the speed of its journal took.
    """

    def at(velocity: tuple[float, float, float], crank: bool) -> StepChoice:
        m = Mechanism("mass")
        m.rigid_body("mass", mass=1.0, inertia=0.1, velocity=velocity)
        if crank:
            rotor = m.rigid_body("rotor", mass=0.1, inertia=1e-4, position=(0.5, 0.0))
            m.revolute("shaft", m.point("Q", 0.5, 0.0), rotor.pin())
            m.drive(rotor, speed=22.0)
        return assemble(m, turns=10.0 if crank else None, duration=None if crank else 1.0).choice

    assert at((0.3, 0.0, 0.0), crank=True).step == at((0.0, 0.0, 0.0), crank=True).step
    assert at((0.3, 0.0, 100.0), crank=True).step < 0.5 * at((0.0, 0.0, 0.0), crank=True).step
    assert at((0.3, 0.0, 0.0), crank=False).step < 0.1 * at((0.0, 0.0, 0.0), crank=False).step


def test_a_spring_limits_the_step_by_its_frequency() -> None:
    """A mass on a spring, 2/omega = 2 sqrt(m/k)."""
    m = Mechanism("mass", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.point_mass("b", mass=2.0, position=(0.1, 0.0))
    m.springs["k"] = Spring(name="k", first="ground.O", second="b.center", stiffness=5e6, free_length=0.1)
    found = assemble(m, duration=0.1).choice
    assert found.limits == (("spring k", pytest.approx(2.0 * math.sqrt(2.0 / 5e6), rel=1e-9)),)
    assert found.stable == found.limits[0][1] and found.culprit == "the motion itself"
