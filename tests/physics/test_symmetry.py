"""What no choice of coordinates, names or senses may change: momentum, bearing and journal, left and right,
forth and back.
"""

import math

import numpy as np
import pytest

from mechanisms import swing
from support import (
    CRANK_SPEED,
    EPS,
    SQUARE,
    TURN,
    TURNED_ROUND,
    bits,
    four_bar,
    go,
    joint_gap,
    largest_alpha,
    largest_force,
    mirrored,
    onsets,
    particle,
    pin,
    times,
    within,
)  # fmt: skip
from vfife.assembly.assemble import assemble
from vfife.kernels.blocks import BY_NAME
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh, Pereira
from vfife.model.mechanism import Mechanism
from vfife.solvers.transient import run


def free_chain(
    model: str = "elastic",
    *,
    exchanged: bool = False,
    friction=None,
    moment: str = "mid-overlap",
    shift=(0.0, 0.0),
    turn: float = 0.0,
) -> Mechanism:
    """Two links and a rigid body in space, joined by an ideal and a clearance joint, tumbling and colliding;
    no ground.
    """
    c, s = math.cos(turn), math.sin(turn)

    def way(x, y, w):
        return (c * x - s * y, s * x + c * y, w)

    links = {"model": model, "elements": 2, "section": SQUARE} if model == "elastic" else {"model": model}
    m = Mechanism("chain")
    m.link("a", length=0.3, mass=2.0, angle=0.2 + turn, velocity=way(3.0, 1.0, 4.0), position=shift, **links)
    m.link("b", length=0.25, mass=1.5, angle=1.0 + turn, velocity=way(2.0, -1.0, -60.0), **links)
    m.rigid_body(
        "c",
        mass=0.8,
        inertia=4e-3,
        center=(0.1, 0.02),
        pins={"eye": (0.0, 0.0)},
        angle=-0.4 + turn,
        velocity=way(2.0, -3.0, 60.0),
    )
    ends = [("a.end", "b.start"), ("b.end", "c.eye")]
    ideal, clear = (pair[::-1] if exchanged else pair for pair in ends)
    m.revolute("P", *ideal)
    m.clearance_joint(
        "Q", *clear, clearance=3e-4, bearing_radius=0.01,
        contact=LankaraniNikravesh(restitution=0.7, stiffness=6.6e9),
        friction=friction or Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2), friction_moment=moment,
    )  # fmt: skip
    return m


def masses(record) -> tuple[np.ndarray, np.ndarray]:
    """Mass and inertia of all particles but the ground."""
    inverse_mass, inverse_inertia = (
        record.parameter(f"particle_inverse_{name}")[1:] for name in ("mass", "inertia")
    )
    return 1 / inverse_mass, np.where(
        inverse_inertia > 0, 1 / np.where(inverse_inertia > 0, inverse_inertia, 1), 0
    )


# ----------------------------------------------------------------------------------------------- conservation


@pytest.mark.parametrize("model", ["rigid", "elastic"])
def test_momentum_of_a_free_mechanism(model):
    """Linear and angular momentum over 10,000 steps and a dozen impacts, to rounding; angular, as friction
    acts at one point of both.

    An ideal joint opens by 1e-11 m where steps change their size, and its reaction then has an arm so long.
    """
    record = go(free_chain(model), 2e-6, duration=0.02, outputs=200)
    assert onsets(record)[0] >= 8 and record.block("contact_friction_work")[-1, 0] > 0.1
    m, i = masses(record)
    x, y, u, v, w = (record.block(f"particle_{name}")[:, 1:] for name in ("x", "y", "u", "v", "w"))
    momentum = np.array([u @ m, v @ m])
    spin = (x * v - y * u) @ m + w @ i
    size = (np.hypot(u, v) @ m).max()
    assert np.ptp(momentum, axis=1).max() < 100 * EPS * size
    assert np.ptp(spin) < 10_000 * EPS * (np.hypot(x, y) * np.hypot(u, v) @ m).max()
    assert np.ptp(particle(record, "c")["u"]) > 1.0  # the parts do exchange momentum


