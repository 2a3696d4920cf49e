"""Gears on a carrier that moves: Willis' formula, and moments that balance on the bodies that are there,
without the ground.
"""

import dataclasses
import math

import numpy as np
import pytest

from support import go, particle, times
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner
from vfife.kinematics.initial import ideal_motion
from vfife.measures import ledger
from vfife.model.drivers import Ramp, Torque
from vfife.model.functions import carrier_of
from vfife.model.mechanism import Mechanism
from vfife.model.validation import validate
from vfife.modelfile import dump, loads
from vfife.plots import figures
from vfife.simulation.result import Result

SUN, PLANET, RING = 24, 18, 60  # teeth
ARM = 0.105  # m
INERTIA = {"sun": 4e-3, "planet": 1e-3, "ring": 0.05, "arm": 0.02}
MASS = 0.8  # of the planet, kg


def train(
    *, sun: str = "sun", ring: str = "ring", ground: bool = True, carrier: str | None = None
) -> Mechanism:
    """Sun, planet on an arm, ring; sun or ring may be the ground, and the whole may be free in space."""
    m = Mechanism("epicyclic train")
    m.point("O", 0.0, 0.0)
    for name in ("sun", "ring", "arm"):
        if name in (sun, ring, "arm"):
            m.rigid_body(
                name, mass=1.0, inertia=INERTIA[name], pins={"planet": (ARM, 0.0)}, position=(0.0, 0.0)
            )
            if ground:
                m.revolute(name, "ground.O", f"{name}.center")
            elif name != "arm":
                m.revolute(name, "arm.center", f"{name}.center")
    m.rigid_body("planet", mass=MASS, inertia=INERTIA["planet"], position=(ARM, 0.0))
    m.revolute("planet", "arm.planet", "planet.center")
    m.gear("inner", sun, "planet", ratio=-SUN / PLANET, carrier=carrier)
    m.gear("outer", "planet", ring, ratio=PLANET / RING, carrier=carrier)
    return m


def spins(record, *names: str) -> list[np.ndarray]:
    return [particle(record, name)["w"] for name in names]


def test_speeds_are_those_of_willis():
    """(w_ring - w_arm)/(w_sun - w_arm) = - sun/ring, both driven; the planet in between."""
    m = train()
    m.drivers["sun"] = Ramp(body="sun", speed=30.0, duration=0.05)
    m.drivers["arm"] = Ramp(body="arm", speed=-7.0, duration=0.08)
    record = go(m, 2e-5, duration=0.2, outputs=20)
    sun, planet, ring, arm = (particle(record, name)["theta"] for name in ("sun", "planet", "ring", "arm"))
    assert ring - arm == pytest.approx(-SUN / RING * (sun - arm), abs=1e-9)
    assert planet - arm == pytest.approx(-SUN / PLANET * (sun - arm), abs=1e-9)
    assert abs(ring[-1]) > 1.0


def test_the_moments_balance_on_the_train():
    """On a steadily turning train the three torques from outside add up to nothing and are to each other as
    sun, ring and their sum.
    """
    m = train()
    m.drivers["sun"] = Torque(body="sun", value=1.0)
    m.drivers["ring"] = Torque(body="ring", value=RING / SUN)
    m.drivers["arm"] = Torque(body="arm", value=-1.0 - RING / SUN)
    record = go(m, 1e-4, duration=0.3, outputs=3)
    for w in spins(record, "sun", "planet", "ring", "arm"):
        assert w == pytest.approx(0.0, abs=1e-11)
    moments = record.block("joint_moment")[
        :, [record.assembly.ideals.index(name) for name in ("inner", "outer")]
    ]
    assert moments[1:] == pytest.approx(np.tile([-PLANET / SUN, -RING / SUN], (3, 1)), rel=1e-9)


