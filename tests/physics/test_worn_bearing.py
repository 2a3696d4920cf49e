"""A journal in a bearing, both worn out of round: what is conserved, and two shapes of which the answer is
known.
"""

import math

import numpy as np
import pytest

from support import go
from vfife.assembly.assemble import assemble
from vfife.laws import Frictionless, Hertz
from vfife.model.mechanism import Mechanism
from vfife.model.wear import Wear
from vfife.solvers.transient import run

CLEARANCE, RADIUS = 2e-4, 0.01  # m
BEARING, JOURNAL = (2e-5, 1e-5, -4e-6, 3e-6, 5e-6), (1e-5, 2e-6, 6e-6)  # m
SIZES = {
    "clearance": CLEARANCE,
    "bearing_radius": RADIUS,
    "contact": Hertz(stiffness=1e9),
    "friction": Frictionless(),
}


def afloat(wear: Wear | None) -> Mechanism:
    """A ring and a pin without weight fly, turn and strike each other."""
    m = Mechanism("a pin in a ring")
    m.rigid_body("ring", mass=0.3, inertia=4e-5, pins={"bore": (0.0, 0.0)}, velocity=(-0.1, 0.05, 60.0))
    m.rigid_body("pin", mass=0.2, inertia=1e-5, pins={"axis": (0.0, 0.0)}, velocity=(0.4, -0.2, -150.0))
    m.clearance_joint("bore", "ring.bore", "pin.axis", wear=wear, **SIZES)
    return m


def conserved(step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Total energy (J), moment of momentum (N m s) and momentum (N s) at the outputs where
    nothing touches.
    """
    record = go(
        afloat(Wear(bearing_profile=BEARING, journal_profile=JOURNAL)), step, duration=0.02, outputs=2000
    )
    apart = record.block("contact_penetration")[:, 0] < 0.0
    assert record.block("contact_onsets")[-1, 0] > 15
    x, y, _, u, v, w = (
        record.block(f"particle_{name}")[apart, 1:] for name in ("x", "y", "theta", "u", "v", "w")
    )
    mass, inertia = np.array([0.3, 0.2]), np.array([4e-5, 1e-5])
    x, y = x + 0.5 * step * u, y + 0.5 * step * v
    energy = 0.5 * (mass * (u * u + v * v) + inertia * w * w).sum(axis=1)
    moment = (mass * (x * v - y * u) + inertia * w).sum(axis=1)
    return energy, moment, np.stack([(mass * u).sum(axis=1), (mass * v).sum(axis=1)])


def test_energy_and_momenta_stay():
    """Forces of worn surfaces have a potential: the energy stays to the square of the step, momenta to
    rounding; bodies turn by it.
    """
    changes = []
    for step in (4e-7, 2e-7):
        energy, moment, momentum = conserved(step)
        assert moment == pytest.approx(moment[0], rel=1e-9) and np.ptp(momentum, axis=1) == pytest.approx(
            [0.0, 0.0], abs=1e-14
        )
        changes.append(np.abs(energy / energy[0] - 1.0).max())
    assert changes[1] < 2e-4 and changes[1] < 0.6 * changes[0]


def test_bodies_are_turned_by_worn_surfaces():
    """Without friction only the slope of a profile gives them spin."""
    spins = [
        go(afloat(wear), 1e-6, duration=0.01, outputs=20).block("particle_w")[-1, 1:]
        for wear in (None, Wear(bearing_profile=BEARING))
    ]
    assert spins[0] == pytest.approx([60.0, -150.0], rel=1e-12)
    assert abs(spins[1][0] - 60.0) > 1e-3 and spins[1][1] == pytest.approx(-150.0, rel=1e-12)


def impact(
    wear: Wear | None, clearance: float, shift: float = 0.0, angle: float = 0.7, turned: float = 0.0
) -> np.ndarray:
    """Where the journal is, and how fast, after it flew at 1 m/s against the wall in a direction; the
    bearing's centre is ``shift`` (m) along x.
    """
    m = Mechanism("impact")
    m.point("O", 0.0, 0.0)
    m.rigid_body(
        "journal",
        mass=1.0,
        inertia=1e-4,
        angle=turned,
        pins={"axis": (0.0, 0.0)},
        velocity=(math.cos(angle), math.sin(angle), 0.0),
    )
    m.clearance_joint("O", "ground.O", "journal.axis", wear=wear, **SIZES | {"clearance": clearance})
    assembly = assemble(m, 5e-7, duration=8e-4, outputs=4)
    assembly.state[assembly.layout.row("contact_bearing_x")] = shift
    record = run(assembly)
    return np.array([record.block(f"particle_{name}")[-1, 1] for name in ("x", "y", "u", "v")])


def test_an_even_depth_is_as_much_more_clearance():
    """Of the bearing, of the journal, or of both."""
    wider = impact(None, CLEARANCE + 3e-5)
    for wear in (
        Wear(bearing_profile=(3e-5,)),
        Wear(journal_profile=(3e-5,)),
        Wear(bearing_profile=(1e-5,), journal_profile=(2e-5,)),
    ):
        assert impact(wear, CLEARANCE) == pytest.approx(wider, rel=1e-9)


def test_where_a_surface_is_worn_is_said_in_the_frame_of_its_body():
    """A journal worn on its own x side, turned by 0.3, is a bearing worn at 0.3."""
    size, angle = 1e-5, 0.3
    own = impact(Wear(journal_profile=(size, size, 0.0)), CLEARANCE, turned=angle)
    same = impact(Wear(bearing_profile=(size, size * math.cos(angle), size * math.sin(angle))), CLEARANCE)
    assert own[:2] == pytest.approx(same[:2], rel=1e-3) and own[2:] == pytest.approx(same[2:], rel=1e-3)


@pytest.mark.parametrize("shift", [1e-6, 4e-6])
def test_a_cosine_is_a_bearing_whose_centre_lies_elsewhere(shift):
    """|e - a x| = e - a cos(psi) + a^2 sin^2(psi)/(2 e): the same impact, to the second order of a/c."""
    ways = [
        impact(Wear(bearing_profile=(0.0, shift, 0.0)), CLEARANCE),
        impact(None, CLEARANCE, shift),
        impact(None, CLEARANCE),
    ]
    assert np.abs(ways[0] - ways[1]).max() < 3.0 * (shift / CLEARANCE) * np.abs(ways[0] - ways[2]).max()
