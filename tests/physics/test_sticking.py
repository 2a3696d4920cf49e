"""Set-valued friction in the loop: what sticks stays to rounding from the first step on, what slides follows
the printed law and stops.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vfife
from support import particle, times, went, with_settings
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.laws import Coulomb, FrictionLaw, Karnopp, LankaraniNikravesh, Stribeck
from vfife.measures import ledger
from vfife.model.drivers import ConstantSpeed, Torque
from vfife.model.mechanism import Mechanism
from vfife.solvers.record import Record

G, CLEARANCE, RADIUS, STIFFNESS, STEP, BITE = 9.81, 3e-4, 0.01, 1e9, 5e-6, 1e-5
CONTACT = LankaraniNikravesh(restitution=0.5, stiffness=STIFFNESS)
STICKING = [
    Coulomb(coefficient=0.3),
    Karnopp(coefficient=0.2, static_coefficient=0.3, band=1e-4),
    Karnopp(coefficient=0.2, static_coefficient=0.3, band=1e-9),
    Stribeck(coefficient=0.2, static_coefficient=0.3),
]
each_law = pytest.mark.parametrize("law", STICKING, ids=lambda law: law.name)


def depth_under(force: float) -> float:
    """Penetration (m) at rest."""
    return (force / STIFFNESS) ** (2 / 3)


def placed(
    mechanism: Mechanism,
    places: dict[str, tuple[float, float, float]],
    steps: int,
    outputs: int = 20,
    step: float = STEP,
) -> Assembly:
    """Assembled, then bodies put where they shall start: an assembly alone would close the joints."""
    a = assemble(mechanism, step, duration=steps * step, outputs=outputs, force_step=True)
    for name, place in places.items():
        for axis, value in zip(("x", "y", "theta"), place, strict=True):
            a.state[a.layout.row(f"particle_{axis}", a.bodies[name].particles[0])] = value
    return a


def disc_on_a_slope(law: FrictionLaw, tangent: float, steps: int, damping: float = 0.0) -> Assembly:
    """A disc in its bearing, turned by the torque that holds it where the wall has this slope: a block on an
    incline, bent round.
    """
    angle = math.atan(tangent)
    normal = G * math.cos(angle)
    depth = depth_under(normal)
    m = Mechanism("disc on a slope", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.rigid_body("disc", mass=1.0, inertia=5e-5, pins={"eye": (0.0, 0.0)}, position=(0.0, 0.0))
    m.clearance_joint(
        "J", "ground.O", "disc.eye", clearance=CLEARANCE, bearing_radius=RADIUS, contact=CONTACT, friction=law
    )
    torque = -G * math.sin(angle) * (RADIUS - CLEARANCE - depth / 2)
    m.drivers["disc"] = Torque(body="disc", value=torque)
    away = CLEARANCE + depth
    at = (away * math.sin(angle), -away * math.cos(angle), 0.0)
    return placed(with_settings(m, damping=damping), {"disc": at}, steps)


def hanging(law: FrictionLaw, share: float, steps: int, lower: bool, turn: float = -math.pi / 2) -> Assembly:
    """A pendulum that a dry, loose pin holds askew, alone or with a link hung from its end in an ideal joint,
    in exact balance.

    ``turn`` is the angle of both bodies where they hang straight down.
    """
    mass, length, end, second = 1.0, 0.05, 0.1, 0.7 if lower else 0.0
    whole = mass + second
    angle = math.atan(share * 0.3)
    depth = depth_under(whole * G * math.cos(angle))
    away, arm = CLEARANCE + depth, RADIUS - CLEARANCE - depth / 2
    lean = math.asin(arm * math.sin(angle) * whole / (mass * length + second * end))
    down = np.array([math.cos(-math.pi / 2 - turn), math.sin(-math.pi / 2 - turn)])  # in the bodies' frames
    m = Mechanism("hanging", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    points = {"eye": (0.0, 0.0), "end": tuple(end * down)}
    m.rigid_body("rod", mass=mass, inertia=2e-3, center=tuple(length * down), pins=points, angle=lean + turn)
    m.clearance_joint(
        "J", "ground.O", "rod.eye", clearance=CLEARANCE, bearing_radius=RADIUS, contact=CONTACT, friction=law
    )
    eye = np.array([away * math.sin(angle), -away * math.cos(angle)])
    along = np.array([math.sin(lean), -math.cos(lean)])
    places = {"rod": (*(eye + length * along), lean + turn)}
    if lower:
        m.rigid_body(
            "low", mass=second, inertia=1e-3, center=tuple(0.04 * down), pins={"eye": (0.0, 0.0)}, angle=turn
        )
        m.revolute("P", "rod.end", "low.eye")
        places["low"] = (*(eye + end * along + (0.0, -0.04)), turn)
    return placed(m, places, steps)


def moved(record: Record, *names: str) -> tuple[float, float]:
    """How far bodies have gone (m or rad) and how fast they are at most (m/s or rad/s)."""
    p = [particle(record, name) for name in names]
    way = max(float(np.abs(q[axis] - q[axis][0]).max()) for q in p for axis in ("x", "y", "theta"))
    return way, max(float(np.abs(q[axis]).max()) for q in p for axis in "uvw")


@each_law
@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_disc_stays_below_the_friction_angle(law, damping):
    """To rounding for 2e5 steps: what is left is the rolling of a disc whose start is balanced to 1e-16."""
    way, speed = moved(went(disc_on_a_slope(law, 0.29, 200_000, damping)), "disc")
    assert way < 1e-14 and speed < 1e-11


@pytest.mark.soak
def test_disc_stays_for_ten_million_steps():
    for law in STICKING:
        way, speed = moved(went(disc_on_a_slope(law, 0.299, 10_000_000), "generated"), "disc")
        assert way < 1e-13 and speed < 1e-10


@each_law
def test_pendulum_stops_askew(law):
    """Arms couple normal and friction force: balanced within the friction cone, it stays."""
    way, speed = moved(went(hanging(law, 0.9, 100_000, False)), "rod")
    assert way < 1e-12 and speed < 1e-10


@each_law
def test_pendulum_stops_askew_with_a_link_hung_from_it(law):
    """What hangs along in an ideal joint shakes by the rounding of the joint, and turns by less than an
    angle's last digit are lost.

    So it creeps, steadily, by less than half a unit in the last place of its angle a step.
    """
    steps = 100_000
    way, speed = moved(went(hanging(law, 0.9, steps, True)), "rod", "low")
    assert way < 0.5 * np.spacing(math.pi / 2) * steps and speed < 1e-10


@pytest.mark.soak
def test_what_creeps_is_the_last_digit_of_the_angle():
    """The same two bodies in frames that make their angles small do not drift in 3e6 steps: they wander."""
    way, speed = moved(
        went(hanging(Coulomb(coefficient=0.3), 0.9, 3_000_000, True, turn=0.0), "generated"), "rod", "low"
    )
    assert way < 2e-11 and speed < 2e-10


def test_pendulum_falls_outside_the_friction_cone():
    """The same balance beyond the cone does not hold."""
    way, _ = moved(went(hanging(Coulomb(coefficient=0.3), 1.1, 20_000, False)), "rod")
    assert way > 1e-5


def test_disc_slides_above_the_friction_angle():
    """The disc spins up in its bearing: its motion and the wall's normal force from SciPy, with friction mu N
    throughout.
    """
    tangent, mu, steps = 0.5, 0.3, 4000
    record = went(disc_on_a_slope(Coulomb(coefficient=mu), tangent, steps))
    p, angle = particle(record, "disc"), math.atan(tangent)
    torque = -G * math.sin(angle) * (RADIUS - CLEARANCE - depth_under(G * math.cos(angle)) / 2)
    chi = 0.75 * (1 - 0.5**2)

    def motion(t, y):
        e = math.hypot(y[0], y[1])
        n, depth = np.array(y[:2]) / e, e - CLEARANCE
        rate = n @ y[3:5]
        normal = max(STIFFNESS * max(depth, 0.0) ** 1.5 * (1 + chi * rate / 1e-3), 0.0)
        rub = (
            mu * normal
        )  # the torque turns it clockwise: the surface slides backwards, friction pushes along t
        force = -normal * n + rub * np.array([-n[1], n[0]]) + (0.0, -G)
        return [*y[3:], *force, (torque + rub * (RADIUS - CLEARANCE - depth / 2)) / 5e-5]

    start = [p["x"][0], p["y"][0], 0.0, 0.0, 0.0, 0.0]
    end = times(record)[-1] + 0.5 * STEP
    solved = solve_ivp(motion, (0, end), start, method="Radau", rtol=1e-9, atol=1e-14).y[:, -1]
    assert p["w"][-1] == pytest.approx(solved[5], rel=1e-4)
    assert abs(solved[5]) > 1.0


def brake(
    law: FrictionLaw, spin: float, torque: float, steps: int, damping: float = 0.0
) -> tuple[Assembly, float, float]:
    """A disc on an ideal axle off the middle of its bearing: a constant normal force (N), hence a brake; with
    it the arm (m).
    """
    m = Mechanism("brake")
    m.point("O", 0.0, 0.0)
    m.rigid_body("disc", mass=1.0, inertia=2e-4, pins={"eye": (0.0, 0.0)}, velocity=(0.0, 0.0, spin))
    m.revolute("axle", "ground.O", "disc.eye")
    m.clearance_joint(
        "J", "ground.O", "disc.eye", clearance=CLEARANCE, bearing_radius=RADIUS, contact=CONTACT, friction=law
    )
    if torque:
        m.drivers["disc"] = Torque(body="disc", value=torque)
    a = pressed(with_settings(m, damping=damping), steps)
    return a, STIFFNESS * BITE**1.5, RADIUS - CLEARANCE - BITE / 2


def pressed(m: Mechanism, steps: int, outputs: int = 20, step: float = STEP) -> Assembly:
    """The brake's axle put so far off the middle that the disc overlaps its bearing by BITE."""
    a = placed(m, {"disc": (0.0, -CLEARANCE - BITE, 0.0)}, steps, outputs, step)
    a.state[a.layout.row("joint_bearing_y", 0)] = -CLEARANCE - BITE
    return a