def test_a_free_train_keeps_its_moment_of_momentum():
    """Floating in space, with a motor between sun and arm: the ground feels nothing, so nothing is gained in
    all.
    """
    m = train(ground=False)
    m.bodies["arm"] = dataclasses.replace(m.bodies["arm"], velocity=(0.3, -0.2, 0.0))
    for name in ("sun", "ring"):
        m.bodies[name] = dataclasses.replace(m.bodies[name], velocity=(0.3, -0.2, 0.0))
    m.bodies["planet"] = dataclasses.replace(m.bodies["planet"], velocity=(0.3, -0.2, 0.0))
    m.drivers["motor"] = Torque(body="sun", against="arm", value=0.5)
    record = go(m, 2e-5, duration=0.2, outputs=10)
    total = np.zeros(len(record.steps))
    for name in ("sun", "planet", "ring", "arm"):
        one = particle(record, name)
        mass = MASS if name == "planet" else 1.0
        total += INERTIA[name] * one["w"] + mass * (one["x"] * one["v"] - one["y"] * one["u"])
    assert np.abs(spins(record, "sun")[0][-1]) > 5.0
    assert total == pytest.approx(total[0], abs=1e-10)


@pytest.mark.system("compiles two trains of gears")
@pytest.mark.parametrize("fixed", ["sun", "ring"])
def test_a_torque_on_the_arm_meets_the_inertia_of_the_train(fixed):
    """T = (I_arm + m a^2 + I_planet i_p^2 + I_free i_f^2) alpha, with the ratios that Willis gives where one
    wheel stands still on the ground.
    """
    m = train(**{fixed: "ground"})
    m.drivers["arm"] = Torque(body="arm", value=0.7)
    record = go(m, 1e-4, duration=0.5, outputs=10)
    free = "ring" if fixed == "sun" else "sun"
    teeth = {"sun": SUN, "ring": RING}
    planet = 1.0 + SUN / PLANET if fixed == "sun" else 1.0 - RING / PLANET
    other = 1.0 + teeth[fixed] / teeth[free]
    inertia = INERTIA["arm"] + MASS * ARM**2 + INERTIA["planet"] * planet**2 + INERTIA[free] * other**2
    angle = 0.5 * 0.7 / inertia * times(record) ** 2
    assert particle(record, "arm")["theta"] == pytest.approx(angle, rel=1e-6, abs=1e-9)
    assert particle(record, free)["theta"] == pytest.approx(other * angle, rel=1e-6, abs=1e-9)
    assert ledger(record).error < 5e-8
    start = ideal_motion(m)
    assert start.of("arm")[2][2] == pytest.approx(0.7 / inertia, rel=1e-11)
    assert start.of("planet")[2][2] == pytest.approx(planet * 0.7 / inertia, rel=1e-11)
    figures(Result(record))["mechanism"].canvas.draw()


def test_a_driven_arm_feels_the_wheels():
    """A brake on the ring is held by the motors of sun and arm: T_sun = T_ring sun/ring, T_arm = - (T_ring +
    T_sun).
    """
    m = train()
    m.drivers["arm"] = Ramp(body="arm", speed=5.0, duration=0.02)
    m.drivers["sun"] = Ramp(body="sun", speed=20.0, duration=0.02)
    m.drivers["brake"] = Torque(body="ring", value=-3.0)
    record = go(m, 1e-5, duration=0.1, outputs=10)
    names = list(record.assembly.bodies)
    torque = {
        names[p - 1]: record.block("driven_torque")[-1, k]
        for k, p in enumerate(record.assembly.topology.driven)
    }
    assert torque["sun"] == pytest.approx(-3.0 * SUN / RING, rel=1e-6)
    assert torque["arm"] == pytest.approx(3.0 * (1.0 + SUN / RING), rel=1e-6)


