"""Natural frequencies against closed forms: beams, pendulums, a parallelogram on springs, and tangents
against differences of the step's forces.
"""

import dataclasses
import math

import numpy as np
import pytest

from support import SQUARE, four_bar
from vfife import gallery
from vfife.assembly.linearised import elements_of, linearised
from vfife.errors import AssemblyError
from vfife.kernels import frame
from vfife.measures.modes import link_frequencies, modes
from vfife.model.bodies import Section
from vfife.model.lumping import mesh
from vfife.model.mechanism import Mechanism
from vfife.solvers.refinement import meshed

G, DENSITY, YOUNG = 9.81, 7800.0, 207e9
ROD = Section.round(0.01)
# Roots of cos x cosh x = -1, clamped and free; of sin x, pinned; of tan x = tanh x, clamped and pinned.
CLAMPED_FREE = (1.8751040687, 4.6940911330, 7.8547574382)
CLAMPED_PINNED = (3.9266023120, 7.0685827456)


def beam(elements: int, angle: float = 0.3, **link) -> Mechanism:
    m = Mechanism("beam")
    m.point("O", 0.2, 0.1)
    m.point("P", 0.2 + math.cos(angle), 0.1 + math.sin(angle))
    m.link("beam", length=1.0, model="elastic", elements=elements, section=ROD, angle=angle, **link)
    return m


def roots(found) -> np.ndarray:
    """beta l of w = (beta l)^2 sqrt(E I/(mu l^4)), l = 1 m."""
    return np.sqrt(
        2.0 * math.pi * np.array(found) / math.sqrt(YOUNG * ROD.second_moment / (DENSITY * ROD.area))
    )


def test_a_cantilever() -> None:
    """Half a mass at the end is left over: of second order in the elements."""
    errors = []
    for elements in (10, 20):
        m = beam(elements)
        m.weld("clamp", "ground.O", "beam.start")
        errors.append(roots(modes(m, 3).frequencies) / CLAMPED_FREE - 1.0)
    assert np.abs(errors[1]).max() < 4e-3
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.05)


def test_a_beam_on_two_pins() -> None:
    """Slender: turning inertia takes (k pi r/l)^2/2 of it, r = d/4 (Rayleigh)."""
    m = beam(24)
    m.revolute("a", "ground.O", "beam.start")
    m.slider("b", "ground.P", "beam.end", direction=(math.cos(0.3), math.sin(0.3)))
    clamped = roots(modes(m, 2).frequencies)  # a slider keeps the angle of the beam's end
    np.testing.assert_allclose(clamped, CLAMPED_PINNED, rtol=1e-3)
    pinned = roots(modes(beam(24), 3).links["beam"])
    number = np.arange(1, 4)
    np.testing.assert_allclose(
        pinned, number * math.pi * (1.0 - 0.25 * (number * math.pi * 0.0025) ** 2), rtol=2e-5
    )


# Roots beta l with the integral of (l phi')^2 over that of phi^2; half of it times (r/l)^2 is what rotary
# inertia takes.
CLAMPED_ROTARY = ((1.8751040687, 4.648), (4.6940911330, 32.417), (7.8547574382, 77.299))
FREE_ROTARY = ((4.7300407449, 49.48), (7.8532046241, 108.92))
PINNED_ROTARY = tuple((k * math.pi, (k * math.pi) ** 2) for k in (1, 2, 3))


def closed_form(beta: float, rotary: float) -> float:
    """Frequency (Hz) of a root beta l, l = 1 m, with rotary inertia (Rayleigh)."""
    euler = beta**2 / (2.0 * math.pi) * math.sqrt(YOUNG * ROD.second_moment / (DENSITY * ROD.area))
    return euler * (1.0 - 0.5 * rotary * 0.0025**2)


