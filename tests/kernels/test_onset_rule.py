"""Surfaces touch where the penetration is positive, however small, and nowhere else: every place that asks
answers alike.

The step, the start from the last forces, contacts that are solved together, statics and measures each ask.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from made_records import made_record
from support import four_bar, go, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.compiler.trace.tables import tables
from vfife.kernels import contact
from vfife.kernels.arrays import CONTACT, CONTACT_INDEX, HEADER, PARTICLE, SYSTEM
from vfife.kernels.central_difference import undamped
from vfife.kernels.contact_forces import solve_simultaneous
from vfife.laws import Frictionless, Hertz
from vfife.measures.forces import modes
from vfife.model.mechanism import Mechanism
from vfife.solvers import statics

# Penetrations (m) and whether surfaces touch there: a hundred-millionth of an atom either way.
RULE = [(1e-18, True), (0.0, False), (-1e-18, False)]
ACCELERATION, CLEARANCE, STIFFNESS, SPEED = 40.0, 5e-4, 6.6e10, 0.02  # m/s^2, m, N/m^1.5, m/s


def thrown(gravity: float) -> Mechanism:
    """A journal that begins at the centre of its bearing with SPEED under a constant acceleration."""
    m = journal_in_bearing(
        SPEED,
        clearance=CLEARANCE,
        friction=Frictionless(),
        contact=Hertz(stiffness=STIFFNESS),
        impact_speed_floor=1e-6,
    )
    m.gravity = (gravity, 0.0)
    return m


def place(time: float) -> float:
    """Distance of the journal from the centre (m) in free flight."""
    return SPEED * time + 0.5 * ACCELERATION * time * time


def crossing() -> float:
    """Time (s) at which the free flight has used up the clearance, by bisection."""
    low, high = 0.0, 1.0
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if place(middle) < CLEARANCE else (low, middle)
    return high


@pytest.mark.parametrize("step", [1.3e-7, 2.9e-7, 7.7e-7])
def test_a_contact_begins_in_the_first_step_that_ends_beyond_the_clearance(step: float) -> None:
    """Its impact speed is that of the flight at the crossing, whatever part of a step is left there; its
    first force is Hertz' of the penetration at the end of that step.
    """
    at = crossing()
    steps = math.ceil(at / step) + 40
    record = go(thrown(ACCELERATION), step, duration=steps * step, outputs=steps)
    first = int(np.flatnonzero(record.block("contact_onsets")[:, 0])[0])
    assert first == math.ceil(at / step)
    impact_speed = SPEED + ACCELERATION * at
    assert record.block("contact_approach")[-1, 0] == pytest.approx(impact_speed, rel=1e-9)
    assert 1.0 / record.block("contact_slowness")[first, 0] == pytest.approx(impact_speed, rel=1e-9)
    depth = place(first * step) - CLEARANCE
    assert record.block("contact_penetration")[first, 0] == pytest.approx(depth, abs=1e-12)
    # The contact acts within the step already, in its parts: some per cent of the force.
    assert record.block("contact_normal_force")[first, 0] == pytest.approx(STIFFNESS * depth**1.5, rel=0.05)
    assert not record.block("contact_normal_force")[:first].any()


def test_a_contact_ends_in_the_first_step_without_penetration() -> None:
    step = 1.1e-7
    at = crossing()
    record = go(thrown(ACCELERATION), step, duration=at + 1.5e-3, outputs=round((at + 1.5e-3) / step))
    depth, slowness, force = (
        record.block(f"contact_{name}")[:, 0] for name in ("penetration", "slowness", "normal_force")
    )
    assert ((depth > 0.0) == (slowness > 0.0)).all() and 0 < (depth > 0.0).sum() < len(depth) / 2
    assert not force[depth <= 0.0].any() and depth[-1] < 0.0
    touching = np.flatnonzero(depth > 0.0)
    assert np.diff(touching).max() == 1 and depth[touching].min() < 1e-8, "the surfaces part at nothing"


def prepared(mechanism: Mechanism) -> tuple[list[float], list[int], list[int]]:
    """State and topology of a mechanism as the kernels have them, and the records of its contacts."""
    assembly = assemble(mechanism, 1e-6, duration=1e-3, force_step=True)
    integers = [int(one) for one in tables(assembly.topology)[0]]
    contacts = range(integers[HEADER.contact], integers[HEADER.contact_end], CONTACT_INDEX.SIZE)
    return assembly.state.tolist(), integers, list(contacts)


@pytest.mark.parametrize("before", [0.0, 5.0], ids=["in flight", "in contact"])
@pytest.mark.parametrize(("depth", "touches"), RULE)
def test_a_step_is_in_contact_where_surfaces_touch(
    monkeypatch: pytest.MonkeyPatch, depth: float, touches: bool, before: float
) -> None:
    """An onset is counted and an end is an event only where that changes; the law sees what touches."""
    S, I, (r, *_) = prepared(journal_in_bearing())
    j = I[r + CONTACT_INDEX.row]
    seen: list[float] = []
    monkeypatch.setattr(
        contact, "evaluate_law", lambda S, I, r, depth, *rest: seen.append(depth) or (7.0, 8.0)
    )
    S[j + CONTACT.slowness], S[j + CONTACT.onsets], S[SYSTEM.event] = before, 3.0, 0.0
    S[j + CONTACT.penetration], S[j + CONTACT.duration] = before * 1e-9, 0.0
    contact.detect_contact(S, I, r, depth, False, 1.0, undamped(False, S[SYSTEM.step]))
    began, ended = touches and not before, bool(before) and not touches
    assert (S[j + CONTACT.slowness] > 0.0, S[j + CONTACT.onsets]) == (touches, 4.0 if began else 3.0)
    assert (S[SYSTEM.event] == 1.0, S[j + CONTACT.penetration]) == (began or ended, depth)
    assert seen == [depth if touches else 0.0]
    # The first step of a contact is an impact and counts as no duration.
    assert S[j + CONTACT.duration] == (S[SYSTEM.step] if touches and before else 0.0)


@pytest.mark.parametrize(("depth", "touches"), RULE)
def test_a_step_starts_from_the_last_forces_of_what_touches(depth: float, touches: bool) -> None:
    S, I, contacts = prepared(four_bar("BCD"))
    r = next(r for r in contacts if I[r + CONTACT_INDEX.shared] != 0)
    j, k = I[r + CONTACT_INDEX.row], I[r + CONTACT_INDEX.journal]
    S[j + CONTACT.penetration], S[j + CONTACT.nx], S[j + CONTACT.ny] = depth, 1.0, 0.0
    S[j + CONTACT.normal_force], S[j + CONTACT.friction_force] = 70.0, 3.0
    before = S[k + PARTICLE.fx]
    contact.put_last_forces(S, I, r, 1e-6)
    assert (S[j + CONTACT.normal], S[j + CONTACT.friction]) == ((70.0, 3.0) if touches else (0.0, 0.0))
    assert S[k + PARTICLE.fx] - before == (-70.0 if touches else 0.0)


def loose_block() -> Mechanism:
    """A free block in a guide with clearance: four corners that may touch at once."""
    m = Mechanism("block")
    m.point("G", 0.0, 0.0)
    m.rigid_body("block", mass=0.5, inertia=1e-3, position=(0.0, 0.0))
    m.clearance_slider("guide", "ground.G", "block.center", clearance=1e-3, length=0.1, height=0.06)
    return m


def solved_together(depths: tuple[float, float], damping: tuple[float, float]) -> list[float]:
    """Normal forces (N) of two corners that meet a wall at SPEED, from 50 N and these penetrations (m) and
    damping coefficients (N s/m), of a body of 1 kg in steps of 2e-6 s; its velocity is what they leave.
    """
    S, I, contacts = prepared(loose_block())
    assert all(I[r + CONTACT_INDEX.simultaneous] != 0 for r in contacts) and len(contacts) == 4
    body = I[contacts[0] + CONTACT_INDEX.journal]
    S[body + PARTICLE.inverse_mass] = 1.0
    S[body + PARTICLE.vu], S[body + PARTICLE.vv], S[body + PARTICLE.vw] = 0.0, SPEED, 0.0
    rows = [I[r + CONTACT_INDEX.row] for r in contacts]
    for j, depth, coefficient in zip(rows, (*depths, -1.0, -1.0), (*damping, 0.0, 0.0), strict=True):
        S[j + CONTACT.penetration], S[j + CONTACT.nx], S[j + CONTACT.ny] = depth, 0.0, 1.0
        S[j + CONTACT.jn] = S[j + CONTACT.bn] = S[j + CONTACT.normal] = 0.0
        S[j + CONTACT.elastic] = 50.0 if coefficient else 0.0
        S[j + CONTACT.damping_coefficient] = coefficient
    solve_simultaneous(S, I, 2e-6)
    found = [S[j + CONTACT.normal] for j in rows[:2]]
    assert S[body + PARTICLE.vv] == pytest.approx(SPEED - 2e-6 * sum(found), rel=1e-12)
    return found


def test_contacts_that_are_solved_together_share_the_body() -> None:
    """F = E + D r of both, and r = v - 2 h F / m: with h D / m = 2 the sweeps would diverge if either did not
    count, however small its penetration.
    """
    shared = (50.0 + 1e6 * SPEED) / (1.0 + 2.0 * 2e-6 * 1e6)
    assert solved_together((1e-18, 1e-18), (1e6, 1e6)) == pytest.approx([shared, shared], rel=1e-12)


@pytest.mark.parametrize("depth", [depth for depth, touches in RULE if not touches])
def test_a_corner_that_does_not_touch_shares_nothing(depth: float) -> None:
    """F = E + D r and r = v - h F / m in one sweep: counting the other corner would leave 0.4 %."""
    alone = (50.0 + 1e6 * SPEED) / (1.0 + 2e-6 * 1e6)
    assert solved_together((1e-6, depth), (1e6, 0.0)) == [pytest.approx(alone, rel=1e-12), 0.0]


@pytest.mark.parametrize(("depth", "touches"), RULE)
def test_the_mode_of_an_output_is_contact_where_surfaces_touch(depth: float, touches: bool) -> None:
    record = made_record(
        journal_in_bearing(), {"contact_penetration": [depth] * 3, "contact_onsets": [1.0] * 3}, [0, 10, 20]
    )
    assert modes(record)[1:, 0].tolist() == ([2, 2] if touches else [0, 0])


@pytest.mark.parametrize(("depth", "touches"), RULE)
def test_an_equilibrium_is_in_contact_where_surfaces_touch(depth: float, touches: bool) -> None:
    """There it has the floor of the impact speed; a run that starts from it begins no contact anew."""
    assembly = assemble(journal_in_bearing(impact_speed_floor=2e-3), 1e-6, duration=1e-3, force_step=True)
    state = assembly.state.copy()
    state[assembly.layout["contact_penetration"]] = depth
    relaxation: Any = SimpleNamespace(state=state, advance=lambda count: None)
    found = statics._at_rest(assembly, relaxation, cast(Any, SimpleNamespace(done=1.0, ratio=0.0)))
    assert found[assembly.layout["contact_slowness"]] == pytest.approx([500.0 if touches else 0.0])