@pytest.mark.parametrize(
    "law",
    [Coulomb(coefficient=0.3), Karnopp(coefficient=0.3, static_coefficient=0.3, band=0.0)],
    ids=lambda law: law.name,
)
def test_brake_stops_where_it_must_and_rests(law):
    """Half of I w^2 over the friction moment is the angle of stopping; then the disc stands still, exactly;
    all energy is friction's.
    """
    assembly, normal, arm = brake(law, 20.0, 0.0, 20_000)
    record = went(assembly)
    p = particle(record, "disc")
    assert p["theta"][-1] == pytest.approx(0.5 * 2e-4 * 20.0**2 / (0.3 * normal * arm), abs=STEP * 0.5)
    assert abs(p["w"][-1]) < 1e-17
    assert p["theta"][-1] == p["theta"][-5]
    assert record.block("contact_friction_work")[-1, 0] == pytest.approx(0.5 * 2e-4 * 20.0**2, rel=1e-8)
    assert ledger(record).error < 1e-8


@each_law
def test_brake_holds_a_torque_up_to_its_limit(law):
    _, normal, arm = brake(law, 0.0, 0.0, 10)
    for damping in (0.0, 5.0):
        held = went(brake(law, 0.0, 0.999 * 0.3 * normal * arm, 50_000, damping)[0])
        assert moved(held, "disc")[0] < 1e-15
        assert abs(held.block("contact_friction_work")[-1, 0]) < 1e-25
    free = went(brake(law, 0.0, 1.001 * 0.3 * normal * arm, 50_000)[0])
    assert moved(free, "disc")[0] > 1e-6