@pytest.mark.system("compiles a train of gears in every loop")
def test_loops_agree_to_the_bit_where_a_planet_strikes():
    """A pin of the planet meets a wall: what the blow does to sun, arm and ring goes through the gears and
    their carrier.
    """
    records = []
    for loop in ("interpreted", "generated"):
        m = train()
        m.point("wall", 0.125, 0.0)
        m.external_contact(
            "blow", "ground.wall", "planet.center", journal_radius=0.0205, direction=(0.0, 1.0)
        )
        m.drivers["arm"] = Torque(body="arm", value=0.7)
        m.drivers["sun"] = Torque(body="sun", value=3.0)
        records.append(go(m, 2e-5, duration=6e-3, outputs=60, loop=loop))
    assert records[0].block("contact_normal_force").max() > 10.0
    for name in ("particle_theta", "particle_w", "joint_moment", "joint_fx", "contact_normal_force"):
        assert np.array_equal(*(record.block(name) for record in records)), name
    turned = [particle(records[0], name)["theta"] for name in ("sun", "planet", "ring", "arm")]
    assert turned[2] - turned[3] == pytest.approx(-SUN / RING * (turned[0] - turned[3]), abs=1e-10)


@pytest.mark.parametrize("pin", ["planet.center", "arm.planet"])
def test_what_a_blow_meets_is_the_whole_train(pin):
    """Velocities per unit of a force on a pin, by which damping and friction are solved, keep to Willis'
    formula and to the pins.
    """
    m = train()
    m.point("wall", 0.125, 0.0)
    m.external_contact("blow", "ground.wall", pin, journal_radius=0.0205, direction=(0.0, 1.0))
    m.bodies["arm"] = dataclasses.replace(m.bodies["arm"], angle=0.2)
    a = assemble(m, 1e-6, duration=1e-5, force_step=True)
    rows = np.concatenate([[a.layout.row("rn", k) + axis for axis in range(3)] for k in range(1, 5)])
    found = (
        Runner(a.topology, a.state[:, None], a.tables[None, :], "interpreted", rows)
        .advance(1, 2)[-1, :, 0]
        .reshape(4, 3)
    )
    met = dict(zip(m.bodies, found, strict=True))
    sun, planet, ring, arm = (met[name][2] for name in ("sun", "planet", "ring", "arm"))
    assert abs(arm) > 0.1
    assert ring - arm == pytest.approx(-SUN / RING * (sun - arm), abs=1e-9)
    assert planet - arm == pytest.approx(-SUN / PLANET * (sun - arm), abs=1e-9)
    angle = ideal_motion(m).of("arm")[0][2]
    assert met["planet"][:2] == pytest.approx(
        (-ARM * arm * math.sin(angle), ARM * arm * math.cos(angle)), abs=1e-9
    )


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        ({}, ("arm", "arm")),
        ({"sun": "ground"}, ("arm", "arm")),
        ({"ground": False}, ("arm", "arm")),
        ({"carrier": "ground"}, ("ground",) * 2),
    ],
)
def test_the_carrier_is_found_by_the_pins(options, wanted):
    m = train(**options)
    validate(m)
    assert tuple(carrier_of(m, gear) for gear in m.gears.values()) == wanted
    assert loads(dump(m)).gears == m.gears


def test_wheels_on_the_ground_and_a_planet_told_by_its_arm_are_as_they_were():
    m = Mechanism("five-bar")
    for k in range(2):
        m.point(f"P{k}", float(k), 0.0)
        m.link(f"crank{k}", length=0.3, mass=1.0)
        m.revolute(f"P{k}", f"ground.P{k}", f"crank{k}.start")
    m.gear("pair", "crank0", "crank1", ratio=-1.0)
    assert carrier_of(m, m.gears["pair"]) == "ground"
    told = train()
    told.gear("arm", "arm", "planet", ratio=2.0)
    assert carrier_of(told, told.gears["arm"]) == "ground"


def test_bad_carriers_are_refused():
    for carrier, said in (("planet", "one of the two"), ("nobody", "no body")):
        with pytest.raises(ValueError, match=said):
            validate(train(carrier=carrier))
    lone = Mechanism("lone")
    lone.point("O", 0.0, 0.0)
    lone.link("wheel", length=math.pi, mass=1.0)
    lone.revolute("O", "ground.O", "wheel.start")
    lone.gear("fixed", "ground", "wheel", ratio=2.0)
    with pytest.raises(ValueError, match="holds the body"):
        validate(lone)
