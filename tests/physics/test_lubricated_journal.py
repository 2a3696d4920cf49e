"""The oil film of a short journal bearing: pressure integrated here, closed forms of statics and squeeze,
energy, the same bits in every loop.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad

import vfife
from support import bits, lanes
from vfife.assembly.assemble import assemble
from vfife.laws import Hydrodynamic, LankaraniNikravesh, Pair
from vfife.measures.forces import eccentricity, joint_force

VISCOSITY, RADIUS, LENGTH, CLEARANCE = 0.03, 0.02, 0.02, 1e-4
PAIR = Pair(RADIUS, CLEARANCE, LENGTH)
SCALE = VISCOSITY * (RADIUS - CLEARANCE) * LENGTH**3 / (2.0 * CLEARANCE**2)  # mu R L^3/(2 c^2)


def shaft(speed: float, force: tuple[float, float], mass: float = 0.05, **law: float) -> vfife.Mechanism:
    """A shaft that spins in a bearing at rest, under a constant force."""
    m = vfife.Mechanism("journal")
    m.point("O", 0.0, 0.0)
    m.rigid_body("shaft", mass=mass, inertia=1e-3, velocity=(0.0, 0.0, speed))
    contact = Hydrodynamic(viscosity=VISCOSITY, **law)
    m.clearance_joint(
        "J",
        "ground.O",
        "shaft.center",
        clearance=CLEARANCE,
        bearing_radius=RADIUS,
        axial_length=LENGTH,
        contact=contact,
    )
    m.loads["W"] = vfife.loads.PointForce(name="W", at="shaft.center", force=force)
    return m


def load(eps: float, speed: float) -> float:
    """W = mu U L^3/(4 c^2) eps/(1 - eps^2)^2 sqrt(pi^2 (1 - eps^2) + 16 eps^2), U = R w (Dubois and Ocvirk
    1953).
    """
    return (
        0.5
        * SCALE
        * speed
        * eps
        / (1.0 - eps**2) ** 2
        * math.sqrt(math.pi**2 * (1.0 - eps**2) + 16.0 * eps**2)
    )


@pytest.mark.parametrize("eps", [0.05, 0.4, 0.9])
@pytest.mark.parametrize("turning", [120.0, -120.0])
@pytest.mark.parametrize("closing", [0.0, 3.0, -3.0])
def test_force_is_the_integral_of_the_pressure(eps, turning, closing):
    """Reynolds' equation of the short bearing, p = 3 mu/h^3 (z^2 - L^2/4)(w dh/dtheta + 2 dh/dt), over the
    half that is run into.
    """
    first = 0.0 if turning > 0.0 else math.pi

    def line(theta):  # integral of p over z
        return (
            VISCOSITY
            * LENGTH**3
            / (2.0 * CLEARANCE**2)
            * (turning * eps * math.sin(theta) - 2.0 * closing * math.cos(theta))
            / (1.0 + eps * math.cos(theta)) ** 3
        )

    radius = RADIUS - CLEARANCE
    along, across = (
        radius * quad(lambda t, f=f: line(t) * f(t), first, first + math.pi, epsrel=1e-11)[0]
        for f in (math.cos, math.sin)
    )
    p = Hydrodynamic(viscosity=VISCOSITY).parameters(PAIR)
    sense = 1.0 if turning > 0.0 else -1.0
    for swing in (0.0, 0.3 * turning):  # turning of the line of centres: the surfaces turn so much faster
        surfaces, v_n, v_t = (
            eps * CLEARANCE * (turning + 2.0 * swing),
            closing * CLEARANCE,
            eps * CLEARANCE * swing,
        )
        radial, force, d_n, d_t, cross = Hydrodynamic.film_force((eps - 1.0) * CLEARANCE, surfaces, sense, p)
        assert radial + d_n * v_n - cross * v_t == pytest.approx(-along, rel=1e-9)
        assert force + cross * v_n - d_t * v_t == pytest.approx(across, rel=1e-9)
        assert cross**2 < d_n * d_t


@pytest.mark.parametrize(("eps", "speed"), [(0.3, 100.0), (0.7, 100.0), (0.7, -100.0), (0.9, 300.0)])
def test_settles_where_the_closed_form_says(eps, speed):
    """Eccentricity and attitude angle under a constant load: tan phi = pi sqrt(1 - eps^2)/(4 eps), to the
    side that turning drags it.
    """
    result = vfife.simulate(shaft(speed, (0.0, -load(eps, abs(speed)))), duration=0.3, step=2e-6, outputs=100)
    x, y = eccentricity(result.record)[-1, 0]
    assert math.hypot(x, y) / CLEARANCE == pytest.approx(eps, rel=3e-4)
    assert math.atan2(x, -y) == pytest.approx(
        math.copysign(math.atan(math.pi * math.sqrt(1.0 - eps**2) / (4.0 * eps)), speed), abs=2e-4
    )
    assert joint_force(result.record)[-1, 0] == pytest.approx(
        [0.0, load(eps, abs(speed))], abs=1e-3 * load(eps, abs(speed))
    )
    assert result.measures["J.impacts"] == 0.0
    sommerfeld = (
        VISCOSITY
        * abs(speed)
        / (2.0 * math.pi)
        * 2.0
        * RADIUS
        * LENGTH
        / load(eps, abs(speed))
        * (RADIUS / CLEARANCE) ** 2
    )
    ocvirk = (
        (1.0 - eps**2) ** 2
        / (math.pi * eps * math.sqrt(math.pi**2 * (1.0 - eps**2) + 16.0 * eps**2))
        * (2.0 * RADIUS / LENGTH) ** 2
    )
    assert sommerfeld == pytest.approx(ocvirk, rel=0.01)  # R for R_J: half a per cent
    assert result.ledger.error < 1e-3


def test_a_load_squeezes_the_film_in_the_time_of_the_closed_form():
    """Without turning W = A pi (1 + 2 eps^2)/(1 - eps^2)^(5/2) eps', so t = A pi/W integral; a light shaft,
    0.1 to 0.8 of the clearance.
    """
    force = 200.0
    result = vfife.simulate(shaft(0.0, (force, 0.0), mass=1e-3), duration=0.06, step=1e-6, outputs=6000)
    eps = eccentricity(result.record)[:, 0, 0] / CLEARANCE
    times = np.interp([0.1, 0.8], eps, result.time)
    passed = SCALE * math.pi / force * quad(lambda e: (1.0 + 2.0 * e * e) / (1.0 - e * e) ** 2.5, 0.1, 0.8)[0]
    assert times[1] - times[0] == pytest.approx(passed, rel=1e-3)
    lost, work = result.ledger.terms["contact_loss"][-1], force * eps[-1] * CLEARANCE
    assert lost == pytest.approx(work, rel=1e-3) and result.ledger.error < 5e-4


def test_dry_contact_takes_over_where_the_film_is_thin():
    """Without turning a load comes to rest on Hertz' elastic force at last: the film is gone from one film
    thickness of penetration on.
    """
    stiffness, force = 1e10, 500.0
    model = shaft(0.0, (force, 0.0), film_thickness=2e-6, stiffness=stiffness)
    result = vfife.simulate(model, duration=1.0, step=2e-6, outputs=50)
    assert eccentricity(result.record)[-1, 0, 0] - CLEARANCE == pytest.approx(
        (force / stiffness) ** (2.0 / 3.0), rel=1e-3
    )
    assert result.ledger.error < 1e-3
    p = Hydrodynamic(viscosity=VISCOSITY, film_thickness=2e-6).parameters(PAIR)
    fading = [
        Hydrodynamic.film_force(share * 2e-6, 1e-3, 1.0, p)[2]
        for share in (-1.0, -0.5, 0.0, 0.25, 0.5, 1.0, 1.5)
    ]
    assert np.array(fading) / fading[0] == pytest.approx([1.0, 1.0, 1.0, 0.75, 0.5, 0.0, 0.0])


def driven() -> vfife.Mechanism:
    """A four-bar with a film in one joint of two rigid links and dry contact in the next: shared bodies,
    arms, ideal joints.
    """
    from support import four_bar

    m = four_bar("BC", clearance=1e-4, speed=40.0)
    contact = Hydrodynamic(viscosity=0.3, stiffness=6.6e10)
    m.joints["C"] = dataclasses.replace(m.clearances["C"], contact=contact, axial_length=0.02)
    return m


@pytest.mark.system("compiles a film in every loop")
def test_every_loop_gives_the_same_bits():
    model = assemble(driven(), 2e-6, duration=1e-2, force_step=True)
    rows = {
        loop: bits(lanes([model], loop).advance(200, 5))
        for loop in ("interpreted", "data-driven", "generated")
    }
    assert (rows["interpreted"] == rows["data-driven"]).all() and (
        rows["generated"] == rows["data-driven"]
    ).all()


def test_the_ledger_closes_in_a_mechanism():
    """Shaft work fed into the film, damping and dry contact are all counted; halving the step halves what is
    left open, at least.
    """
    alone = {"companions": 0, "reference": False, "loop": "data-driven"}
    open_ = [vfife.simulate(driven(), turns=0.5, step=step, **alone).ledger.error for step in (2e-6, 1e-6)]
    assert open_[1] < 1e-3 and open_[1] < 0.7 * open_[0]


def test_a_dry_joint_costs_nothing():
    """The generated step of a model without films does not mention one."""
    from vfife.compiler.trace.straight_line import trace

    m = driven()
    counts = []
    for contact in (LankaraniNikravesh(stiffness=6.6e10), m.clearances["C"].contact):
        m.joints["C"] = dataclasses.replace(m.clearances["C"], contact=contact)
        counts.append(len(trace(assemble(m, 2e-6, duration=1e-2, force_step=True).topology).operations))
    assert counts[1] > counts[0] + 30


def one_step(depth: float, friction: vfife.laws.Coulomb | vfife.laws.Frictionless) -> dict[str, float]:
    """Penetration and forces in the first step of a shaft at a depth (m) that moves by 0.1 m/s on and 0.3 m/s
    across.
    """
    m = shaft(50.0, (0.0, 0.0), film_thickness=2e-6, stiffness=1e10)
    m.bodies["shaft"] = dataclasses.replace(m.bodies["shaft"], velocity=(0.1, 0.3, 50.0))
    m.joints["J"] = dataclasses.replace(m.joints["J"], friction=friction)
    model = assemble(m, 1e-8, duration=1e-3, force_step=True)
    model.state[model.layout["particle_x"][1]] = CLEARANCE + depth
    runner = lanes([model], "interpreted")
    runner.advance(1, 1)
    names = ("penetration", "normal_force", "friction_force")
    return {name: float(runner.states[model.layout[f"contact_{name}"][0], 0]) for name in names}


def test_surfaces_rub_with_their_dry_force_alone():
    """Coulomb friction is mu K d^1.5, whatever damping adds to the normal force; nothing while the surfaces
    are apart.
    """
    for depth in (1e-6, 5e-6):
        dry, film = (
            one_step(depth, vfife.laws.Coulomb(coefficient=0.2)),
            one_step(depth, vfife.laws.Frictionless()),
        )
        elastic = 1e10 * dry["penetration"] ** 1.5
        assert dry["normal_force"] > 1.1 * elastic > 0.0
        assert abs(dry["friction_force"] - film["friction_force"]) == pytest.approx(0.2 * elastic, rel=1e-3)
    assert one_step(-5e-6, vfife.laws.Coulomb(coefficient=0.2)) == one_step(-5e-6, vfife.laws.Frictionless())