def test_friction_of_a_run_that_stops_and_slides_is_in_the_ledger():
    """A torque to and fro, now below and now above the limit: the ledger closes to second order and friction
    never gives energy back.
    """
    errors = []
    for step in (1e-5, 5e-6):
        assembly, normal, arm = brake(Coulomb(coefficient=0.3), 0.0, 0.0, 10)
        m = assembly.mechanism
        limit = 0.3 * normal * arm
        torque = tuple(1.5 * limit * math.sin(2 * math.pi * k / 20) for k in range(41))
        m.drivers["disc"] = Torque(body="disc", value=torque, times=tuple(0.01 * k for k in range(41)))
        record = went(pressed(m, round(0.4 / step), 400, step))
        work = record.block("contact_friction_work")[:, 0]
        assert work[-1] > 1e-3 and np.diff(work).min() > -1e-9 * work[-1]
        errors.append(ledger(record).error)
        w = particle(record, "disc")["w"]
        assert (np.abs(w) < 1e-15).sum() > 50 and np.abs(w).max() > 0.1
    assert errors[1] < 1e-5


def block_on_a_line(law: FrictionLaw, tangent: float, steps: int) -> tuple[Assembly, float]:
    """A block on two round feet on an inclined line, at rest, and the angle of the line.

    The feet touch at the height of its centre of mass, so that both press alike whatever rubs.
    """
    angle, foot = math.atan(tangent), 0.01
    depth = depth_under(0.5 * G * math.cos(angle))
    m = Mechanism("block", gravity=(0.0, -G))
    m.point("P", 0.2, 0.1)
    feet = {"left": (-0.05, foot - depth / 2), "right": (0.05, foot - depth / 2)}
    up, along = np.array([-math.sin(angle), math.cos(angle)]), (math.cos(angle), math.sin(angle))
    at = np.array([0.2, 0.1]) - depth / 2 * up
    m.rigid_body("block", mass=1.0, inertia=2e-3, pins=feet, position=tuple(at), angle=angle)
    for name in feet:
        m.external_contact(
            name,
            "ground.P",
            f"block.{name}",
            journal_radius=foot,
            direction=along,
            contact=CONTACT,
            friction=law,
        )
    return placed(m, {"block": (*at, angle)}, steps), angle