def test_energy_of_a_free_mechanism():
    """What the bodies lose is what the joint's ledger says: damping and friction."""
    record = go(free_chain("rigid"), 5e-7, duration=0.02, outputs=200)
    m, i = masses(record)
    u, v, w = (record.block(f"particle_{name}")[:, 1:] for name in ("u", "v", "w"))
    kinetic = 0.5 * ((u * u + v * v) @ m + (w * w) @ i)
    flight = record.block("contact_penetration")[:, 0] < 0  # no energy in the contact
    ledger = (
        kinetic + record.block("contact_damping_work")[:, 0] + record.block("contact_friction_work")[:, 0]
    )
    lost = kinetic[0] - kinetic[flight][-1]
    assert lost > 0.05 * kinetic[0]
    assert np.abs(ledger[flight] - ledger[0]).max() < 1e-4 * kinetic[0]


def test_nothing_depends_on_where_the_origin_is_or_where_x_points():
    """The same chain elsewhere and turned by 0.7 rad: the same onsets, forces and turning, up to what
    rounding does to nine impacts.
    """
    here, there = (
        go(free_chain("rigid", shift=shift, turn=turn), 1e-6, duration=0.006, outputs=60)
        for shift, turn in (((0, 0), 0.0), ((2.0, -1.0), 0.7))
    )
    assert onsets(here) == onsets(there) and onsets(here)[0] >= 2
    for name in ("contact_normal_force", "contact_friction_force", "particle_w", "contact_penetration"):
        ours, theirs = here.block(name), there.block(name)
        assert theirs == pytest.approx(ours, rel=0, abs=1e-7 * np.abs(ours).max()), name


# -------------------------------------------------------------------------------------------------------
# bearing and journal


@pytest.mark.parametrize(
    "friction",
    [Frictionless(), Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2)],
    ids=["frictionless", "friction at the centres"],
)
@pytest.mark.parametrize("model", ["rigid", "elastic"])
def test_bearing_and_journal_exchanged_in_a_free_chain(model, friction):
    """The same motion to rounding. (With friction moments the two differ in truth: the surfaces meet at
    another place.)
    """
    records = [
        go(
            free_chain(model, exchanged=swap, friction=friction, moment="off"),
            2e-6,
            duration=0.006,
            outputs=60,
        )
        for swap in (False, True)
    ]
    same_motion(*records, 1e-9)
    assert onsets(records[0])[0] >= 2


@pytest.mark.parametrize(
    ("clear", "model"), [("BCD", "rigid"), ("C", "rigid"), ("BCD", "two-particle"), ("", "rigid")]
)
def test_bearing_and_journal_exchanged_in_a_four_bar(clear, model):
    options = {"section": SQUARE} if model != "rigid" else {}
    records = [
        go(
            four_bar(clear, model, exchanged=swap, joint={"friction_moment": "off"}, **options),
            2e-6,
            duration=TURN / 4,
            outputs=50,
        )
        for swap in (False, True)
    ]
    same_motion(*records, 1e-8)
    if clear:
        assert max(onsets(records[0])) >= 2


def same_motion(one, other, tolerance: float) -> None:
    """Places and velocities of all particles, and onsets, agree."""
    for name in ("x", "y", "theta", "u", "v", "w"):
        ours, theirs = one.block(f"particle_{name}"), other.block(f"particle_{name}")
        assert theirs == pytest.approx(ours, rel=0, abs=tolerance * np.abs(ours).max()), name
    if one.assembly.contacts:
        assert onsets(one) == onsets(other)


# --------------------------------------------------------------------------------------------- left and right


MODELS = {
    "case c": (four_bar("BCD"), 2e-6),
    "case b": (four_bar("C"), 2e-6),
    "two-particle": (four_bar("BCD", "two-particle", contact=Pereira(restitution=0.5), section=SQUARE), 2e-6),
    "elastic": (four_bar("", "elastic", elements=2, section=SQUARE), 1e-6),
    "chain": (free_chain(), 2e-6),
    "swing": (swing(Pereira(restitution=0.8)), 4e-6),
}


