"""Elastic beams in motion: vibration, spin-up, free flight, a rod that bends as it works."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..bodies import Section
from ..drivers import AngleTable
from ..laws import Material
from ..loads import PointForce
from ..mechanism import Mechanism
from .case import Nudge, Row, Rows, case
from .lagrange import solved
from .seen import Seen, frequency, run

EULER = "Euler-Bernoulli beam, closed form"
SPIN_UP = (
    "Simo, Vu-Quoc: On the dynamics of flexible beams under large overall motions - the plane case. J. Appl. Mech. 53 (1986) 849-863; steady stretch "
    "ρAω²L³/3EA in closed form"
)
STEEL = Material("steel", 2.1e11, 0.3, 7800.0)
BAR = Section.square(1e-4)  # 10 mm x 10 mm
ROOTS = (1.8751040687, 4.6940911330)  # cos x cosh x = -1
FREE_ROOTS = (4.7300407449, 7.8532046241)  # cos x cosh x = 1


def pulse(end: float) -> dict[str, tuple[float, ...]]:
    """Factors sin² over the time from 0 to ``end``, and none from there on; knots close enough that the spline between them does not ring."""
    share = [k / 100.0 for k in range(141)]
    factors = [math.sin(math.pi * x) ** 2 if x < 1.0 else 0.0 for x in share]
    return {"times": (*(end * x for x in share), 2.0 * end, 1e3), "factors": (*factors, 0.0, 0.0)}


def bar(elements: int, stiffness: float = 1.0, clamped: bool = False, path_unit: int = 1, via: bool = False) -> Mechanism:
    """1 m of square steel, 10 mm thick: free, or clamped at its start, with a short push across and along its end."""
    m = Mechanism("bar")
    m.point("O", 0.0, 0.0)
    material = dataclasses.replace(STEEL, youngs_modulus=STEEL.youngs_modulus * stiffness)
    m.link("bar", length=1.0, model="elastic", elements=elements, section=BAR, material=material, via=((0.5, 0.0),) if via else ())
    if clamped:
        m.weld("O", "ground.O", "bar.start")
    for name, force, end in (("across", (0.0, 2.0), 1e-3), ("along", (2000.0, 0.0), 1e-5)):
        m.loads[name] = PointForce(name=name, at="bar.end", force=force, **pulse(end))
    m.settings = dataclasses.replace(m.settings, path_unit=path_unit)
    return m


def bending(seen: Seen) -> np.ndarray:
    """Movement of the end across the chord of the rigid bar that the start and the rotation of the middle show."""
    nodes = seen.record.assembly.bodies["bar"].particles
    y = seen.record.block("particle_y")
    return np.asarray(y[:, nodes[0]] + y[:, nodes[-1]] - 2.0 * y[:, nodes[len(nodes) // 2]])


def cantilever_frequency(elements: int, mode: int = 0, **options: float) -> float:
    """Bending frequency (Hz) of the cantilever."""
    seen = run(bar(elements, clamped=True, **options), duration=2.5, outputs=5000)  # type: ignore[arg-type]
    return frequency(seen.time, seen.pin("bar", "end")[:, 1], euler(ROOTS[mode]))


def euler(root: float) -> float:
    """Bending frequency (Hz) of the bar."""
    return root**2 / (2.0 * math.pi) * math.sqrt(STEEL.youngs_modulus * BAR.second_moment / (STEEL.density * BAR.area))


@case("Vibration of a cantilever", EULER, nudges={"stiffness": 1.03}, quick=False)
def cantilever_vibration(nudge: Nudge) -> Rows:
    """First and second bending frequency with 20 elements; the first again with path units of 20 steps."""
    seen = run(bar(20, nudge("stiffness"), clamped=True), duration=2.5, outputs=5000)
    for mode, root in enumerate(ROOTS, start=1):
        yield Row(f"bending frequency {mode}", "Hz", euler(root), frequency(seen.time, seen.pin("bar", "end")[:, 1], euler(root)), 1e-2)
    again = cantilever_frequency(20, stiffness=nudge("stiffness"), path_unit=20)
    yield Row("bending frequency 1, path units of 20 steps", "Hz", euler(ROOTS[0]), again, 1e-2)


@case("Vibration of a free bar", EULER + "; axial n/2L √(E/ρ)", nudges={"stiffness": 1.03}, quick=False)
def free_bar_vibration(nudge: Nudge) -> Rows:
    """Axial and bending frequencies with 20 elements, rigid motion taken off; momentum that the pushes gave."""
    m = bar(20, nudge("stiffness"))
    short = run(m, duration=0.02, outputs=10000)
    stretch = short.pin("bar", "end")[:, 0] - short.body("bar", "x")
    wave = math.sqrt(STEEL.youngs_modulus / STEEL.density)
    for mode in (1, 2):
        yield Row(f"axial frequency {mode}", "Hz", 0.5 * mode * wave, frequency(short.time, stretch, 0.5 * mode * wave), 1e-2)
    del m.loads["along"]
    seen = run(m, duration=0.5, outputs=5000)
    yield Row("bending frequency 1", "Hz", euler(FREE_ROOTS[0]), frequency(seen.time, bending(seen), euler(FREE_ROOTS[0])), 1e-2)


@case("Convergence of a frequency in elements", "order 2 of lumped masses; " + EULER, nudges={"coarse": 8.0}, quick=False)
def convergence_in_elements(nudge: Nudge) -> Rows:
    """Order from the errors of the first bending frequency of a cantilever with 4 and 8 elements."""
    exact = euler(ROOTS[0])
    coarse, fine = (abs(cantilever_frequency(k) - exact) for k in (int(nudge("coarse", 4.0)), 8))
    yield Row("order", "1", 2.0, math.log2(coarse / fine), 0.1, 1.0)


@case("Spin-up of a flexible beam", SPIN_UP, nudges={"stiffness": 1.03}, quick=False)
def spin_up(nudge: Nudge) -> Rows:
    """Largest lag of the tip behind the turning base, its time, and the steady stretch, with 16 elements."""
    length, ea, ei, mass, inertia = 10.0, 2.8e7, 1.4e4, 1.2, 6e-4
    m = Mechanism("spin-up")
    m.point("O", 0.0, 0.0)
    section = Section(1.0, inertia / mass)
    m.link("beam", length=length, model="elastic", elements=int(nudge("elements", 16.0)), section=section, material=Material("beam", ea * nudge("stiffness"), 0.3, mass))
    m.revolute("O", "ground.O", "beam.start")
    if not math.isclose(ea * section.second_moment, ei):
        raise ValueError("the section does not give the bending stiffness of the source")
    times = np.concatenate([np.linspace(0.0, 15.0, 301), np.linspace(15.05, 31.0, 320)])
    angles = np.where(times < 15.0, 0.4 * (0.5 * times**2 + (7.5 / math.pi) ** 2 * (np.cos(2.0 * math.pi * times / 15.0) - 1.0)), 6.0 * times - 45.0)
    m.drivers["beam"] = AngleTable(body="beam", times=tuple(times.tolist()), angles=tuple(angles.tolist()))
    seen = run(m, duration=30.0, outputs=600)
    tip, angle = seen.pin("beam", "end"), seen.turn("beam", "start")
    along, across = np.cos(angle), np.sin(angle)
    lag = tip[:, 1] * along - tip[:, 0] * across
    stretch = tip[:, 0] * along + tip[:, 1] * across - length
    k = int(np.argmin(lag))
    a, b, c = np.polyfit(seen.time[k - 2 : k + 3] - seen.time[k], lag[k - 2 : k + 3], 2)
    yield Row("largest lag", "m", -0.5738, float(c - b * b / (4.0 * a)), 3e-3)
    yield Row("time of the largest lag", "s", 6.76, float(seen.time[k] - b / (2.0 * a)), 5e-3)
    steady = (seen.time > 16.0) & (seen.time < 30.0)
    yield Row("steady stretch", "m", mass * 36.0 * length**3 / (3.0 * ea), float(stretch[steady].mean()), 1e-2)


@case("Free flight of a flexible beam", SPIN_UP.partition(";")[0] + " (data); conservation after the pulse", nudges={"damping": 1e-3, "pulse": 1.02}, quick=False)
def flying_beam(nudge: Nudge) -> Rows:
    """E A = 1e4, E I = 500, ρA = 1, 10 m, thrown by a force and a moment at one end; momenta and energy afterwards, flight of the centre of mass."""
    ea, ei, length, force, moment, end = 1e4, 500.0, 10.0, 8.0, -80.0, 2.5
    m = Mechanism("flying beam")
    tilt = math.atan2(8.0, -6.0)
    section = Section(1.0, ei / ea)
    m.link("beam", length=length, model="elastic", elements=20, section=section, material=Material("beam", ea, 0.3, 1.0), angle=tilt, position=(6.0, 0.0))
    m.loads["push"] = PointForce(name="push", at="beam.start", force=(force * nudge("pulse"), 0.0), moment=moment, **pulse(end))
    m.settings = dataclasses.replace(m.settings, damping=nudge("damping", 0.0))
    seen = run(m, duration=12.0, outputs=1200)
    yield Row("x of the centre of mass at 12 s", "m", 3.0 + 0.5 * force * end / length * (12.0 - 0.5 * end), float(seen.body("beam", "x")[-1]), 1e-3)
    after = seen.time > 1.5 * end
    record = seen.record
    nodes = list(record.assembly.bodies["beam"].particles)
    mass, inertia = 1.0 / record.parameter("particle_inverse_mass")[nodes], 1.0 / record.parameter("particle_inverse_inertia")[nodes]
    at = {axis: record.block(f"particle_{axis}")[:, nodes] for axis in "xy"}
    from ..analysis.motion import velocities

    speed = {axis: values[:, nodes] for axis, values in velocities(record).items()}
    spin = ((at["x"] * speed["v"] - at["y"] * speed["u"]) * mass + speed["w"] * inertia).sum(axis=1)[after]
    push = (speed["u"] * mass).sum(axis=1)[after]
    energy = (seen.ledger.terms["kinetic"] + seen.ledger.terms["strain"])[after]
    yield Row("momentum after the pulse", "N s", 0.5 * force * end, float(push[-1]), 1e-4)
    yield Row("change of momentum", "N s", 0.0, float(np.ptp(push)), 1e-8, float(abs(push[0])))
    yield Row("change of angular momentum", "N m s", 0.0, float(np.ptp(spin)), 1e-5, float(abs(spin[0])))
    yield Row("change of energy", "J", 0.0, float(np.ptp(energy)), 1e-3, float(energy[0]))
