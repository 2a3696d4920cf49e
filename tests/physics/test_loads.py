"""Loads over an angle, a travel with its direction and its speed: work against closed forms, momentum, all
loops alike.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

import vfife
from support import go, particle, times
from vfife.assembly.assemble import assemble
from vfife.kernels.arrays import FUNCTION, PARTICLE
from vfife.kernels.step import travel
from vfife.measures.forces import ground_load
from vfife.model.loads import GuideForce, PointForce
from vfife.model.mechanism import Mechanism

CRANK, ROD, SPEED = 0.05, 0.2, 20.0 * math.pi
PLACES, OUT, BACK = (0.15, 0.2, 0.25), (1e5, 3e5, 1e6), (1e5, 2e5, 1e6)


def cylinder(*, direction=(1.0, 0.0), tilt: float = 0.0, **load) -> Mechanism:
    """A slider-crank whose piston compresses on its way out; drawn turned by ``tilt`` (rad)."""
    c, s = math.cos(tilt), math.sin(tilt)
    m = Mechanism("cylinder")
    m.point("O", 0.0, 0.0)
    m.link("crank", length=CRANK, mass=0.5, angle=tilt)
    m.link("rod", length=ROD, mass=0.4, angle=tilt - 0.01)
    m.rigid_body(
        "piston", mass=0.6, inertia=1e-3, position=(0.25 * c, 0.25 * s), pins={"eye": (0.0, 0.0)}, angle=tilt
    )
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "piston.eye")
    m.slider(
        "guide",
        "ground.O",
        "piston.eye",
        direction=(c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]),
    )
    m.drive("crank", speed=SPEED)
    m.loads["gas"] = GuideForce(
        name="gas",
        slider="guide",
        **{"bore": 0.05, "reverse": True, "travels": PLACES, "pressure": OUT, **load},
    )
    return m


def work(record) -> np.ndarray:
    """Work of loads (J) at the outputs; kept up to half a step later."""
    return record.block("external_work")[:, 0]


@pytest.mark.parametrize("tilt", [0.0, 2.2])
def test_work_of_a_turn_is_the_area_of_the_loop(tilt):
    """A compressor's: out against the higher curve, back with the lower; the driver gives what
    the gas takes.
    """
    area = 0.25 * math.pi * 0.05**2
    curves = [PchipInterpolator(PLACES, values) for values in (OUT, BACK)]
    loop = area * float(curves[1].integrate(0.15, 0.25) - curves[0].integrate(0.15, 0.25))
    record = go(cylinder(pressure_back=BACK, tilt=tilt), 2e-5, duration=0.2, outputs=20)
    found = work(record)
    assert np.diff(found[::20]) == pytest.approx([loop, loop], rel=2e-6)
    assert loop == pytest.approx(-11.4537, rel=1e-5)
    assert record.block("driven_work")[-1, 0] == pytest.approx(-found[-1], rel=1e-5)


def test_one_curve_gives_back_what_it_took():
    record = go(cylinder(ambient=1e5), 5e-5, duration=0.1, outputs=20)
    taken = (
        -0.25 * math.pi * 0.05**2 * (float(PchipInterpolator(PLACES, OUT).integrate(0.15, 0.25)) - 1e5 * 0.1)
    )
    found = work(record)
    assert found[10] == pytest.approx(-taken, rel=1e-3) and abs(found[20]) < 1e-5 * abs(taken)


@pytest.mark.parametrize("expressed", [True, False])
def test_adiabatic_compression_takes_its_work(expressed):
    """p V^1.4 constant, as an expression and as a table of 161 places: from dead centre to dead centre (p1 V1
    - p2 V2)/0.4.
    """
    dead, area, gamma = 0.012, 0.25 * math.pi * 0.05**2, 1.4
    places = np.linspace(0.15, 0.25, 161)
    pressure = 1e5 * ((0.1 + dead) / (0.25 - places + dead)) ** gamma
    table = {"travels": tuple(places), "pressure": tuple(pressure)}
    text = {"travels": (0.15, 0.25), "pressure": None, "expression": "1[bar]*(112[mm]/(262[mm] - x))^1.4"}
    m = cylinder(**(text if expressed else table))
    m.bodies["crank"] = dataclasses.replace(m.bodies["crank"], angle=math.pi)
    m.bodies["piston"] = dataclasses.replace(m.bodies["piston"], position=(0.15, 0.0))
    record = go(m, 5e-6, duration=0.05, outputs=10)
    closed = area * (1e5 * (0.1 + dead) - pressure[-1] * dead) / (gamma - 1.0)
    assert work(record)[-1] == pytest.approx(closed, rel=2e-7 if expressed else 1e-4)


def flywheel(**load) -> Mechanism:
    """A disc on the ground, spinning, with a force at its rim that turns with it."""
    m = Mechanism("flywheel")
    m.point("O", 0.0, 0.0)
    m.rigid_body("disc", mass=2.0, inertia=0.03, pins={"rim": (0.2, 0.0)}, velocity=(0.0, 0.0, 30.0))
    m.revolute("A", "ground.O", "disc.center")
    m.loads["push"] = PointForce(
        name="push", at="disc.rim", force=(0.0, 10.0), follow=True, crank="disc", **load
    )
    return m


@pytest.mark.parametrize("zero", [0.0, 1.1])
def test_work_over_an_angle_turns_into_speed(zero):
    """A table over a turn repeats by itself: after each turn the disc has 2 pi r F mean more energy, wherever
    the table has its 0.
    """
    angles, factors = np.radians((0.0, 60.0, 150.0, 220.0, 360.0)), (0.2, 1.0, -0.5, 0.3, 0.2)
    load = PointForce(
        name="x", at="disc.rim", crank="disc", angles=tuple(angles), factors=factors, zero_angle=zero
    )
    assert load.repeats
    around = [*(angles - 2 * math.pi)[:-1], *angles, *(angles + 2 * math.pi)[1:]]
    curve = PchipInterpolator(around, [*factors[:-1], *factors, *factors[1:]])
    record = go(
        flywheel(angles=tuple(angles), factors=factors, zero_angle=zero), 2e-5, duration=0.7, outputs=70
    )
    p = particle(record, "disc")
    force = record.block("function_value")[:, 0]
    assert force == pytest.approx(curve((p["theta"] - zero) % (2.0 * math.pi)), abs=1e-9)
    whole, turns = float(curve.integrate(0.0, 2.0 * math.pi)), np.floor((p["theta"] - zero) / (2.0 * math.pi))
    sums = [
        2.0 * (n * whole + float(curve.integrate(0.0, a - zero - 2.0 * math.pi * n)))
        for n, a in zip(turns, p["theta"], strict=True)
    ]
    gained = np.array(sums) - sums[0]
    speed = np.sqrt(30.0**2 + 2.0 * gained / 0.03)
    halfway = p["w"] - 0.5 * 2e-5 * 2.0 * force / 0.03
    assert halfway[1:] == pytest.approx(speed[1:], rel=1e-6)
    assert p["theta"][-1] > 6.0 * math.pi


def test_a_table_over_an_angle_that_does_not_go_round_keeps_its_ends():
    record = go(flywheel(angles=(0.0, 1.0), factors=(1.0, 0.0)), 1e-4, duration=0.2, outputs=20)
    p = particle(record, "disc")
    assert record.block("function_value")[:, 0] == pytest.approx(
        np.clip(1.0 - p["theta"], 0.0, 1.0), abs=1e-9
    )


def sled(**load) -> Mechanism:
    """A body on a guide that floats itself, both free in space and turned; only the load is between them."""
    m = Mechanism("sled")
    m.rigid_body("rail", mass=3.0, inertia=0.2, angle=0.4, velocity=(0.1, 0.2, 0.5), pins={"mid": (0.0, 0.0)})
    c, s = math.cos(0.4), math.sin(0.4)
    m.rigid_body(
        "block", mass=1.0, inertia=0.02, angle=1.1, position=(0.2 * c, 0.2 * s), velocity=(0.3, 0.4, 0.5)
    )
    m.slider("guide", "rail.mid", "block.center")
    m.loads["push"] = GuideForce(name="push", slider="guide", **load)
    return m


def test_a_force_along_a_guide_that_moves_is_inner():
    """It changes neither momentum nor spin of the two together; what it gives in work is theirs."""
    record = go(sled(force=(8.0, 2.0, -3.0), travels=(0.1, 0.25, 0.6)), 1e-5, duration=0.4, outputs=20)
    a, b = particle(record, "rail"), particle(record, "block")
    assert np.ptp(3.0 * a["u"] + b["u"]) < 1e-9 and np.ptp(3.0 * a["v"] + b["v"]) < 1e-9
    along = (b["x"] - a["x"]) * np.cos(a["theta"]) + (b["y"] - a["y"]) * np.sin(a["theta"])
    curve = PchipInterpolator((0.1, 0.25, 0.6), (8.0, 2.0, -3.0))
    assert record.block("function_value")[:, 0] == pytest.approx(curve(np.clip(along, 0.1, 0.6)), abs=1e-9)
    kinetic = 0.5 * sum(
        m * (p["u"] ** 2 + p["v"] ** 2) + j * p["w"] ** 2 for p, m, j in ((a, 3.0, 0.2), (b, 1.0, 0.02))
    )
    assert kinetic - kinetic[0] == pytest.approx(work(record) - work(record)[0], abs=2e-7)
    wanted = quad(lambda x: float(curve(min(max(x, 0.1), 0.6))), along[0], along[-1], points=(0.25, 0.6))[0]
    assert work(record)[-1] == pytest.approx(wanted, rel=2e-4) and np.ptp(along) > 0.1


def test_a_drag_over_speed_is_that_of_the_closed_form():
    """m dv/dt = -k v with a straight table: v = v0 exp(-k t/m), along a guide that stands askew."""
    m = Mechanism("drag")
    m.point("O", 0.1, 0.2)
    c, s = 0.6, 0.8
    m.rigid_body("block", mass=2.0, inertia=0.1, position=(0.1, 0.2), velocity=(3.0 * c, 3.0 * s, 0.0))
    m.slider("guide", "ground.O", "block.center", direction=(c, s))
    m.loads["drag"] = GuideForce(
        name="drag", slider="guide", speeds=(-4.0, 4.0), force=(20.0, -20.0), interpolation="linear"
    )
    record = go(m, 1e-4, duration=0.5, outputs=25)
    travelled = c * (particle(record, "block")["x"] - 0.1) + s * (particle(record, "block")["y"] - 0.2)
    assert travelled == pytest.approx(3.0 * 2.0 / 5.0 * (1.0 - np.exp(-5.0 * times(record) / 2.0)), abs=1e-6)


def test_a_leap_where_the_way_turns_is_an_event_and_told():
    """An oscillator with a force of 1 N against its way: each half swing is 2 F/k shorter, its turning points
    at rest.
    """
    m = Mechanism("dry")
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=1.0, inertia=0.1, position=(0.1, 0.0))
    m.slider("guide", "ground.O", "block.center")
    m.spring("s", "ground.O", "block.center", stiffness=100.0, free_length=0.0)
    m.loads["rub"] = GuideForce(
        name="rub", slider="guide", travels=(-0.2, 0.2), force=(-1.0, -1.0), force_back=(1.0, 1.0)
    )
    half = math.pi / 10.0
    record = go(m, half / 997.0, duration=4.0 * half, outputs=4)
    assert particle(record, "block")["x"] == pytest.approx([0.1, -0.08, 0.06, -0.04, 0.02], abs=4e-6)
    assert 3 <= record.block("repeated")[-1, 0] <= 6
    notes = [note for note in record.assembly.notes if "jumps where the travel reverses" in note]
    assert len(notes) == 2 and "-1 on the way out and 1 on the way back" in notes[0]
    assert "gas" not in notes[0] and "give both the same value" in notes[0].lower()
    leap = assemble(cylinder(pressure_back=tuple(2.0 * value for value in BACK)), 1e-4, duration=0.1).notes
    assert any("A gas has one pressure there" in note for note in leap)
    smooth = assemble(cylinder(pressure_back=BACK), 1e-4, duration=0.1).notes
    assert not [note for note in smooth if "jumps where" in note]


@pytest.mark.parametrize(
    ("out", "back", "reverse", "drives"),
    [
        ((5.0, 0.0), (0.0, 0.0), False, True),  # a press whose downstroke is the way back, exchanged
        ((0.0, 0.0), (5.0, 0.0), False, False),
        ((0.0, 0.0), (5.0, 0.0), True, True),
        ((1.0, 1.0), (-1.0, -1.0), False, True),  # friction of the wrong sign
        ((-1.0, -1.0), (1.0, 1.0), False, False),
        ((2.0, 1.0), (1.0, 2.0), False, False),  # not everywhere along the motion: nothing is claimed
        ((2.0, 1.0), (2.0, 1.0), False, False),
    ],
)
def test_a_force_whose_two_ways_act_along_the_motion_drives_the_machine(out, back, reverse, drives):
    load = GuideForce(
        name="work", slider="guide", travels=(0.0, 0.1), force=out, force_back=back, reverse=reverse
    )
    texts = [text for text in load.cautions() if "drives the machine" in text]
    assert bool(texts) == drives
    assert all("exchange force and force_back" in text for text in texts)
    gas = GuideForce(
        name="gas", slider="guide", bore=0.1, travels=(0.0, 0.1), pressure=out, pressure_back=back
    )
    assert not [text for text in gas.cautions() if "drives the machine" in text]  # an engine may


def test_the_rate_of_a_travel_is_its_derivative():
    """Of two bodies that move and turn freely, pins off their centres and off the guide."""
    rng, step = np.random.default_rng(7), 1e-5
    S = rng.uniform(-1.0, 1.0, 2 * PARTICLE.SIZE + FUNCTION.SIZE).tolist()
    for body in (0, PARTICLE.SIZE):
        S[body + PARTICLE.ax] = S[body + PARTICLE.ay] = S[body + PARTICLE.aw] = 0.0
    before, now, after = (travel(S, 0, PARTICLE.SIZE, 2 * PARTICLE.SIZE, dt) for dt in (-step, 0.0, step))
    assert now[1] == pytest.approx((after[0] - before[0]) / (2.0 * step), rel=1e-8)
    assert abs(now[1]) > 0.1


def test_gas_does_not_shake_the_ground():
    """It presses on piston and head alike: what the ground feels is -sum m a, with gas and without."""
    loads = [
        ground_load(go(m, 2e-5, duration=0.1, outputs=40))
        for m in (cylinder(pressure_back=BACK, tilt=0.4), cylinder(bore=1e-6, tilt=0.4))
    ]
    assert loads[0] == pytest.approx(loads[1], abs=1e-4 * np.abs(loads[1]).max())
    assert np.abs(loads[1][:, :2]).max() > 100.0


def test_expressions_over_time_angle_and_speed():
    """F = 3 sin(2t) on a free mass; a pulsating torque over an angle, which repeats; drag k v^2: each against
    its closed form.
    """
    m = Mechanism("free")
    m.rigid_body("a", mass=2.0, inertia=0.1, pins={"at": (0.0, 0.0)})
    m.force("push", "a.at", force=(3.0, 0.0), expression="sin(2*t)", times=(0.0, 2.0))
    record = go(m, 1e-4, duration=2.0, outputs=20)
    assert particle(record, "a")["x"] == pytest.approx(
        0.75 * times(record) - 0.375 * np.sin(2.0 * times(record)), abs=1e-7
    )
    record = go(flywheel(expression="0.4 + cos(angle)"), 1e-4, duration=0.6, outputs=20)
    p = particle(record, "disc")
    energy = 0.5 * 0.03 * 30.0**2 + 2.0 * (0.4 * p["theta"] + np.sin(p["theta"]))
    speed = p["w"] - 0.5 * 1e-4 * record.block("function_value")[:, 0] * 2.0 / 0.03
    assert (
        speed[1:] == pytest.approx(np.sqrt(2.0 * energy / 0.03)[1:], rel=1e-5)
        and p["theta"][-1] > 4.0 * math.pi
    )
    m = Mechanism("drag")
    m.point("O", 0.0, 0.0)
    m.rigid_body("block", mass=2.0, inertia=0.1, velocity=(3.0, 0.0, 0.0))
    m.slider("guide", "ground.O", "block.center")
    m.guide_force("drag", "guide", expression="-1.5*v*abs(v)", speeds=(-5.0, 5.0))
    record = go(m, 1e-4, duration=1.0, outputs=20)
    assert particle(record, "block")["x"] == pytest.approx(
        2.0 / 1.5 * np.log(1.0 + 1.5 * 3.0 * times(record) / 2.0), abs=1e-6
    )


def test_a_gas_is_set_from_outside():
    """By its pressure, in place of its table, beside a load that goes by the crank's angle."""
    m = cylinder(pressure_back=BACK)
    m.force("tooth", "rod.end", force=(1.0, 2.0), expression="sin(angle)")
    sim = vfife.Simulation(m, step=2e-5, force_step=True)
    assert sim.inputs == {
        "gas": "pressure of the load above ambient (Pa)",
        "tooth": "what multiplies the load (1)",
        "crank": "speed of the driver (rad/s)",
    }
    sim.set("gas", "3 bar")
    sim.set("tooth", 0.0)
    sim.advance(0.05)
    assert sim.read("external_work") == pytest.approx(3e5 * 0.25 * math.pi * 0.05**2 * 0.1, rel=1e-3), (
        "half a turn: p A s"
    )