@each_law
def test_block_stays_on_an_incline(law):
    """Below the friction angle, on two feet of which either could hold it: to rounding."""
    assembly, _ = block_on_a_line(law, 0.29, 200_000)
    record = went(assembly)
    way, speed = moved(record, "block")
    assert way < 1e-13 and speed < 1e-10
    assert abs(record.block("contact_friction_force")[-1].sum()) == pytest.approx(
        G * math.sin(math.atan(0.29)), rel=1e-9
    )


def test_block_slides_down_an_incline():
    """Above the friction angle: g (sin a - mu cos a) down the line, and not off it."""
    assembly, angle = block_on_a_line(Coulomb(coefficient=0.3), 0.5, 20_000)
    record = went(assembly)
    p, time = particle(record, "block"), times(record)
    down = -(p["u"] * math.cos(angle) + p["v"] * math.sin(angle))
    expected = G * (math.sin(angle) - 0.3 * math.cos(angle))
    assert down[1:] == pytest.approx(expected * (time[1:] + 0.5 * STEP), rel=1e-6)
    assert np.abs(p["theta"] - angle).max() < 1e-9
    assert np.abs(record.block("contact_friction_force")[1:]) == pytest.approx(
        0.3 * record.block("contact_normal_force")[1:], rel=1e-12
    )


@pytest.mark.parametrize("law", ["coulomb", "karnopp", "stribeck"])
def test_a_pin_on_a_driven_carriage_rubs_as_far_as_that_goes(law):
    """Nothing gives way along the plate, which rounding may take below nothing: work is mu N times the way,
    and the drive gives it.
    """
    press, speed, friction, end = 200.0, 0.5, 0.3, 0.02
    m = Mechanism("pin on a plate", gravity=(0.0, 0.0))
    m.point("O", 0.0, 0.0)
    m.point("rail", 0.0, 0.05)
    m.rigid_body("carriage", mass=1.0, inertia=1e-3, position=(0.0, 0.05), pins={"p": (0.0, 0.0)})
    m.rigid_body(
        "pin", mass=0.2, inertia=1e-5, position=(0.0, 0.03), pins={"tip": (0.0, -0.025), "top": (0.0, 0.02)}
    )
    m.slider("rail", "ground.rail", "carriage.p")
    m.slider("sleeve", "carriage.p", "pin.top", direction=(0.0, 1.0))
    m.force("press", "pin.tip", force=(0.0, -press))
    dry = {
        "law": law,
        "coefficient": friction,
        **({} if law == "coulomb" else {"static_coefficient": friction}),
    }
    m.external_contact(
        "plate",
        "ground.O",
        "pin.tip",
        journal_radius=0.005,
        friction=dry,
        contact={"law": "lankarani-nikravesh", "restitution": 0.1},
    )
    m.drivers["drive"] = ConstantSpeed(slider="rail", speed=speed)
    found = vfife.simulate(m, duration=end, companions=0, reference=False, loop="data-driven")
    assert found.record.status == "complete"
    lost = found.channels["friction_energy"].values[:, 0]
    late = found.time > 0.5 * end  # the pin has come to rest on the plate
    slope = np.polyfit(found.time[late], lost[late], 1)[0]
    assert slope == pytest.approx(friction * press * speed, rel=1e-3)