@pytest.mark.parametrize("elements", [2, 3, 4, 5, 8, 16])
def test_ranges_contain_closed_forms(elements: int) -> None:
    """A cantilever, a free beam and a pinned one; no range is much wider than the error."""
    clamped = beam(elements)
    clamped.weld("clamp", "ground.O", "beam.start")
    free, pinned = beam(elements), beam(elements)
    found = (
        (modes(clamped, elements).frequencies, CLAMPED_ROTARY),
        (modes(free, elements + 2).frequencies[3:], FREE_ROTARY),
        (link_frequencies(pinned.bodies["beam"]), PINNED_ROTARY),
    )
    known = 0
    for frequencies, forms in found:
        for frequency, form in zip(frequencies, forms[: elements - 1], strict=False):
            exact = closed_form(*form)
            if frequency.estimated:
                known += 1
                assert frequency.low <= frequency <= frequency.high
                assert frequency.low <= exact <= frequency.high * (1.0 + 1e-6)
                assert frequency.width < 2.5 * abs(exact - frequency) + 1e-5 * exact
    assert known >= (2, 6)[elements > 2]


def test_a_vibration_keeps_its_shape_where_its_number_changes() -> None:
    """Along itself, the cantilever's is the fifth with four elements and the eighth or so with sixteen."""
    m = beam(4)
    m.weld("clamp", "ground.O", "beam.start")
    along = math.sqrt(YOUNG / DENSITY) / 4.0
    found = modes(m, 8)
    (frequency,) = [one for one in found.frequencies if abs(one / along - 1.0) < 0.02]
    assert frequency.low <= along <= frequency.high and frequency.width < 0.01 * along
    assert found.missing > 0 and modes(m, 2).missing == 0


def test_twins_are_matched_together() -> None:
    """Two equal cantilevers in one mechanism: their shapes mix, and both have the range of one."""
    single, double = beam(4), beam(4)
    double.link("other", length=1.0, model="elastic", elements=4, section=ROD, angle=0.3)
    for m in (single, double):
        for name in m.bodies:
            m.weld(f"clamp-{name}", "ground.O", f"{name}.start")
    (one,), (first, second) = modes(single, 1).frequencies, modes(double, 2).frequencies
    assert one.estimated and first.estimated and second.estimated
    assert (first.low, first.high) == pytest.approx((one.low, one.high), rel=1e-6)
    assert (second.low, second.high) == pytest.approx((one.low, one.high), rel=1e-6)


def test_frames_and_swinging_beams_have_ranges() -> None:
    """Those of a mesh eight times as fine lie inside."""
    m = gallery.lee_frame()
    fine = meshed(m, 8.0)
    for coarse, exact in zip(modes(m, 5).frequencies, modes(fine, 5).frequencies, strict=True):
        assert coarse.estimated and coarse.low <= exact <= coarse.high
        assert coarse.width < 0.01 * coarse


