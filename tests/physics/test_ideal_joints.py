"""Ideal joints: coincidence, reactions against closed forms and published maxima, several links on one pin, a
start without ringing.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.signal import savgol_filter

import vfife
from choice import default_cases
from support import (
    CRANK_SPEED,
    SQUARE,
    TURN,
    four_bar,
    go,
    joint_gap,
    largest_alpha,
    largest_force,
    particle,
    pin,
    with_settings,
    within,
)
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, StartSettings

# Maxima with ideal joints at constant crank speed: method.md, section 2. Speed/pi, follower (rad/s^2), joints
# B, C, D (N) of uniform rods
# and of one two-particle element per link.
IDEAL = [
    (10, 912.642, (1577.0, 2613.5, 4538.6), (2469.2, 3577.2, 5434.3)),
    (20, 3650.57, (6308.1, 10454.1, 18154.4), (9876.6, 14308.9, 21737.3)),
    (50, 22816.05, (39425.3, 65338.1, 113464.7), (61728.8, 89430.6, 135858.1)),
]

# ------------------------------------------------------------------------------------------------ coincidence

FOUR_BARS = {
    "rigid": (four_bar(""), 2e-6),
    "two-particle": (four_bar("", "two-particle", section=SQUARE), 1e-6),
    "elastic": (four_bar("", "elastic", elements=4, section=SQUARE), 1e-6),
    "one clearance": (four_bar("C"), 2e-6),
}


def gaps(name: str, steps: int) -> dict[str, float]:
    mechanism, step = FOUR_BARS[name]
    record = go(mechanism, step, duration=steps * step, outputs=200)
    return {
        joint: joint_gap(record, joint) for joint in mechanism.joints if joint not in record.assembly.contacts
    }


@pytest.mark.parametrize("name", FOUR_BARS)
def test_bearing_and_journal_coincide(name):
    """To 1e-12 m over 20,000 steps, to ground, to a driven body and between free ones, where steps change
    their size too.
    """
    found = gaps(name, 20_000)
    assert len(found) >= 3 and max(found.values()) < 1e-12, found


@pytest.mark.verify
@pytest.mark.parametrize("name", FOUR_BARS)
def test_bearing_and_journal_coincide_over_a_million_steps(name):
    found = gaps(name, 1_000_000)
    assert max(found.values()) < 1e-12, found


# -------------------------------------------------------------------------------------------------- reactions


@pytest.mark.parametrize("below", [False, True], ids=["above", "below"])
@pytest.mark.parametrize(("speed", "alpha", "rods", "lumped"), IDEAL)
def test_maxima_of_rigid_links(speed, alpha, rods, lumped, below):
    """Uniform rods, either assembly. The issue asks for 1e-3; the table's digits allow 2e-5."""
    record = go(four_bar("", speed=speed * math.pi, below=below), 2 / speed / 20000, turns=1)
    window = within(record, 0, 1)
    assert largest_alpha(record, "follower", window) == pytest.approx(alpha, rel=2e-6)
    assert [largest_force(record, joint, window) for joint in "BCD"] == pytest.approx(rods, rel=3e-5)


@pytest.mark.parametrize(("speed", "alpha", "rods", "lumped"), IDEAL)
def test_maxima_of_two_particle_links_made_rigid(speed, alpha, rods, lumped):
    """Half the mass at each end, the reference that a clearance run with such links is compared with."""
    m = four_bar("BCD", "two-particle", speed=speed * math.pi, section=SQUARE, release="both").ideal()
    record = go(m, 2 / speed / 20000, turns=1)
    window = within(record, 0, 1)
    assert largest_alpha(record, "follower", window) == pytest.approx(alpha, rel=2e-6)
    assert [largest_force(record, joint, window) for joint in "BCD"] == pytest.approx(lumped, rel=3e-5)


@pytest.mark.parametrize(("release", "tolerance"), [("both", 3e-4), ("none", 2e-3)])
@pytest.mark.parametrize(
    ("speed", "alpha", "rods", "lumped"),
    [
        IDEAL[1],
        *(pytest.param(*one, marks=pytest.mark.system("whole turns of stiff links")) for one in IDEAL[2:]),
    ],
)
def test_maxima_of_stiff_two_particle_links(speed, alpha, rods, lumped, release, tolerance):
    """A thousand times as stiff as steel, as frames and as bars. Rotary inertia of a frame's ends (Eq. 2) is
    in no table: 0.16 %.
    """
    m = four_bar(
        "", "two-particle", speed=speed * math.pi, section=SQUARE, release=release, stiffness_factor=1000.0
    )
    record = go(m, 7e-7, turns=1)
    window = within(record, 0, 1)
    assert largest_alpha(record, "follower", window) == pytest.approx(alpha, rel=3e-4)
    assert [largest_force(record, joint, window) for joint in "BCD"] == pytest.approx(lumped, rel=tolerance)


