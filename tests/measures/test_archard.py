"""Wear against Archard's law in closed form: steady sliding under a weight, a pin on a plate, volumes of both
surfaces, depths around a joint.
"""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

import vfife
from vfife.laws.materials import PAIRS, coefficient
from vfife.measures.wear import PLACES, Rubbing, areas, depths, half_arc, rubbing, work_around
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear

WEIGHT, RADIUS, LENGTH, SPEED = 2.0 * 9.81, 0.010, 0.02, 2.0 * math.pi / 0.144  # N, m, m, rad/s
SOFT, HARD = 2e-14, 3e-15  # 1/Pa


def ring_on_shaft(wear: Wear, friction: float = 0.0) -> Mechanism:
    """A ring of 2 kg hangs on a shaft that turns and is kept from turning along; in the steady state F = m g
    and v = R_J w.
    """
    m = Mechanism("ring on a shaft", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("shaft", mass=1.0, inertia=1e-4, pins={"axis": (0.0, 0.0)})
    m.rigid_body("ring", mass=2.0, inertia=1e-3, pins={"bore": (0.0, 0.0)})
    m.revolute("O", "ground.O", "shaft.axis")
    m.slider("guide", "ground.O", "ring.bore", direction=(0.0, 1.0))
    m.clearance_joint("bore", "ring.bore", "shaft.axis", clearance=1e-4, bearing_radius=RADIUS,
        axial_length=LENGTH, wear=wear,
                friction=vfife.laws.Coulomb(coefficient=friction) if friction else vfife.laws.Frictionless(
                    ))  # fmt: skip
    m.drive("shaft", speed=SPEED)
    return dataclasses.replace(m, start=dataclasses.replace(m.start, journals="seated"))


@cache
def turning(wear: Wear = Wear(bearing=SOFT, journal=HARD)):  # noqa: B008
    return vfife.simulate(ring_on_shaft(wear), turns=2, outputs=360, step=2e-6, companions=0)


def test_a_shaft_under_a_weight_wears_its_bearing_in_one_place_and_itself_all_around():
    """V = k m g 2 pi R_J a turn; the bearing's top has all of its own, the journal's depth is k m g/L a turn
    everywhere.
    """
    found = turning()
    journal, distance = RADIUS - 1e-4, 2.0 * math.pi * (RADIUS - 1e-4)
    assert found.measures["bore.bearing_wear.total"] == pytest.approx(
        SOFT * WEIGHT * distance, rel=1e-3, abs=0.0
    )
    assert found.measures["bore.journal_wear.total"] == pytest.approx(
        HARD * WEIGHT * distance, rel=1e-3, abs=0.0
    )
    record = found.record
    half = dataclasses.replace(record, steps=record.steps[360:], source=record.rows[360:])
    bearing, around_journal = depths(half, 0)
    assert around_journal == pytest.approx(np.full(PLACES, HARD * WEIGHT / LENGTH), rel=0.02, abs=0.0)
    assert around_journal.sum() * areas(half, 0)[1] == pytest.approx(
        HARD * WEIGHT * 2.0 * math.pi * journal, rel=2e-3, abs=0.0
    )
    angle = np.linspace(-180.0, 180.0, PLACES, endpoint=False) + 180.0 / PLACES
    assert abs(angle[bearing > 0.01 * bearing.max()] - 90.0).max() < 2.0  # the ring hangs on the shaft


def test_a_pin_on_a_plate_loses_k_times_force_times_way():
    """Two round feet on an incline, each with its share of the weight: together k m g cos(slope) times the
    way that the block slides.
    """
    slope, friction, mass, end = math.radians(30.0), 0.3, 2.0, 0.2
    m = vfife.gallery.block_on_incline(slope=slope, friction=friction, mass=mass)
    for name in ("lower", "upper"):
        m.joints[name] = dataclasses.replace(m.joints[name], wear=Wear(journal=SOFT, bearing=HARD))
    found = vfife.simulate(m, duration=end, step=1e-5, companions=0)
    rates = 9.81 * math.cos(slope), 9.81 * (math.sin(slope) - friction * math.cos(slope))
    lost = found.channels["journal_wear"].values[-1].sum()
    assert lost == pytest.approx(SOFT * mass * rates[0] * 0.5 * rates[1] * end**2, rel=2e-3, abs=0.0)
    assert found.channels["bearing_wear"].values[-1].sum() == pytest.approx(
        HARD / SOFT * lost, rel=1e-12, abs=0.0
    )
    assert (
        "lower.journal_wear.total" in found.measures and "lower.journal_wear_depth.max" not in found.measures
    )


def test_volumes_of_both_surfaces_are_as_their_coefficients():
    """Also where contacts come and go: what one loses the other does, but for k."""
    m = vfife.gallery.slider_crank_loose_pin(friction=0.05)
    m.joints["pin"] = dataclasses.replace(m.joints["pin"], wear=Wear(bearing=SOFT, journal=HARD))
    found = vfife.simulate(m, turns=1, step=2e-6, companions=0)
    both = [
        depth.sum() * area
        for depth, area in zip(depths(found.record, 0), areas(found.record, 0), strict=True)
    ]
    assert both[0] / both[1] == pytest.approx(SOFT / HARD, rel=1e-12, abs=0.0)
    assert both[0] == pytest.approx(found.measures["pin.bearing_wear.total"], rel=1e-12, abs=0.0)
    lost = found.channels["friction_energy"].values[-1, 0]
    assert both[0] == pytest.approx(
        SOFT * lost / 0.05, rel=0.02, abs=0.0
    )  # friction works with 0.05 of the force, but where it sticks


def test_parts_of_an_interval_lie_on_an_arc():
    """sin(a)/a of an arc; what is laid around is all of it, on both sides of the seam."""
    arcs = np.array([0.0, 0.1, 1.0, 2.5])
    assert half_arc(np.sinc(arcs / np.pi)) == pytest.approx(arcs, abs=2e-3)
    found = work_around(Rubbing(np.array([3.0, 1.0]), np.array([np.pi - 0.1, 0.5]), np.array([0.3, 0.0])))
    assert found.sum() == pytest.approx(4.0, rel=1e-12, abs=0.0)
    assert found[: PLACES // 4].sum() == pytest.approx(
        3.0 * 0.2 / 0.6, rel=1e-9, abs=0.0
    )  # what lies beyond the seam
    assert np.flatnonzero(found[PLACES // 2 : -60]).tolist() in (
        [28, 29],
        [27, 28],
    )  # 0.5 rad, half a place to both sides


def test_a_pair_of_materials_has_its_coefficient_over_the_hardness():
    """K/H: mild steel of 163 HB has 4.4e-12 1/Pa, a severe dry one."""
    assert coefficient("mild steel on mild steel", vfife.laws.MATERIALS["steel"]) == pytest.approx(
        7e-3 / (163 * 9.80665e6), abs=0.0
    )
    assert (
        coefficient("ptfe on tool steel", vfife.laws.MATERIALS["ptfe"]) is None
        and coefficient(3e-15, vfife.laws.MATERIALS["ptfe"]) == 3e-15
    )
    assert all(0.0 < k < 1e-2 and source for k, source in PAIRS.values())


def test_where_nothing_is_rubbed_nothing_is_laid_around():
    assert not work_around(rubbing(turning(Wear()).record, 0, "bearing")).min() < 0.0
    assert not any(one.any() for one in depths(turning(Wear()).record, 0))
