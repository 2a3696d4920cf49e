"""The energy ledger closes, at second order, and each of its terms is the energy it says."""

import dataclasses
import math

import numpy as np
import pytest

from support import SQUARE, four_bar, go, journal_in_bearing, times, with_settings
from vfife.laws import Ambrosio, ContactLaw, LankaraniNikravesh
from vfife.laws.elasticity import elastic_energy
from vfife.measures import ledger
from vfife.measures.motion import velocities
from vfife.model.mechanism import Mechanism

G = 9.81


def pendulum(driven: bool = False) -> Mechanism:
    m = Mechanism("pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0, center_at=0.7, inertia=0.1, angle=0.3)
    m.revolute("A", "ground.O", "rod.start")
    if driven:
        m.drive("rod", speed=3.0)
    return m


def test_ledger_closes_at_second_order() -> None:
    coarse, fine = (ledger(go(four_bar(), step, turns=1.0)).error for step in (4e-6, 2e-6))
    assert fine < 2e-6
    assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.3)


def test_ledger_notices_a_wrong_work() -> None:
    """One per cent of the friction work missing is found."""
    record = go(four_bar(), 2e-6, turns=1.0)
    where = [
        k
        for k, row in enumerate(record.row_numbers)
        if row in record.assembly.layout["contact_friction_work"]
    ]
    rows = record.rows.copy()
    rows[:, where] *= 0.99
    assert ledger(dataclasses.replace(record, source=rows)).error > 1e-4


@pytest.mark.parametrize("release", ["none", "start", "both"])
def test_elastic_damped_links(release: str) -> None:
    m = four_bar(model="elastic", section=SQUARE, elements=1 if release == "both" else 3, release=release)
    book = ledger(go(with_settings(m, damping=20.0), 1e-6, turns=0.5))
    assert book.terms["strain"].max() > 1.0
    assert book.terms["damping_loss"][-1] > 100.0
    assert book.error < 2e-5


def test_path_units_of_several_steps() -> None:
    m = with_settings(four_bar(clear="C", model="elastic", section=SQUARE, elements=3), path_unit=7)
    assert ledger(go(m, 1e-6, turns=0.25)).error < 1e-5


def test_pendulum_swaps_weight_for_motion() -> None:
    record = go(pendulum(), 1e-4, duration=1.0)
    book, angle = ledger(record), record.block("particle_theta")[:, 1]
    fallen = 0.7 * (math.sin(0.3) - np.sin(angle))
    assert book.terms["external"] == pytest.approx(2.0 * G * fallen, abs=1e-9)
    w = velocities(record)["w"][:, 1]
    assert book.terms["kinetic"] == pytest.approx(0.5 * (0.1 + 2.0 * 0.7**2) * w**2, abs=1e-4)
    assert book.error < 1e-6


def test_driver_lifts_a_weight() -> None:
    record = go(pendulum(driven=True), 1e-4, duration=0.4)
    book = ledger(record)
    lifted = 2.0 * G * 0.7 * (math.sin(0.3 + 3.0 * times(record)[-1]) - math.sin(0.3))
    assert book.terms["external"][-1] == pytest.approx(-lifted, rel=1e-12)
    assert book.terms["driver"][-1] == pytest.approx(lifted, rel=1e-7)
    assert book.terms["kinetic"] == pytest.approx(0.5 * (0.1 + 2.0 * 0.7**2) * 9.0)


def test_moment_that_changes_in_time() -> None:
    from vfife.model.loads import PointForce

    m = dataclasses.replace(pendulum(), gravity=(0.0, 0.0))
    m.loads["push"] = PointForce(
        name="push",
        at="rod.end",
        force=(1.0, 2.0),
        moment=3.0,
        times=(0.0, 0.5, 1.0),
        factors=(0.0, 1.0, -1.0),
    )
    book = ledger(go(m, 1e-4, duration=1.0))
    assert abs(book.terms["external"]).max() > 0.5
    assert book.error < 1e-6


def test_contact_stores_what_the_journal_had() -> None:
    """At its greatest depth a journal of 1 kg and 1 m/s has given all of its energy to the contact and the
    losses.
    """
    law = LankaraniNikravesh(restitution=0.9, stiffness=6.6e10)
    record = go(
        journal_in_bearing(contact=law, friction=Ambrosio(coefficient=0.0)), 1e-7, duration=7e-4, outputs=7000
    )
    book = ledger(record)
    assert book.terms["kinetic"][0] == pytest.approx(0.5)
    deepest = int(np.argmax(record.block("contact_penetration")[:, 0]))
    assert book.terms["contact"][deepest] + book.terms["contact_loss"][deepest] == pytest.approx(
        0.5, rel=1e-5
    )
    assert book.terms["contact_loss"][-1] == pytest.approx(0.5 * (1.0 - 0.913177**2), rel=1e-4)


def test_law_without_an_energy_is_summed_up() -> None:
    class Bare(ContactLaw):
        force = staticmethod(LankaraniNikravesh.force)

    depth, slots = np.linspace(0.0, 1e-4, 7), (6.6e10, 0.1)
    own = LankaraniNikravesh().elastic_energy(depth, slots)
    assert elastic_energy(Bare(), depth, slots) == pytest.approx(own, rel=1e-5, abs=1e-9)