def test_rigid_mechanisms_are_exact_but_for_rounding() -> None:
    m = Mechanism("bob", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.point_mass("bob", mass=2.0, position=(0.0, -0.5))
    m.spring("coil", "ground.O", "bob.center", stiffness=2e4, free_length=0.5)
    found = modes(m)
    across, along = found.frequencies
    assert found.missing == 0
    for frequency, exact in ((across, math.sqrt(G / (0.5 + 2.0 * G / 2e4))), (along, math.sqrt(1e4))):
        assert 2.0 * math.pi * frequency.low <= exact <= 2.0 * math.pi * frequency.high
        assert frequency.width < 1e-6 * frequency


def test_a_beam_along_itself() -> None:
    """f = c/(4 l) of a rod held at one end, c = sqrt(E/rho)."""
    m = beam(20)
    m.weld("clamp", "ground.O", "beam.start")
    along = [
        mode for mode in modes(m, 60).modes if abs(mode.shape[-1, :2] @ (math.cos(0.3), math.sin(0.3))) > 0.99
    ]
    assert along[0].frequency == pytest.approx(math.sqrt(YOUNG / DENSITY) / 4.0, rel=1e-3)


@pytest.mark.parametrize("model", ["rigid", "elastic"])
@pytest.mark.parametrize("up", [False, True])
def test_a_compound_pendulum(model: str, up: bool) -> None:
    """w^2 = m g l/2 / (m l^2/3) = 1.5 g/l, hanging; the opposite of it, standing. An elastic one hangs a
    little lower and slower.
    """
    m = Mechanism("pendulum", gravity=(0.0, -G))
    m.point("O", 0.3, 0.4)
    m.link(
        "rod",
        length=1.0,
        model=model,
        section=Section.round(0.03),
        angle=0.5 * math.pi * (1.0 if up else -1.0),
    )
    if model == "elastic":
        m.bodies["rod"] = dataclasses.replace(m.bodies["rod"], elements=20)
    m.revolute("a", "ground.O", "rod.start")
    found = modes(m, 1)
    assert found.modes[0].square == pytest.approx(
        (-1.0 if up else 1.0) * 1.5 * G, rel=1e-9 if model == "rigid" else 3e-3
    )
    assert found.modes[0].frequency == (
        0.0 if up else pytest.approx(math.sqrt(found.modes[0].square) / (2.0 * math.pi))
    )
    assert found.unbalanced < 1e-6
    assert found.modes[0].leading == ("rod", pytest.approx(1.0))


def test_a_hung_string_is_stiff_by_its_weight_alone() -> None:
    """A mass on a spring pulls it straight: across it swings as a pendulum of its length, along it by k/m."""
    m = Mechanism("bob", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.point_mass("bob", mass=2.0, position=(0.0, -0.5))
    m.spring("coil", "ground.O", "bob.center", stiffness=2e4, free_length=0.5)
    across, along = modes(m).frequencies
    sag = 2.0 * G / 2e4
    assert 2.0 * math.pi * across == pytest.approx(math.sqrt(G / (0.5 + sag)), rel=1e-8)
    assert 2.0 * math.pi * along == pytest.approx(math.sqrt(2e4 / 2.0), rel=1e-9)


def test_a_parallelogram_on_springs() -> None:
    """Two cranks of length a and a coupler that only shifts: w^2 = (2 k + m_c g a + m g a)/(2 m a^2/3 + m_c
    a^2), m each crank's mass.
    """
    a, crank, coupler, stiffness = 0.2, 1.5, 4.0, 30.0
    m = Mechanism("parallelogram", gravity=(0.0, -G))
    for name, x in (("A", 0.0), ("D", 0.5)):
        m.point(name, x, 0.0)
    m.link("left", length=a, mass=crank, angle=-0.5 * math.pi)
    m.link("right", length=a, mass=crank, angle=-0.5 * math.pi)
    m.link("coupler", length=0.5, mass=coupler, angle=0.0)
    m.revolute("A", "ground.A", "left.start")
    m.revolute("D", "ground.D", "right.start")
    m.revolute("B", "left.end", "coupler.start")
    m.clearance_joint("C", "coupler.end", "right.end", clearance=1e-4, bearing_radius=0.01)  # counts as ideal
    m.torsional_spring("first", "ground", "left", stiffness=stiffness)
    m.torsional_spring("second", "ground", "right", stiffness=stiffness)
    (mode,) = modes(m).modes
    square = (2 * stiffness + coupler * G * a + crank * G * a) / (2 * crank * a**2 / 3 + coupler * a**2)
    assert mode.square == pytest.approx(square, rel=1e-8)
    assert sum(mode.energy.values()) == pytest.approx(1.0)
    assert mode.energy["coupler"] == pytest.approx(coupler * a**2 / (2 * crank * a**2 / 3 + coupler * a**2))


def test_drivers_hold_or_are_released() -> None:
    assert modes(four_bar("BCD")).count == 0
    assert modes(four_bar("BCD"), released=True).frequencies == (0.0,)
    elastic = four_bar("", model="elastic", elements=4, section=SQUARE)
    held, free = modes(elastic, 3).frequencies, modes(elastic, 3, released=True).frequencies
    assert free[0] == 0.0 and held[0] > 100.0 and free[1] > held[0]


def test_a_start_that_is_no_equilibrium_is_told() -> None:
    m = Mechanism("pendulum", gravity=(0.0, -G))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=1.0, angle=0.0)
    m.revolute("a", "ground.O", "rod.start")
    assert modes(m).unbalanced > 0.3


@pytest.mark.parametrize("release", ["none", "start", "end", "both"])
def test_the_tangent_of_an_element_is_that_of_the_steps_forces(release: str) -> None:
    """Bent and stretched: against central differences of the frame element's own force functions."""
    m = Mechanism("bar")
    link = m.link("bar", length=0.4, model="elastic", elements=1, section=ROD, release=release)
    (element,) = elements_of(mesh(link), 0)
    code = {"none": 0, "start": 1, "end": 2, "both": 3}[release]
    at = np.array([0.1, 0.2, 0.71, 0.1 + 0.4004 * math.cos(0.7), 0.2 + 0.4004 * math.sin(0.7), 0.67])

    def force(q):
        length, inverse, c, s = frame.chord(q[3] - q[0], q[4] - q[1])
        n = frame.axial(length, 0.4, 2.5, 0.0, element.axial)
        turn = frame.turn(c, s, math.cos(0.7), math.sin(0.7)) + 0.7
        bending = YOUNG * ROD.second_moment
        m1, m2 = {
            0: lambda: frame.bending(q[2] - turn, q[5] - turn, 2.5, 0.0, 0.0, bending),
            1: lambda: (0.0, frame.bending_released(q[5] - turn, 2.5, 0.0, bending)),
            2: lambda: (frame.bending_released(q[2] - turn, 2.5, 0.0, bending), 0.0),
            3: lambda: (0.0, 0.0),
        }[code]()
        px, py = frame.nodal_force(c, s, inverse, n, m1, m2)
        return np.array([px, py, -m1, -px, -py, -m2])

    found, tangent = np.zeros(6), np.zeros((6, 6))
    element.put(at.reshape(2, 3), found, tangent)
    np.testing.assert_allclose(found, force(at), rtol=1e-9, atol=1e-6)
    differences = np.array([(force(at + h) - force(at - h)) / 2e-6 for h in 1e-6 * np.eye(6)]).T
    np.testing.assert_allclose(tangent, -differences, atol=1e-7 * np.abs(tangent).max())


def test_shapes_leave_the_joints_closed() -> None:
    m = four_bar("", model="elastic", elements=4, section=SQUARE)
    linear = linearised(m, released=True)
    for mode in modes(m, 5, released=True).modes:
        coupler, follower = (linear.numbering.bodies[name].particles for name in ("coupler", "follower"))
        np.testing.assert_allclose(mode.shape[coupler[-1], :2], mode.shape[follower[-1], :2], atol=1e-9)
        assert np.hypot(*mode.shape[:, :2].T).max() == pytest.approx(1.0)


def test_a_frame_too_large_is_told() -> None:
    with pytest.raises(AssemblyError, match="take fewer elements"):
        modes(beam(3000))
    assert len(link_frequencies(beam(6).bodies["beam"], 2)) == 2


@pytest.mark.parametrize(("length", "section", "share"), [
    (0.26, Section.square(1e-3), 2.09), (1.0, Section.round(0.01), 22.5),
])  # fmt: skip
def test_stiffness_proportional_damping_would_divide_the_step(
    length: float, section: Section, share: float
) -> None:
    """Why there is none (docs/designer.md): 1 % of the first bending mode, C = beta K, is xi w_max/w_1 of the
    highest, and a central difference with velocities half a step old is stable below 2/w_max (sqrt(1 + xi^2)
    - xi): here by the largest eigenvalue of its step.
    """
    m = Mechanism("rod")
    part = mesh(m.link("rod", length=length, model="elastic", elements=8, section=section))
    force, stiffness = np.zeros(27), np.zeros((27, 27))
    for element in elements_of(part, 0):
        element.put(np.column_stack([part.position, np.zeros(9)]), force, stiffness)
    moving = np.setdiff1d(np.arange(27), [0, 1, 25])
    root = np.sqrt(np.column_stack([part.mass, part.mass, part.inertia]).reshape(-1)[moving])
    k = stiffness[np.ix_(moving, moving)] / np.outer(root, root)
    rates = np.sqrt(np.linalg.eigvalsh(k))
    beta = 2.0 * 0.01 / rates[0]
    xi = 0.5 * beta * rates[-1]
    limit = 2.0 / rates[-1] * (math.sqrt(1.0 + xi * xi) - xi)

    def growth(dt: float, damped: float) -> float:
        one = np.eye(len(k))
        kick = np.block([[one, np.zeros_like(k)], [-dt * k, one - dt * damped * k]])
        drift = np.block([[one, dt * one], [np.zeros_like(k), one]])
        return float(np.abs(np.linalg.eigvals(drift @ kick)).max())

    assert growth(0.999 * limit, beta) < 1.0 + 1e-6 < growth(1.001 * limit, beta)
    assert growth(0.999 * 2.0 / rates[-1], 0.0) < 1.0 + 1e-6 < growth(1.001 * 2.0 / rates[-1], 0.0)
    assert 2.0 / rates[-1] / limit == pytest.approx(share, rel=0.01)