def two_particles(**settings) -> Mechanism:
    """Two particles in one ideal joint, each pushed on its own."""
    m = Mechanism("pair", gravity=(1.0, -9.81))
    m.point_mass("bearing", mass=2.0, velocity=(1.0, 2.0, 0.0))
    m.point_mass("journal", mass=5.0, velocity=(1.0, 2.0, 0.0))
    m.revolute("J", "bearing.center", "journal.center")
    m.loads["p"] = PointForce(name="p", at="bearing.center", force=(30.0, -7.0))
    m.loads["q"] = PointForce(
        name="q", at="journal.center", force=(-11.0, 50.0), times=(0.0, 1.0), factors=(1.0, 3.0)
    )
    return with_settings(m, **settings)


@pytest.mark.parametrize("damping", [0.0, 5.0])
def test_reaction_between_two_particles(damping):
    """Eq. 16 with external forces P: f on the journal = [m_J (f_q - P_B) - m_B (f_s - P_J)]/(m_J + m_B) with
    f_q = f_s = 0, sign by m_J a = P_J + reaction; weight and mass-proportional damping accelerate both alike
    and drop out.
    """
    record = go(two_particles(damping=damping), 1e-4, duration=0.1, outputs=100)
    t = record.steps * 1e-4
    p, q = np.array([30.0, -7.0]), np.outer(1 + 2 * t, [-11.0, 50.0])
    expected = (5.0 * p - 2.0 * q) / 7.0
    found = np.stack([record.block("joint_fx")[:, 0], record.block("joint_fy")[:, 0]], axis=1)
    assert found == pytest.approx(expected, rel=0, abs=1e-6)
    assert joint_gap(record, "J") < 1e-15
    if not damping:
        there = particle(record, "journal")["y"][-1]
        assert there == pytest.approx(
            2.0 * 0.1 - 9.81 * 0.005 + (-7.0 + 50.0) / 7 * 0.005 + 100.0 / 7 * 0.001 / 6, rel=1e-6
        )


def test_reaction_between_two_elastic_links():
    """The same with internal forces, read from the elements: two bars on one pin, one of them pushed at the
    pin.
    """
    m = Mechanism("bars", start=StartSettings(mode="rough"))
    bars = {"model": "two-particle", "section": SQUARE, "release": "both"}
    m.link("a", length=0.4, mass=3.0, angle=0.3, velocity=(0.0, 0.0, 50.0), **bars)
    m.link("b", length=0.3, mass=2.0, angle=1.9, velocity=(0.0, 0.0, -80.0), start_mass=0.5, **bars)
    m.revolute("J", "a.end", "b.start")
    m.loads["p"] = PointForce(name="p", at="b.start", force=(1e4, -2e4))
    record = go(m, 4e-6, duration=2e-3, outputs=100)
    tension = record.block("frame_axial_force")

    def along(name: str) -> np.ndarray:
        chord = pin(record, name, "end") - pin(record, name, "start")
        return chord / np.linalg.norm(chord, axis=1)[:, None]

    on_bearing = -tension[:, :1] * along("a")  # of the element on a's end
    on_journal = tension[:, 1:] * along("b") + np.array([1e4, -2e4])
    m_b, m_j = 1.5, 1.5
    expected = (m_j * on_bearing - m_b * on_journal) / (m_j + m_b)
    found = np.stack([record.block("joint_fx")[:, 0], record.block("joint_fy")[:, 0]], axis=1)
    assert np.abs(tension).max(axis=0).min() > 2e3
    assert found == pytest.approx(expected, rel=0, abs=1e-8 * np.abs(expected).max())


# ------------------------------------------------------------------------------------------------- three
# links on one pin


def star(joints: tuple[tuple[str, str], ...], spin: float = 30.0) -> Mechanism:
    """Three rods of 0.6 m and 2 kg on one pin, 120 degrees apart, turning about it."""
    m = Mechanism("star")
    for k, name in enumerate("abc"):
        angle = 0.2 + 2 * math.pi * k / 3
        m.link(name, length=0.6, mass=2.0, angle=angle, velocity=(0.0, 0.0, spin))
    for bearing, journal in joints:
        m.revolute(bearing + journal, f"{bearing}.start", f"{journal}.start")
    return m