def sign(name: str) -> float:
    return -1.0 if name in TURNED_ROUND or name.endswith("_y") else 1.0


def mirror_faults(one, other) -> set[str]:
    """Recorded blocks that are no mirror images to the bit. Functions of time left out: a force's factor does
    not turn, a torque does.
    """
    return {
        block
        for block in BY_NAME
        if not block.startswith("function_")
        and recorded(one, block)
        and (bits(one.block(block)) != bits(sign(block) * other.block(block))).any()
    }


def recorded(record, block: str) -> bool:
    where = record.assembly.layout[block]
    return len(where) > 0 and int(where[0]) in set(record.row_numbers.tolist())


@pytest.mark.parametrize("name", MODELS)
def test_a_mirrored_start_makes_the_mirrored_motion_to_the_bit(name):
    """The step itself: every number of the start mirrored, every number of the run mirrored."""
    mechanism, step = MODELS[name]
    one = assemble(mechanism, step, duration=0.01, force_step=True)
    other = assemble(mirrored(mechanism), step, duration=0.01, force_step=True)
    for block in BY_NAME:
        rows = one.layout[block]
        if block not in ("load_fx", "load_fy", "load_m", "driven_angle", "driven_speed"):
            other.state[rows] = sign(block) * one.state[rows]
    records = run(one, loop="data-driven"), run(other, loop="data-driven")
    assert mirror_faults(*records) == set()
    assert not one.contacts or max(onsets(records[0])) >= 2


@pytest.mark.parametrize("name", MODELS)
def test_the_mirror_image_moves_mirrored_to_the_bit(name):
    """The whole way, from the model on: closing the loops included."""
    mechanism, step = MODELS[name]
    records = [go(m, step, duration=0.004) for m in (mechanism, mirrored(mechanism))]
    assert mirror_faults(*records) == set()


def test_the_four_bar_below_is_the_mirror_image_of_the_one_above():
    """Crank reversed and joint C below the line of the ground pivots: the same forces and accelerations."""
    above, below = (go(four_bar("BCD", mirrored=flipped), 1e-6, duration=0.02) for flipped in (False, True))
    window = within(above, 0.0, 0.02)
    assert onsets(above) == onsets(below)
    assert largest_alpha(below, "follower", window) == pytest.approx(
        largest_alpha(above, "follower", window), rel=1e-6
    )
    for joint in "ABCD":
        assert largest_force(below, joint, window) == pytest.approx(
            largest_force(above, joint, window), rel=1e-6
        )
    assert pin(below, "follower", "end")[-1] == pytest.approx(
        pin(above, "follower", "end")[-1] * [1, -1], abs=1e-9
    )


# --------------------------------------------------------------------------------------------- forth and back


def test_a_reversed_driver_retraces_the_way():
    """Ideal joints: the follower's angle depends on the crank's alone, so a turn backwards is the turn
    forwards read from its end.
    """
    forth, back = (go(four_bar("", speed=speed), 2e-6, turns=1) for speed in (CRANK_SPEED, -CRANK_SPEED))
    for body in ("coupler", "follower"):
        ours, theirs = particle(forth, body), particle(back, body)
        for axis in ("x", "y"):
            assert theirs[axis] == pytest.approx(ours[axis][::-1], rel=0, abs=1e-11)
        assert np.cos(theirs["theta"]) == pytest.approx(np.cos(ours["theta"][::-1]), rel=0, abs=1e-11)
    assert np.ptp(particle(forth, "follower")["theta"]) == pytest.approx(
        2 * math.pi, abs=1e-9
    )  # a drag link turns fully
    for joint in "ABCD":
        assert largest_force(back, joint, within(back, 0, TURN)) == pytest.approx(
            largest_force(forth, joint, within(forth, 0, TURN)), rel=1e-4
        )
    assert joint_gap(back, "C") < 1e-12 and times(back)[-1] == pytest.approx(TURN)
