"""Elastic beams: natural frequencies, vibration, spin-up, free flight, a rod that bends as it works."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from vfife.laws import Material
from vfife.measures.modes import modes
from vfife.measures.motion import velocities
from vfife.measures.values import Measured
from vfife.model.bodies import Section
from vfife.model.drivers import AngleTable
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism

from .case import Nudge, Row, Rows, verified
from .case_motion import CaseMotion, frequency, run

EULER = "Euler-Bernoulli beam, closed form"
SPIN_UP = (
    "Simo, Vu-Quoc: On the dynamics of flexible beams under large overall motions - the plane case. J. Appl."
    " Mech. 53 (1986) 849-863; steady stretch ρAω²L³/3EA in closed form"
)
STEEL = Material("steel", 2.1e11, 0.3, 7800.0)
BAR = Section.square(1e-4)  # 10 mm x 10 mm
ROOTS = (1.8751040687, 4.6940911330)  # cos x cosh x = -1
FREE_ROOTS = (4.7300407449, 7.8532046241)  # cos x cosh x = 1


def pulse(end: float) -> dict[str, Any]:
    """Factors sin² over the time from 0 to ``end``, and none from there on; knots close enough that the
    spline between them does not ring.
    """
    share = [k / 100.0 for k in range(141)]
    factors = [math.sin(math.pi * x) ** 2 if x < 1.0 else 0.0 for x in share]
    return {
        "times": (*(end * x for x in share), 2.0 * end, 1e3),
        "factors": (*factors, 0.0, 0.0),
        "interpolation": "spline",
    }


def bar(
    elements: int, stiffness: float = 1.0, clamped: bool = False, path_unit: int = 1, via: bool = False
) -> Mechanism:
    """1 m of square steel, 10 mm thick: free, or clamped at its start, with a short push across and along its
    end.
    """
    m = Mechanism("bar")
    m.point("O", 0.0, 0.0)
    material = dataclasses.replace(STEEL, youngs_modulus=STEEL.youngs_modulus * stiffness)
    m.link(
        "bar",
        length=1.0,
        model="elastic",
        elements=elements,
        section=BAR,
        material=material,
        via=((0.5, 0.0),) if via else (),
    )
    if clamped:
        m.weld("O", "ground.O", "bar.start")
    for name, force, end in (("across", (0.0, 2.0), 1e-3), ("along", (2000.0, 0.0), 1e-5)):
        m.loads[name] = PointForce(name=name, at="bar.end", force=force, **pulse(end))
    m.settings = dataclasses.replace(m.settings, path_unit=path_unit)
    return m


def bending(motion: CaseMotion) -> np.ndarray:
    """Movement of the end across the chord of the rigid bar that the start and the rotation of the middle
    show.
    """
    nodes = motion.record.assembly.bodies["bar"].particles
    y = motion.record.block("particle_y")
    return np.asarray(y[:, nodes[0]] + y[:, nodes[-1]] - 2.0 * y[:, nodes[len(nodes) // 2]])


def cantilever_frequency(elements: int, mode: int = 0, **options: float) -> float:
    """Bending frequency (Hz) of the cantilever."""
    motion = run(bar(elements, clamped=True, **options), duration=2.5, outputs=5000)  # type: ignore[arg-type]
    return frequency(motion.time, motion.pin("bar", "end")[:, 1], euler(ROOTS[mode]))


def euler(root: float) -> float:
    """Bending frequency (Hz) of the bar."""
    return (
        root**2
        / (2.0 * math.pi)
        * math.sqrt(STEEL.youngs_modulus * BAR.second_moment / (STEEL.density * BAR.area))
    )


@verified("Vibration of a cantilever", EULER, nudges={"stiffness": 1.03}, quick=False)
def cantilever_vibration(nudge: Nudge) -> Rows:
    """First and second bending frequency with 20 elements; the first again with path units of 20 steps."""
    motion = run(bar(20, nudge("stiffness"), clamped=True), duration=2.5, outputs=5000)
    for mode, root in enumerate(ROOTS, start=1):
        yield Row(
            f"bending frequency {mode}",
            "Hz",
            euler(root),
            frequency(motion.time, motion.pin("bar", "end")[:, 1], euler(root)),
            1e-2,
        )
    refined = cantilever_frequency(20, stiffness=nudge("stiffness"), path_unit=20)
    yield Row("bending frequency 1, path units of 20 steps", "Hz", euler(ROOTS[0]), refined, 1e-2)


@verified("Vibration of a free bar", EULER + "; axial n/2L √(E/ρ)", nudges={"stiffness": 1.03}, quick=False)
def free_bar_vibration(nudge: Nudge) -> Rows:
    """Axial frequencies with 20 elements, the first bending frequency with 40, rigid motion taken off."""
    m = bar(20, nudge("stiffness"))
    short = run(m, duration=0.02, outputs=10000)
    stretch = short.pin("bar", "end")[:, 0] - short.body("bar", "x")
    wave = math.sqrt(STEEL.youngs_modulus / STEEL.density)
    for mode in (1, 2):
        yield Row(
            f"axial frequency {mode}",
            "Hz",
            0.5 * mode * wave,
            frequency(short.time, stretch, 0.5 * mode * wave),
            1e-2,
        )
    m = bar(40, nudge("stiffness"))
    del m.loads["along"]
    motion = run(m, duration=0.5, outputs=5000)
    yield Row(
        "bending frequency 1",
        "Hz",
        euler(FREE_ROOTS[0]),
        frequency(motion.time, bending(motion), euler(FREE_ROOTS[0])),
        5e-3,
    )


@verified(
    "Convergence of a frequency in elements",
    "order 2 of lumped masses; " + EULER,
    nudges={"coarse": 9.0},
    quick=False,
)
def convergence_in_elements(nudge: Nudge) -> Rows:
    """Order from the errors of the first bending frequency of a cantilever with 8 and 16 elements."""
    exact = euler(ROOTS[0])
    coarse, fine = (abs(cantilever_frequency(k) - exact) for k in (int(nudge("coarse", 8.0)), 16))
    yield Row("order", "1", 2.0, math.log2(coarse / fine), 1e-2)


@verified(
    "Natural frequencies and their ranges",
    EULER + ", with rotary inertia (Rayleigh)",
    nudges={"stiffness": 1.04},
)
def natural_frequencies(nudge: Nudge) -> Rows:
    """Compare the first three frequencies of a cantilever and of a bar on two pins: with the default elements
    the closed form lies inside the range, and 20 elements are within 1 %.
    """
    factor = nudge("stiffness")
    exact = [rayleigh(root, rotary) for root, rotary in (*CLAMPED_ROTARY, *PINNED_ROTARY)]
    inside = [
        frequency.estimated and frequency.low <= reference <= frequency.high
        for frequency, reference in zip(eigenfrequencies(4, factor), exact, strict=True)
    ]
    yield Row("share of closed forms inside, 4 elements", "1", 1.0, sum(inside) / len(inside), 1e-3)
    names = [f"frequency {k}, {support}" for support in ("clamped", "pinned") for k in (1, 2, 3)]
    for name, reference, value in zip(names, exact, eigenfrequencies(20, factor), strict=True):
        yield Row(name, "Hz", reference, value.value, 1e-2)


# Roots with the integral of (l phi')^2 over that of phi^2: half of it times I/(A l^2) is what rotary inertia
# takes.
CLAMPED_ROTARY = ((1.8751040687, 4.648), (4.6940911330, 32.417), (7.8547574382, 77.299))
PINNED_ROTARY = tuple((k * math.pi, (k * math.pi) ** 2) for k in (1, 2, 3))


def rayleigh(root: float, rotary: float) -> float:
    """Bending frequency (Hz) of the bar with rotary inertia."""
    return euler(root) * (1.0 - 0.5 * rotary * BAR.second_moment / BAR.area)


def eigenfrequencies(elements: int, stiffness: float) -> list[Measured]:
    """Return the first three frequencies (Hz) of the bar clamped at its start, and of the bar on two pins."""
    m = bar(elements, stiffness, clamped=True)
    result = modes(m, 3)
    return [*result.frequencies, *result.links["bar"]]


@verified("Spin-up of a flexible beam", SPIN_UP, nudges={"stiffness": 1.08}, quick=False)
def spin_up(nudge: Nudge) -> Rows:
    """Largest lag of the tip behind the turning base, its time, and the steady stretch, with 32 elements."""
    length, ea, ei, mass, inertia = 10.0, 2.8e7, 1.4e4, 1.2, 6e-4
    m = Mechanism("spin-up")
    m.point("O", 0.0, 0.0)
    section = Section(1.0, inertia / mass)
    m.link(
        "beam",
        length=length,
        model="elastic",
        elements=int(nudge("elements", 32.0)),
        section=section,
        material=Material("beam", ea * nudge("stiffness"), 0.3, mass),
    )
    m.revolute("O", "ground.O", "beam.start")
    if not math.isclose(ea * section.second_moment, ei):
        raise ValueError("the section does not give the bending stiffness of the source")
    times = np.concatenate([np.linspace(0.0, 15.0, 301), np.linspace(15.05, 31.0, 320)])
    angles = np.where(
        times < 15.0,
        0.4 * (0.5 * times**2 + (7.5 / math.pi) ** 2 * (np.cos(2.0 * math.pi * times / 15.0) - 1.0)),
        6.0 * times - 45.0,
    )
    m.drivers["beam"] = AngleTable(body="beam", times=tuple(times.tolist()), values=tuple(angles.tolist()))
    motion = run(m, duration=30.0, outputs=600)
    tip, angle = motion.pin("beam", "end"), motion.turn("beam", "start")
    cosine, across = np.cos(angle), np.sin(angle)
    lag = tip[:, 1] * cosine - tip[:, 0] * across
    stretch = tip[:, 0] * cosine + tip[:, 1] * across - length
    k = int(np.argmin(lag))
    a, b, c = np.polyfit(motion.time[k - 2 : k + 3] - motion.time[k], lag[k - 2 : k + 3], 2)
    yield Row("largest lag", "m", -0.5738, float(c - b * b / (4.0 * a)), 2e-3)
    yield Row("time of the largest lag", "s", 6.76, float(motion.time[k] - b / (2.0 * a)), 5e-3)
    steady = (motion.time > 16.0) & (motion.time < 30.0)
    yield Row(
        "steady stretch", "m", mass * 36.0 * length**3 / (3.0 * ea), float(stretch[steady].mean()), 1e-2
    )


@verified(
    "Free flight of a flexible beam",
    SPIN_UP.partition(";")[0] + " (data); conservation after the pulse",
    nudges={"damping": 1e-3, "pulse": 1.02},
    quick=False,
)
def flying_beam(nudge: Nudge) -> Rows:
    """E A = 1e4, E I = 500, ρA = 1, 10 m, thrown by a force and a moment at one end: momenta, energy, flight
    of its centre of mass.
    """
    ea, ei, length, force, moment, end = 1e4, 500.0, 10.0, 8.0, -80.0, 2.5
    m = Mechanism("flying beam")
    tilt = math.atan2(8.0, -6.0)
    section = Section(1.0, ei / ea)
    m.link(
        "beam",
        length=length,
        model="elastic",
        elements=20,
        section=section,
        material=Material("beam", ea, 0.3, 1.0),
        angle=tilt,
        position=(6.0, 0.0),
    )
    m.loads["push"] = PointForce(
        name="push", at="beam.start", force=(force * nudge("pulse"), 0.0), moment=moment, **pulse(end)
    )
    m.settings = dataclasses.replace(m.settings, damping=nudge("damping", 0.0))
    motion = run(m, duration=12.0, outputs=1200)
    yield Row(
        "x of the centre of mass at 12 s",
        "m",
        3.0 + 0.5 * force * end / length * (12.0 - 0.5 * end),
        float(motion.body("beam", "x")[-1]),
        1e-3,
    )
    late = motion.time > 1.5 * end
    record = motion.record
    nodes = list(record.assembly.bodies["beam"].particles)
    mass, inertia = (
        1.0 / record.parameter("particle_inverse_mass")[nodes],
        1.0 / record.parameter("particle_inverse_inertia")[nodes],
    )
    at = {axis: record.block(f"particle_{axis}")[:, nodes] for axis in "xy"}
    speed = {axis: values[:, nodes] for axis, values in velocities(record).items()}
    spin = ((at["x"] * speed["v"] - at["y"] * speed["u"]) * mass + speed["w"] * inertia).sum(axis=1)[late]
    push = (speed["u"] * mass).sum(axis=1)[late]
    energy = (motion.ledger.terms["kinetic"] + motion.ledger.terms["strain"])[late]
    yield Row("momentum after the pulse", "N s", 0.5 * force * end, float(push[-1]), 1e-4)
    yield Row("change of momentum", "N s", 0.0, float(np.ptp(push)), 1e-8, float(abs(push[0])))
    yield Row("change of angular momentum", "N m s", 0.0, float(np.ptp(spin)), 1e-5, float(abs(spin[0])))
    yield Row("change of energy", "J", 0.0, float(np.ptp(energy)), 1e-3, float(energy[0]))


SIMEON = (
    "Simeon: Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs. Math. Modelling"
    " of Systems 2 (1996) 1-18 (data; 150 rad/s = 1432 rpm); independent integration in a floating frame, two"
    " half sines, inextensible"
)


def bending_rod(times: np.ndarray) -> np.ndarray:
    """Deflection (m) of the middle of Simeon's rod: Lagrange's equations for the amplitudes q of sin(n pi
    s/l), n = 1, 2, on the line of its pins.

    Crank angle and guide leave the rod no other freedom: a chord of length l - sum (n pi q)^2/(4 l) from the
    crank's pin to the guide. Places r(q, t) of 40 points are differentiated along the motion by central
    differences, M q'' = -dV/dq - sum m J^T (r'' at q'' = 0).
    """
    l1, l2, speed, line, stiff, end = 0.15, 0.30, 150.0, 7870.0 * 0.008**2, 2.0e11 * 0.008**4 / 12.0, 0.075552
    node, weight = np.polynomial.legendre.leggauss(40)
    s, n = 0.5 * l2 * (node + 1.0), np.array([1.0, 2.0])
    mass = np.append(0.5 * l2 * weight * line, end)
    wave = n[:, None] * math.pi / l2
    shape, s_end = np.sin(wave * s), np.append(s, l2)
    # Half the integral of products of the slopes from 0 to s, for the shortening.
    grid = s_end[None, None, :]
    a, b = wave[:, None, :], wave[None, :, :]
    sinc = np.where(a == b, grid, np.sin((a - b) * grid) / np.where(a == b, 1.0, a - b))
    short = 0.25 * a * b * (sinc + np.sin((a + b) * grid) / (a + b))

    def place(q: np.ndarray, time: float) -> np.ndarray:
        x = s_end - np.einsum("i,j,ijk->k", q, q, short)
        w = np.append(q @ shape, 0.0)
        p = speed * time
        sine = -l1 * math.sin(p) / x[-1]
        cosine = math.sqrt(1.0 - sine * sine)
        return np.stack([l1 * math.cos(p) + cosine * x - sine * w, l1 * math.sin(p) + sine * x + cosine * w])

    spring = stiff * (n * math.pi / l2) ** 4 * 0.5 * l2
    h, d = 2e-6, 1e-6

    def rates(time: float, y: np.ndarray) -> np.ndarray:
        q, v = y[:2], y[2:]
        position = place(q, time)
        jacobian = np.stack(
            [(place(q + d * e, time) - place(q - d * e, time)) / (2.0 * d) for e in np.eye(2)]
        )
        pull = (place(q + h * v, time + h) - 2.0 * position + place(q - h * v, time - h)) / h**2
        matrix = np.einsum("iak,jak,k->ij", jacobian, jacobian, mass)
        return np.concatenate(
            [v, np.linalg.solve(matrix, -spring * q - np.einsum("iak,ak,k->i", jacobian, pull, mass))]
        )

    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        rates, (0.0, float(times[-1])), np.zeros(4), method="DOP853", t_eval=times, rtol=1e-7, atol=1e-9
    )
    return np.asarray(solution.y[0])


@verified("Slider-crank with an elastic rod at 1432 rpm", SIMEON, nudges={"stiffness": 1.03}, quick=False)
def elastic_slider_crank(nudge: Nudge) -> Rows:
    """Compare the largest deflections of the rod's middle within one and a half turns, and the deflection at
    four times, from a straight start.
    """
    m = Mechanism("Simeon's slider-crank")
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.15, mass=0.36)
    steel = Material("steel", 2.0e11 * nudge("stiffness"), 0.3, 7870.0)
    m.link("rod", length=0.30, model="elastic", elements=24, section=Section.square(0.008**2), material=steel)
    m.rigid_body("block", mass=0.075552, inertia=1e-4, position=(0.45, 0.0))
    m.revolute("A", "ground.O", "crank.start")
    m.revolute("B", "crank.end", "rod.start")
    m.revolute("C", "rod.end", "block.center")
    m.slider("G", "ground.O", "block.center")
    m.drive("crank", speed=150.0)
    m.start = dataclasses.replace(m.start, mode="rough")
    motion = run(m, duration=0.06, outputs=4000)
    nodes = motion.record.assembly.bodies["rod"].particles
    x, y = motion.record.block("particle_x"), motion.record.block("particle_y")
    first, middle, last = nodes[0], nodes[len(nodes) // 2], nodes[-1]
    dx, dy = x[:, last] - x[:, first], y[:, last] - y[:, first]
    bend = (dx * (y[:, middle] - y[:, first]) - dy * (x[:, middle] - x[:, first])) / np.hypot(dx, dy)
    grid = np.linspace(0.0, 0.06, 601)
    theirs, ours = bending_rod(grid), np.interp(grid, motion.time, bend)
    size = float(np.abs(theirs).max())
    yield Row("largest deflection", "m", float(theirs.max()), float(ours.max()), 1e-2)
    yield Row("least deflection", "m", float(theirs.min()), float(ours.min()), 1e-2)
    for k in (150, 300, 450, 600):
        yield Row(f"deflection at {grid[k]:g} s", "m", float(theirs[k]), float(ours[k]), 1e-2, size)


@verified(
    "Inertia of a lumped rod",
    "closed form: (m l²/12)(1 + 2/k²) + m r² of k equal elements, r the section's radius of gyration",
    nudges={"mass": 1.01},
)
def lumped_inertia(nudge: Nudge) -> Rows:
    """Spin of a free stiff link of 1, 2 and 4 elements after a pulse of moment at both ends."""
    for k in (1, 2, 4):
        m = Mechanism("lumped rod")
        section = Section.square(4e-4)
        m.link(
            "rod",
            length=0.5,
            model="elastic",
            elements=k,
            section=section,
            material=STEEL,
            mass=nudge("mass"),
        )
        for pin in ("start", "end"):
            m.loads[pin] = PointForce(name=pin, at=f"rod.{pin}", moment=0.5, **pulse(0.05))
        motion = run(m, duration=0.15, outputs=3000)
        inertia = 0.25 / 12.0 * (1.0 + 2.0 / k**2) + section.second_moment / section.area
        turned = np.polyfit(motion.time[motion.time > 0.06], motion.body("rod")[motion.time > 0.06], 1)[0]
        yield Row(f"spin with {k} element{'s' * (k > 1)}", "rad/s", 0.5 * 0.05 / inertia, float(turned), 1e-3)