@pytest.mark.parametrize(
    "joints",
    [(("a", "b"), ("a", "c")), (("a", "b"), ("b", "c")), (("a", "b"), ("b", "c"), ("c", "a"))],
    ids=["at a", "chain", "redundant"],
)
def test_three_links_on_one_pin(joints):
    """The pin stays where it is and every rod turns about it; each is held by m w^2 l/2 towards the pin,
    whatever pairs the joints name.
    """
    record = go(star(joints), 1e-4, duration=0.5, outputs=100)
    pull = 2.0 * 30.0**2 * 0.3
    for name in "abc":
        assert np.abs(pin(record, name, "start") - pin(record, "a", "start")[0]).max() < 1e-9
        assert np.ptp(particle(record, name)["w"]) < 3e-9
    force = {name: np.zeros((len(record.steps), 2)) for name in "abc"}
    for index, (bearing, journal) in enumerate(joints):
        reaction = np.stack([record.block("joint_fx")[:, index], record.block("joint_fy")[:, index]], axis=1)
        force[journal] += reaction
        force[bearing] -= reaction
    for name in "abc":
        theta = particle(record, name)["theta"]
        inward = -np.stack([np.cos(theta), np.sin(theta)], axis=1)
        assert force[name][1:] == pytest.approx(pull * inward[1:], rel=0, abs=2e-5 * pull)
        assert force[name][0] == pytest.approx(
            pull * inward[0], rel=0, abs=30.0 * 1e-4 / 3 * pull
        )  # at the start first order: w dt/3


def test_a_pin_with_four_links_falls_as_one():
    """Ground apart, any number of bodies on one pin: their common centre falls freely while they swing
    against each other.
    """
    m = star((("a", "b"), ("a", "c")))
    m.rigid_body("d", mass=1.0, inertia=0.01, pins={"eye": (-0.1, 0.05)}, angle=0.5)
    m.revolute("d", "c.start", "d.eye")
    m = dataclasses.replace(m, gravity=(0.0, -9.81))
    record = go(m, 1e-4, duration=0.2, outputs=50)
    t = record.steps * 1e-4
    bodies = [(name, 2.0) for name in "abc"] + [("d", 1.0)]
    y = sum(mass * particle(record, name)["y"] for name, mass in bodies) / 7.0
    speed = sum(mass * particle(record, name)["v"][0] for name, mass in bodies) / 7.0 + 9.81 * 5e-5
    assert y - y[0] == pytest.approx(speed * t - 9.81 * t**2 / 2, rel=0, abs=1e-12)
    assert max(joint_gap(record, joint) for joint in m.joints) < 1e-12
    assert np.ptp(particle(record, "d")["w"]) > 1.0


# ------------------------------------------------------------------------------------------------------- no
# ringing at the start


FORCES = ("joint_fx", "joint_fy")
INSIDE = ("frame_axial_force", "frame_moment_1", "frame_moment_2")


def ringing(mechanism: Mechanism, step: float, blocks=FORCES) -> float:
    """Largest deviation of any joint's or element's force from its smooth course over the first eighth of a
    turn, as a share of the largest.
    """
    record = go(mechanism, step, duration=TURN / 8, outputs=10000)

    def share(block: str) -> float:
        force = record.block(block)
        return np.abs(force - savgol_filter(force, 401, 5, axis=0)).max() / np.abs(force).max()

    return max(share(block) for block in blocks)


@pytest.mark.parametrize(
    ("elements", "blocks", "least"),
    [(1, FORCES, 5e-3), (2, FORCES + INSIDE, 1.2e-3), (4, FORCES + INSIDE, 1.2e-3)],
)
@pytest.mark.parametrize(
    "step", default_cases([1e-6, 2.5e-7], lambda step: step == 1e-6, "runs every mesh with two steps")
)
def test_a_consistent_start_does_not_ring(elements, blocks, least, step):
    """Elastic steel links at 50 pi rad/s: asked for is 1 % of the largest joint force; reached is a tenth of
    that, moments included.

    Left out: one element's moments, those of its ends' small rotary inertia alone, which ring by 4 % of
    themselves.
    """
    m = four_bar("", "elastic", elements=elements, section=SQUARE, speed=CRANK_SPEED)
    assert ringing(m, step, blocks) < least


def test_a_rough_start_rings():
    """What the consistent one is for: unstressed links at full speed."""
    m = four_bar("", "elastic", elements=2, section=SQUARE)
    assert ringing(dataclasses.replace(m, start=StartSettings(mode="rough")), 1e-6) > 0.2


@pytest.mark.parametrize("inertia", [2e-7, 1e-8])
def test_a_small_inertia_on_a_long_arm_sets_the_step(inertia):
    """A body whose pin lies far outside its radius of gyration needs small turns; the automatic step knows,
    and energy is kept.
    """
    m = Mechanism("arm", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.3, mass=1.0)
    m.rigid_body("far", mass=1.0, inertia=inertia, position=(1.3, 0.0), pins={"pin": (-1.0, 0.0)})
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "far.pin")
    m.drive("crank", speed=5.0)
    result = vfife.simulate(m, turns=0.2, reference=False)
    assert result.record.status == "complete" and "small inertia" in result.record.assembly.choice.culprit
    assert result.ledger.error < 1e-5
