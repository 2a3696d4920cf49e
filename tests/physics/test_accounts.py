"""Momentum and energy where they are easily lost: stops that let go, friction outside bearings, particles
without inertia, pins called center.
"""

import math

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.laws import Coulomb, LankaraniNikravesh
from vfife.measures.energy import ledger
from vfife.measures.motion import velocities
from vfife.model.bodies import Member, Section
from vfife.model.drivers import Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import Record
from vfife.solvers.transient import run


def pendulum(angle: float = -0.5) -> Mechanism:
    m = Mechanism("pendulum", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0, angle=angle)
    m.revolute("J", "ground.O", "rod.start")
    return m


def ran(m: Mechanism, duration: float, step: float, outputs: int = 100) -> Record:
    return run(assemble(m, step, duration=duration, outputs=outputs))


def angular_momentum(record: Record) -> np.ndarray:
    """About the origin (kg m^2/s), of bodies that are all free."""
    v, x, y = velocities(record), record.block("particle_x"), record.block("particle_y")
    im, ii = record.parameter("particle_inverse_mass"), record.parameter("particle_inverse_inertia")
    free = im > 0.0
    return ((x * v["v"] - y * v["u"])[:, free]) @ (1.0 / im[free]) + v["w"][:, free] @ (1.0 / ii[free])


@pytest.mark.parametrize("damping", [0.0, 10.0, 50.0])
def test_damped_stop_loses_what_it_stored_when_it_lets_go(damping: float) -> None:
    """Its spring relaxes against its own damper; the ledger closes with the square of the step."""
    errors = []
    for step in (2e-4, 1e-4):
        m = pendulum()
        m.stop("S", "ground", "rod", low=-1.0, high=2.0, stiffness=2e3, damping=damping)
        record = ran(m, 0.6, step)
        assert record.block("spring_energy").max() > 0.1
        errors.append(ledger(record).error)
    assert errors[0] < 1e-3 and errors[1] < 0.4 * errors[0]


@pytest.mark.parametrize("moment", ["mid-overlap", "surface", "off"])
@pytest.mark.parametrize("kind", ["line", "round", "guide"])
def test_friction_outside_a_bearing_keeps_angular_momentum(kind: str, moment: str) -> None:
    """Of two bodies that nothing else holds: to rounding in mid-overlap, else but for a couple of the depth
    of contact.
    """
    m = Mechanism("pair")
    laws = {
        "friction": Coulomb(coefficient=0.3),
        "contact": LankaraniNikravesh(restitution=0.8, stiffness=1e8),
        "friction_moment": moment,
    }
    m.rigid_body(
        "a", mass=1.0, inertia=0.01, pins={"c": (0.02, 0.05)}, velocity=(0.0, 0.5, 1.0), position=(0.0, 0.0)
    )
    at = {"line": (0.03, 0.13), "round": (0.03, 0.22), "guide": (0.03, 0.02)}[kind]
    m.rigid_body(
        "b", mass=0.5, inertia=0.005, pins={"c": (-0.01, 0.03)}, velocity=(1.0, -0.5, 5.0), position=at
    )
    if kind == "guide":
        m.clearance_slider("C", "a.c", "b.c", clearance=1e-3, length=0.05, height=0.02, **laws)
    else:
        m.external_contact(
            "C", "a.c", "b.c", journal_radius=0.1, bearing_radius=0.1 if kind == "round" else None, **laws
        )
    record = ran(m, 0.03, 2e-6)
    lost, deepest = (
        record.block("contact_friction_work")[-1].sum(),
        record.block("contact_penetration_max").max(),
    )
    assert lost > 1e-4 and deepest > 1e-5
    impulse = 0.5 * 3.0  # N s, more than mass times relative velocity
    drift = np.ptp(angular_momentum(record))
    assert drift < (1e-12 if moment == "mid-overlap" else 0.3 * impulse * deepest)
    assert ledger(record).error < 1e-4


def test_particle_that_is_welded_to_a_rod_swings_with_it() -> None:
    """A particle without inertia has no angle to keep: the weld is a pin, and its mass that of a mass
    attached there.
    """
    m = pendulum()
    m.point_mass("bob", mass=1.0, position=(math.cos(-0.5), math.sin(-0.5)))
    m.weld("W", "rod.end", "bob.center")
    other = Mechanism("other", gravity=m.gravity)
    other.point("O", 0.0, 0.0)
    other.link("rod", length=1.0, mass=2.0, angle=-0.5, end_mass=1.0)
    other.revolute("J", "ground.O", "rod.start")
    one, two = (ran(each, 0.5, 1e-3).block("particle_theta")[-1, 1] for each in (m, other))
    assert two < -1.5
    assert one == pytest.approx(two, abs=1e-5)


@pytest.mark.parametrize("what", ["gear", "torsional", "torque", "moment", "stop"])
def test_what_would_turn_a_particle_without_inertia_is_refused(what: str) -> None:
    m = pendulum()
    m.point_mass("bob", mass=1.0, position=(math.cos(-0.5), math.sin(-0.5)))
    m.revolute("W", "rod.end", "bob.center")
    if what == "gear":
        m.gear("X", "rod", "bob", ratio=-1.0)
    elif what == "torsional":
        m.torsional_spring("X", "rod", "bob", stiffness=1.0)
    elif what == "stop":
        m.stop("X", "rod", "bob", low=-1.0, high=1.0, stiffness=1.0)
    elif what == "torque":
        m.drivers["X"] = Torque(body="bob", value=3.0)
    else:
        m.loads["X"] = PointForce(name="X", at="bob.center", moment=2.0)
    with pytest.raises(
        ValueError, match=r"'X' acts on the angle of 'bob', a particle without inertia.*give it an inertia"
    ):
        assemble(m)
    m.bodies["bob"] = m.bodies["bob"].__class__(
        name="bob", mass=1.0, inertia=0.1, position=m.bodies["bob"].position
    )
    assemble(m)


def test_automatic_step_resolves_what_hangs_on_a_slow_crank() -> None:
    """A turn takes 628 s, a swing one second."""
    m = pendulum()
    m.link("low", length=0.3, mass=1.0, angle=0.2)
    m.revolute("K", "rod.end", "low.start")
    m.drive("rod", speed=1e-2)
    record = run(assemble(m, duration=2.0))
    assert record.status == "complete"
    assert ledger(record).error < 1e-5


@pytest.mark.parametrize("end", ["start", "end"])
def test_weld_to_a_released_end_is_refused(end: str) -> None:
    m = Mechanism("hinge")
    m.point("O", 0.0, 0.0)
    m.link(
        "rod",
        length=1.0,
        model="elastic",
        section=Section.square(1e-4),
        release=end,
        angle=0.0 if end == "start" else math.pi,
    )
    m.weld("W", "ground.O", f"rod.{end}")
    with pytest.raises(ValueError, match=f"weld 'W' holds rod.{end}, an end that is released"):
        assemble(m)


def test_ideal_frame_keeps_a_node_called_center_where_it_is() -> None:
    m = Mechanism("frame")
    m.point("O", 0.0, 0.0)
    m.frame(
        "F",
        nodes={"center": (0.0, 0.0), "tip": (1.0, 0.0)},
        members=(Member("center", "tip", 2),),
        section=Section.square(1e-4),
    )
    m.revolute("J", "ground.O", "F.center")
    where = assemble(m.ideal()).bodies["F"]
    assert where.pins["center"] == (0.0, 0.0)
    assert where.center == pytest.approx((0.5, 0.0))
