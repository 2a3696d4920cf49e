"""Step of an elastic body that touches another: vibrations of its mesh do not grow, here and in a chain of
two masses that shares no code with the package.
"""

from __future__ import annotations

import numpy as np
import pytest

import vfife
from vfife.assembly.timestep import CONTACT_SHARE, SAFETY
from vfife.laws import Frictionless, Hertz, Material
from vfife.model.bodies import Section

STEEL = Material(youngs_modulus=210e9, poissons_ratio=0.3, density=7850.0)


def four_bar(elements: int, *, loose: bool, bars: bool = False) -> vfife.Mechanism:
    """A four-bar with an elastic coupler, without friction and damping, whose end is loose or ideal."""
    m = vfife.Mechanism("four-bar", gravity=(0.0, -9.81))
    m.point("A", 0.0, 0.0)
    m.point("D", 0.3, 0.0)
    m.link("crank", length=0.08, mass=0.3)
    m.link(
        "coupler",
        length=0.26,
        model="elastic",
        section=Section.rectangle(0.015, 0.008),
        material=STEEL,
        elements=elements,
        angle=np.radians(50.0),
        release="both" if bars else "none",
    )
    m.link("rocker", length=0.22, mass=0.8, angle=np.radians(110.0))
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    if loose:
        m.clearance_joint(
            "C", "coupler.end", "rocker.end", clearance=1e-4, bearing_radius=0.008, axial_length=0.015,
            contact=Hertz(), friction=Frictionless(),
        )  # fmt: skip
    else:
        m.revolute("C", "coupler.end", "rocker.end")
    m.revolute("D", "ground.D", "rocker.start")
    m.drive("crank", speed=62.831853)
    return m


@pytest.mark.parametrize("elements", [4, 16])
def test_vibrations_that_contact_excites_do_not_grow(elements: int) -> None:
    mechanism = four_bar(elements, loose=True)
    stable = vfife.simulate(mechanism, duration=1e-4, reference=False).summary["run"]["stable_step"]
    run = {"duration": 0.03, "companions": 0, "reference": False, "outputs": 90}
    sound = vfife.simulate(mechanism, step=0.999 * SAFETY * stable, **run)
    assert sound.status == "complete" and sound.summary["energy_error"] < 1e-3
    beyond = vfife.simulate(mechanism, step=SAFETY * stable / CONTACT_SHARE, force_step=True, **run)
    assert beyond.status == "diverged"


def limits(mechanism: vfife.Mechanism) -> dict[str, float]:
    return dict(vfife.simulate(mechanism, duration=1e-4).record.assembly.choice.limits)


def test_elements_whose_body_touches_nothing_keep_the_whole_limit() -> None:
    loose, ideal = limits(four_bar(16, loose=True)), limits(four_bar(16, loose=False))
    bending = "element 16 of coupler (bending{})"
    assert bending.format("") in ideal and bending.format("") not in loose
    share = loose[bending.format(", beside contact")] / ideal[bending.format("")]
    assert 0.9 * CONTACT_SHARE < share <= CONTACT_SHARE


def test_a_bar_keeps_the_whole_limit() -> None:
    assert "element 1 of coupler (axial)" in limits(four_bar(1, loose=True, bars=True))


def growth(shares: list[float], seconds: float) -> np.ndarray:
    """Return the largest energy over the first one of two masses on a spring that fall upright on an elastic
    Hertz contact, without damping, for steps of each share of the stable one.

    mass 0.25 kg each, spring 2 MN/m, contact 0.5 GN/m^1.5, height 10 mm; central difference.
    """
    mass, spring, contact, weight = 0.25, 2e6, 5e8, 9.81
    step = np.array(shares) * 2.0 / np.sqrt(2.0 * spring / mass)
    height, velocity = np.tile([[0.01], [0.01]], len(shares)), np.zeros((2, len(shares)))
    first, largest = np.full(len(shares), 2.0 * mass * weight * 0.01), np.zeros(len(shares))
    counts = (seconds / step).astype(int)
    for k in range(counts.max()):
        stretch, depth = height[1] - height[0], np.maximum(-height[0], 0.0)
        pull = spring * stretch
        rate = np.array([pull + contact * depth * np.sqrt(depth), -pull]) / mass - weight
        half = velocity + 0.5 * step * rate  # at the whole step, for the energy
        kinetic = 0.5 * mass * (half * half).sum(axis=0)
        stored = 0.5 * pull * stretch + 0.4 * contact * depth**2.5 + mass * weight * height.sum(axis=0)
        largest = np.maximum(largest, np.where(k < counts, kinetic + stored, 0.0))
        velocity = velocity + step * rate
        height = height + step * velocity
    return largest / first


def test_growth_begins_at_resonances_of_low_order() -> None:
    """A share of sin(pi/n) has n steps in a period of the fastest vibration. The contact is resolved with
    more than 100 steps in all cases.
    """
    resonances = [float(np.sin(np.pi / order)) for order in (4, 5, 6)]
    energies = growth([CONTACT_SHARE, *resonances], 4.0)
    assert energies[0] < 1.1
    assert (energies[1:] > 5.0).all()
