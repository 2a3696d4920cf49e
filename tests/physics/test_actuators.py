"""Work, power and force of drivers that move a slider or a point, or turn a body against another, in closed
form; the work of weight and loads is booked apart from theirs.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import vfife
from support import go
from vfife.assembly.assemble import assemble
from vfife.kernels.arrays import Layout
from vfife.measures.energy import constant_loads, ledger
from vfife.model.drivers import Harmonic, StepTo
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import lasting_blocks
from vfife.solvers.transient import run

MASS, DAMPING, AMPLITUDE, FREQUENCY, LIFT = 1.5, 10.0, 0.03, 2.0, 0.2
OMEGA = 2.0 * math.pi * FREQUENCY
KINDS = ({"slider": "rail"}, {"point": "car.center"})


def cart(driver, gravity=(0.0, 0.0), direction=(1.0, 0.0), damping=0.0) -> Mechanism:
    """A cart on a rail, moved by a driver named "push"."""
    m = Mechanism("cart", gravity=gravity)
    m.point("O", 0.0, 0.0)
    m.point("W", -1.0, 0.0)
    m.rigid_body("car", mass=MASS, inertia=0.01)
    m.slider("rail", "ground.O", "car.center", direction=direction)
    if damping:
        m.spring("damper", "ground.W", "car.center", damping=damping)
    m.drivers["push"] = driver
    return m


@pytest.mark.parametrize("target", KINDS, ids=str)
def test_a_driver_works_against_a_damper(target) -> None:
    """Over whole periods W = c (A w)^2 t / 2; the force is m a + c v."""
    m = cart(Harmonic(**target, amplitude=AMPLITUDE, frequency=FREQUENCY), damping=DAMPING)
    result = vfife.simulate(m, duration=1.0, step=1e-4, outputs=100)
    work = 0.5 * DAMPING * (AMPLITUDE * OMEGA) ** 2
    force = AMPLITUDE * OMEGA * math.hypot(MASS * OMEGA, DAMPING)
    assert float(result.data.driver_work[-1]) == pytest.approx(work, rel=1e-6)
    assert not result.data.external_work.values.any()
    assert result.measures["push.actuator_power.mean"] == pytest.approx(work, rel=1e-6)
    assert result.measures["push.actuator_force.max"] == pytest.approx(force, rel=1e-6)
    time = result.time
    exact = DAMPING * AMPLITUDE * OMEGA * np.cos(OMEGA * time) - MASS * AMPLITUDE * OMEGA**2 * np.sin(
        OMEGA * time
    )
    measured = result.data.actuator_force.sel(actuator="push").values
    power = exact * AMPLITUDE * OMEGA * np.cos(OMEGA * time)
    # The reaction of step 0 is that of half a step, which is less exact.
    assert measured[1:] == pytest.approx(exact[1:], abs=1e-5 * force)
    assert result["push.actuator_power"].values[1:] == pytest.approx(
        power[1:], abs=1e-5 * force * AMPLITUDE * OMEGA
    )
    assert result.ledger.error < 1e-6


@pytest.mark.parametrize("target", KINDS, ids=str)
def test_weight_and_loads_are_apart_from_the_driver(target) -> None:
    """A cart is lifted by m g h against a force that grows over time with the way, which takes F h."""
    driver = StepTo(**target, direction=(0.0, 1.0), travel=LIFT, duration=0.5)
    if "slider" in target:
        driver = dataclasses.replace(driver, direction=(1.0, 0.0))
    m = cart(driver, (0.0, -9.81), (0.0, 1.0))
    m.loads["pull"] = PointForce(
        name="pull", at="car.center", force=(0.0, -4.0), times=(0.0, 1.0), factors=(1.0, 1.0)
    )
    book = ledger(go(m, 1e-4, duration=0.6, outputs=60)).terms
    supplied = (MASS * 9.81 + 4.0) * LIFT
    assert book["external"][-1] == pytest.approx(-supplied, rel=1e-6)
    assert book["driver"][-1] == pytest.approx(supplied, rel=1e-6)


def motor(duration: float = 0.4) -> Mechanism:
    """A rotor that a motor turns against another one, which a damper holds."""
    m = Mechanism("motor")
    m.point("O", 0.0, 0.0)
    for name, inertia in (("base", 0.05), ("rotor", 0.02)):
        m.rigid_body(name, mass=1.0, inertia=inertia)
    m.revolute("first", "ground.O", "base.center")
    m.revolute("second", "base.center", "rotor.center")
    m.torsional_spring("hold", "ground", "base", damping=0.3)
    m.drivers["spindle"] = StepTo(body="rotor", against="base", travel=3.0, duration=duration)
    return m


def test_a_motor_between_bodies_pays_for_the_damper() -> None:
    """The base turns back by I_r/(I_b + I_r) of the travel, then both return to rest; all work of the motor
    is in the damper and the kinetic energy.
    """
    record = go(motor(), 1e-4, duration=0.6, outputs=60)
    book = ledger(record)
    assert book.terms["driver"][-1] > 0.1 and not book.terms["external"].any()
    assert book.error < 1e-6
    torque = record.block("actuator_force")[:, 0]
    assert np.abs(torque).max() == pytest.approx(record.block("actuator_force_max").max(), rel=0.02)
    acceleration = record.block("particle_aw")[:, record.assembly.bodies["rotor"].particles[0]]
    assert torque == pytest.approx(0.02 * acceleration, abs=1e-9)


def former(assembly):
    """The assembly as versions without actuators had it."""
    topology = dataclasses.replace(assembly.topology, joint_actuator=())
    layout = Layout(topology)
    state = np.zeros(layout.rows)
    for name, rows in lasting_blocks(layout):
        state[rows] = assembly.state[assembly.layout.rows_of(name)]
    return dataclasses.replace(assembly, topology=topology, layout=layout, state=state)


def pulled_cart() -> Mechanism:
    """A driven cart that a force over time pulls."""
    m = cart(Harmonic(slider="rail", amplitude=AMPLITUDE, frequency=FREQUENCY), (0.0, -9.81), damping=1.0)
    m.loads["pull"] = PointForce(name="pull", at="car.center", force=(1.0, 2.0), times=(0, 1), factors=(1, 2))
    return m


def pendulum_on_a_cart() -> Mechanism:
    """A pendulum that strikes a stop, which is resolved by smaller steps; its cart is driven."""
    m = Mechanism("pendulum on a cart", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("car", mass=1.0, inertia=0.01)
    m.link("rod", length=0.3, mass=0.5, angle="-90 deg")
    m.slider("rail", "ground.O", "car.center")
    m.revolute("hinge", "car.center", "rod.start")
    m.torsional_spring("air", "ground", "rod", damping=0.01)
    m.stop("wall", "ground", "rod", low="-170 deg", high="-80 deg", stiffness=400.0, damping=0.5)
    m.drivers["rail"] = Harmonic(slider="rail", amplitude=AMPLITUDE, frequency=12.0 / (2.0 * math.pi))
    return m


@pytest.mark.parametrize("model", [pulled_cart, pendulum_on_a_cart])
def test_motion_has_the_bits_that_it_has_without_actuators(model) -> None:
    """Files of former versions have no actuators; there the works are those of the loads."""
    assembly = assemble(model(), 2e-4, duration=1.0, outputs=50, force_step=True)
    now, then = (run(one, loop="data-driven", companions=0) for one in (assembly, former(assembly)))
    changed = [
        name
        for name, rows in lasting_blocks(then.assembly.layout)
        if then.keeps(name) and not np.array_equal(now.block(name), then.block(name))
    ]
    assert changed == ["external_power", "external_work"]
    assert (now.last("repeated")[0] > 0.0) == (model is pendulum_on_a_cart)
    works = now.block("external_work")[:, 0] + now.block("actuator_work")[:, 0]
    assert works == pytest.approx(then.block("external_work")[:, 0], rel=1e-11, abs=1e-13)
    assert ledger(now).residual == pytest.approx(ledger(then).residual, abs=1e-11)


def test_the_weight_of_a_driven_pendulum_is_external() -> None:
    """The external work is that of the weight alone."""
    record = go(pendulum_on_a_cart(), 2e-4, duration=3.0, outputs=300)
    book = ledger(record)
    assert book.terms["external"] == pytest.approx(constant_loads(record), abs=0.0)
    assert book.terms["driver"][-1] > 0.5
    assert book.error < 1e-3
