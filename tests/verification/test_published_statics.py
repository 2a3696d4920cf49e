"""Equilibria against closed forms, published numbers and independent integrations."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from vfife.assembly.assemble import assemble
from vfife.laws import Frictionless, LankaraniNikravesh, Material
from vfife.model.bodies import Member, Section
from vfife.model.drivers import AngleTable, ConstantSpeed
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.solvers.record import Record
from vfife.solvers.statics import equilibrium

DEAD = {
    0.5: (0.015919, 0.162144),
    1.0: (0.056433, 0.301721),
    2.0: (0.160642, 0.493457),
    5.0: (0.387628, 0.713792),
    10.0: (0.554996, 0.810609),
}


def static(*factors: float, **settings) -> Settings:
    return Settings(analysis="static", load_factors=factors or (1.0,), **settings)


def slender(stiffness: float = 1.0, slenderness: float = 1e3) -> dict:
    """Section and material with EI = ``stiffness`` and EA L^2/EI = slenderness^2 for L = 1 m."""
    return {
        "section": Section(1.0, slenderness**-2),
        "material": Material(youngs_modulus=stiffness * slenderness**2),
    }


def cantilever(elements: int, *factors: float, **options) -> Mechanism:
    """A beam of L = 1 m, EI = 1 N m^2, clamped at its start."""
    m = Mechanism("cantilever", settings=static(*factors))
    m.point("O", 0.0, 0.0)
    m.link("beam", length=1.0, mass=1.0, model="elastic", elements=elements, **(slender() | options))
    m.weld("clamp", "ground.O", "beam.start")
    return m


def settled(mechanism: Mechanism) -> Record:
    record = equilibrium(assemble(mechanism))
    assert record.status == "complete", record.message
    return record


def at(record: Record, body: str, pin: str) -> np.ndarray:
    """Place and angle of a pin's particle under all load factors but the start."""
    node = (
        record.assembly.bodies[body].nodes[pin]
        if record.assembly.bodies[body].elements
        else record.assembly.bodies[body].particles[0]
    )
    return np.stack([record.block(f"particle_{axis}")[1:, node] for axis in ("x", "y", "theta")], axis=1)


def reaction(record: Record, joint: str) -> np.ndarray:
    """Force on the journal and moment on its body under all load factors."""
    k = record.assembly.ideals.index(joint)
    return np.stack([record.block(f"joint_{axis}")[1:, k] for axis in ("fx", "fy", "moment")], axis=1)


# --------------------------------------------------------------------------------------------------- elastica


@cache
def dead(elements: int) -> tuple[np.ndarray, Record]:
    m = cantilever(elements, *DEAD)
    m.loads["P"] = PointForce(name="P", at="beam.end", force=(0.0, 1.0))
    record = settled(m)
    end = at(record, "beam", "end")
    return np.stack([1.0 - end[:, 0], end[:, 1]], axis=1), record


@pytest.mark.system("compares whole runs with references")
def test_cantilever_under_a_dead_tip_load():
    """Bisshopp and Drucker's elastica; the reactions are those of statics on the bent beam."""
    moved, record = dead(20)
    for (load, exact), found, clamp in zip(DEAD.items(), moved, reaction(record, "clamp"), strict=True):
        assert found == pytest.approx(exact, rel=1e-3)
        assert clamp[0] == pytest.approx(0.0, abs=1e-5 * load)
        assert clamp[1] == pytest.approx(-load, rel=1e-5)
        assert clamp[2] == pytest.approx(-load * (1.0 - found[0]), rel=1e-5)
    assert record.block("unbalanced").max() < 1e-6


@pytest.mark.system("compares whole runs with references")
def test_the_elastica_converges_with_the_square_of_the_element():
    errors = [np.abs(dead(elements)[0][4, 1] / DEAD[10.0][1] - 1.0) for elements in (5, 10, 20)]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert slopes == pytest.approx([2.0, 2.0], abs=0.15), errors


@pytest.mark.system("compares whole runs with references")
def test_cantilever_rolled_up_by_an_end_moment():
    """x = sin(2 pi q)/(2 pi q), y = (1 - cos(2 pi q))/(2 pi q), as far as a closed circle; chords of equal
    arcs, so right to L/n squared.
    """
    turns = (0.25, 0.5, 1.0)
    m = cantilever(40, *turns, **slender(slenderness=300.0))
    m.loads["M"] = PointForce(name="M", at="beam.end", moment=2.0 * math.pi)
    record = settled(m)
    for q, end, clamp in zip(turns, at(record, "beam", "end"), reaction(record, "clamp"), strict=True):
        a = 2.0 * math.pi * q
        assert end[:2] == pytest.approx([math.sin(a) / a, (1.0 - math.cos(a)) / a], abs=1e-3)
        assert end[2] == pytest.approx(a, rel=1e-5)
        assert clamp[2] == pytest.approx(-a, rel=1e-5)
    assert record.block("frame_moment_2")[-1] == pytest.approx(2.0 * math.pi * np.ones(40), rel=1e-5)


def follower(load: float) -> tuple[float, float, float]:
    """Tip of an inextensible cantilever under a force that stays normal to its end: shot from the tip for the
    angle at the wall.
    """

    def tip(angle: float):
        fx, fy = -load * math.sin(angle), load * math.cos(angle)

        def back(s, y):  # from the tip to the wall: curvature grows as the force's moment does
            theta, curvature = y[2:]
            return [
                -math.cos(theta),
                -math.sin(theta),
                -curvature,
                -(fx * math.sin(theta) - fy * math.cos(theta)),
            ]

        return solve_ivp(back, (0.0, 1.0), [0.0, 0.0, angle, 0.0], method="DOP853", rtol=1e-10, atol=1e-11)

    angle = brentq(lambda a: tip(a).y[2, -1], 1e-6, 2.6)
    end = tip(angle).y[:, -1]
    return -end[0], -end[1], angle


@pytest.mark.system("compares whole runs with references")
def test_cantilever_under_a_follower_force():
    loads = (0.5, 1.0, 2.0, 4.0)
    m = cantilever(40, *loads, **slender(slenderness=300.0))
    m.loads["P"] = PointForce(name="P", at="beam.end", force=(0.0, 1.0), follow=True)
    for load, end in zip(loads, at(settled(m), "beam", "end"), strict=True):
        assert end == pytest.approx(follower(load), rel=1e-3)


# ----------------------------------------------------------------------------------------------- snap-through


def toggle(elements: int, *drops: float) -> Mechanism:
    """Williams' toggle, in inches and pounds."""
    m = Mechanism("toggle", settings=static(*drops))
    m.point("A", 0.0, 0.0)
    m.point("B", 2 * 12.943, 0.0)
    m.frame(
        "t", nodes={"A": (0.0, 0.0), "C": (12.943, 0.386), "B": (2 * 12.943, 0.0)},
        members=(Member("A", "C", elements), Member("C", "B", elements)),
        section=Section(1.885e6 / 1.03e7, 9.27e3 / 1.03e7), material=Material(youngs_modulus=1.03e7),
    )  # fmt: skip
    m.weld("a", "ground.A", "t.A")
    m.weld("b", "ground.B", "t.B")
    return m


@pytest.mark.system("compares whole runs with references")
@pytest.mark.parametrize(("elements", "upper", "lower"), [(4, 35.66, 32.91), (20, 33.94, 31.35)])
def test_both_limit_loads_of_the_williams_toggle(elements, upper, lower):
    """The way of the apex is prescribed, its reaction is the load."""
    drops = np.concatenate([np.linspace(0.21, 0.26, 6), np.linspace(0.37, 0.43, 7)])
    m = toggle(elements, *drops)
    m.drivers["push"] = ConstantSpeed(point="t.C", direction=(0.0, -1.0), speed=1.0)
    record = settled(m)
    load = -reaction(record, "push")[:, 1]
    peaks = [extreme(drops[part], load[part]) for part in (slice(0, 6), slice(6, 13))]
    assert [value for _, value in peaks] == pytest.approx([upper, lower], rel=1e-3)
    if elements == 20:
        assert [drop for drop, _ in peaks] == pytest.approx([0.2328, 0.3922], rel=0.01)
    support = reaction(record, "a") + reaction(record, "b")
    assert support[:, 1] == pytest.approx(load, rel=5e-5)
    assert support[:, 0] == pytest.approx(np.zeros(13), abs=1e-3)


def extreme(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Place and value of the extreme of a smooth curve."""
    fit = np.polynomial.Polynomial.fit(x, y, 4)
    roots = [float(r.real) for r in fit.deriv().roots() if abs(r.imag) < 1e-9 and x[0] <= r.real <= x[-1]]
    return roots[0], float(fit(roots[0]))


@pytest.mark.system("compares whole runs with references")
def test_under_load_the_toggle_snaps_through_at_the_limit():
    """Just below the limit load it holds, just above it it is on the other side, where the curve says."""
    m = toggle(4, 35.6, 35.7)
    m.loads["P"] = PointForce(name="P", at="t.C", force=(0.0, -1.0))
    drop = 0.386 - at(settled(m), "t", "C")[:, 1]
    assert drop[0] < 0.25 and drop[1] > 0.45
    n = toggle(4, float(drop[1]))
    n.drivers["push"] = ConstantSpeed(point="t.C", direction=(0.0, -1.0), speed=1.0)
    assert -reaction(settled(n), "push")[0, 1] == pytest.approx(35.7, rel=1e-4)


@pytest.mark.system("compares whole runs with references")
def test_two_bar_truss_against_its_closed_form():
    """Von Mises' truss of bars whose force is EA times the logarithm of their stretch, as path units add it
    up.
    """
    half, rise, ea = 1.0, 0.2, 1e6
    drops = np.linspace(0.02, 0.46, 12)
    m = Mechanism("truss", settings=static(*drops))
    m.point("A", 0.0, 0.0)
    m.point("B", 2.0 * half, 0.0)
    size, angle = math.hypot(half, rise), math.atan2(rise, half)
    bar = {
        "length": size,
        "mass": 1.0,
        "model": "two-particle",
        "release": "both",
        "strain": "current",
        "section": Section(1e-3, 1e-9),
        "material": Material(youngs_modulus=ea / 1e-3),
    }
    m.link("left", angle=angle, **bar)
    m.link("right", angle=math.pi - angle, **bar)
    m.revolute("a", "ground.A", "left.start")
    m.revolute("b", "ground.B", "right.start")
    m.revolute("c", "left.end", "right.end")
    m.drivers["push"] = ConstantSpeed(point="left.end", direction=(0.0, -1.0), speed=1.0)
    record = settled(m)
    y = rise - drops
    length = np.hypot(half, y)
    force = ea * np.log(length / size)
    assert record.block("frame_axial_force")[1:, 0] == pytest.approx(force, rel=1e-3)
    assert reaction(record, "push")[:, 1] == pytest.approx(
        2.0 * force * y / length, rel=1e-3, abs=1e-3 * np.abs(force).max() * 0.01
    )


def lee(elements: int) -> float:
    """Limit load of Lee's frame: two legs of 120, hinged at their feet, pushed down at 24 from the corner."""
    drops = np.linspace(44.0, 53.0, 6)
    m = Mechanism("Lee's frame", settings=static(15.0, 30.0, *drops))
    m.point("A", 0.0, 0.0)
    m.point("D", 120.0, 120.0)
    m.frame(
        "f",
        nodes={"A": (0.0, 0.0), "B": (0.0, 120.0), "P": (24.0, 120.0), "D": (120.0, 120.0)},
        members=(
            Member("A", "B", elements),
            Member("B", "P", elements // 5),
            Member("P", "D", 4 * elements // 5),
        ),
        section=Section(6.0, 2.0),
        material=Material(youngs_modulus=720.0),
    )
    m.revolute("a", "ground.A", "f.A")
    m.revolute("d", "ground.D", "f.D")
    m.drivers["push"] = ConstantSpeed(point="f.P", direction=(0.0, -1.0), speed=1.0)
    return extreme(drops, -reaction(settled(m), "push")[2:, 1])[1]


@pytest.mark.system("compares whole runs with references")
def test_limit_load_of_lees_frame():
    """1.8552, as the literature of path following quotes it (Schweizerhof and Wriggers 1986), is what 10 and
    20 elements a leg lead to.
    """
    coarse, fine = lee(10), lee(20)
    assert fine == pytest.approx(1.8552, rel=2e-3)
    assert fine + (fine - coarse) / 3.0 == pytest.approx(1.8552, rel=5e-4)


# --------------------------------------------------------------------------------------------------- buckling


@pytest.mark.system("compares whole runs with references")
def test_lateral_stiffness_vanishes_at_the_euler_load():
    """A pinned column pushed aside in its middle gives way by F/(k (1 - P/P_E)); the root of F/d over P is
    pi^2 EI/L^2.
    """
    shares = (0.5, 0.8, 0.9, 0.95)
    critical, aside = math.pi**2, 1e-4
    found = []
    for share in shares:
        m = Mechanism("column", settings=static(1.0, residual=1e-8))
        m.point("O", 0.0, 0.0)
        m.point("R", 1.0, 0.0)
        nodes = {"A": (0.0, 0.0), "M": (0.5, 0.0), "B": (1.0, 0.0)}
        m.frame(
            "c",
            nodes=nodes,
            members=(Member("A", "M", 20), Member("M", "B", 20)),
            **slender(slenderness=300.0),
        )
        m.revolute("a", "ground.O", "c.A")
        m.slider("b", "ground.R", "c.B", direction=(1.0, 0.0), turning=True)
        m.loads["P"] = PointForce(name="P", at="c.B", force=(-share * critical, 0.0))
        m.loads["F"] = PointForce(name="F", at="c.M", force=(0.0, aside))
        found.append(aside / at(settled(m), "c", "M")[0, 1])
    fit = np.polynomial.Polynomial.fit(np.array(shares) * critical, found, 2)
    zero = min(fit.roots().real, key=lambda r: abs(r - critical))
    assert zero == pytest.approx(critical, rel=1e-3)


# ------------------------------------------------------------------------------------------- indeterminate,
# curved, on springs


@pytest.mark.system("compares whole runs with references")
def test_clamped_at_both_ends():
    """Force in the middle: d = F L^3/(192 EI), end moments F L/8."""
    m = Mechanism("beam", settings=static())
    m.point("O", 0.0, 0.0)
    m.point("R", 1.0, 0.0)
    m.frame(
        "b",
        nodes={"A": (0.0, 0.0), "M": (0.5, 0.0), "B": (1.0, 0.0)},
        members=(Member("A", "M", 4), Member("M", "B", 4)),
        **slender(slenderness=50.0),
    )
    m.weld("a", "ground.O", "b.A")
    m.weld("z", "ground.R", "b.B")
    m.loads["F"] = PointForce(name="F", at="b.M", force=(0.0, -1e-2))
    record = settled(m)
    assert at(record, "b", "M")[0, 1] == pytest.approx(-1e-2 / 192.0, rel=1e-4)
    assert reaction(record, "a")[0, 1:] == pytest.approx([5e-3, 1.25e-3], rel=1e-4)
    assert reaction(record, "z")[0, 1:] == pytest.approx([5e-3, -1.25e-3], rel=1e-4)


@pytest.mark.system("compares whole runs with references")
def test_on_three_supports():
    """Two equal spans, a force in the middle of the first: reactions 13/32, 22/32 and -3/32 of it."""
    m = Mechanism("beam", settings=static())
    for name, x in (("A", 0.0), ("B", 1.0), ("C", 2.0)):
        m.point(name, x, 0.0)
    nodes = {"A": (0.0, 0.0), "M": (0.5, 0.0), "B": (1.0, 0.0), "C": (2.0, 0.0)}
    m.frame(
        "b",
        nodes=nodes,
        members=(Member("A", "M", 4), Member("M", "B", 4), Member("B", "C", 4)),
        **slender(slenderness=50.0),
    )
    m.revolute("a", "ground.A", "b.A")
    m.slider("b", "ground.B", "b.B", turning=True)
    m.slider("c", "ground.C", "b.C", turning=True)
    m.loads["F"] = PointForce(name="F", at="b.M", force=(0.0, -1e-2))
    record = settled(m)
    found = [reaction(record, name)[0, 1] for name in "abc"]
    assert np.array(found) == pytest.approx(1e-2 * np.array([13.0, 22.0, -3.0]) / 32.0, rel=1e-3)


@pytest.mark.system("compares whole runs with references")
def test_quarter_circle():
    """A curved cantilever with a force along its end's normal: d = pi F R^3/(4 EI), and F R^3/(2 EI) across,
    without stretch.
    """
    radius, elements = 1.0, 40
    angles = np.linspace(0.0, 0.5 * math.pi, elements + 1)
    points = (
        np.stack([np.sin(angles), 1.0 - np.cos(angles)], axis=1) * radius
    )  # from (0, 0), along x, to (1, 1)
    turned = points @ np.array(
        [[math.cos(math.pi / 4), -math.sin(math.pi / 4)], [math.sin(math.pi / 4), math.cos(math.pi / 4)]]
    )
    m = Mechanism("arch", settings=static(residual=1e-8))
    m.point("O", 0.0, 0.0)
    m.link(
        "arch", length=float(turned[-1, 0]), via=tuple(map(tuple, turned[1:-1])), mass=1.0, model="elastic",
        elements=elements, angle=math.pi / 4, **slender(slenderness=300.0),
    )  # fmt: skip
    m.weld("clamp", "ground.O", "arch.start")
    m.loads["F"] = PointForce(name="F", at="arch.end", force=(1e-4, 0.0))
    record = settled(m)
    moved = (at(record, "arch", "end")[0, :2] - points[-1]) / 1e-4
    # M(phi) = F (1 - y) with y = 1 - cos(phi): u = int M^2/F, v = int M * (1 - x)... by Castigliano
    assert moved[0] == pytest.approx(math.pi / 4.0, rel=1e-3)
    assert moved[1] == pytest.approx(-0.5, rel=1e-3)


@pytest.mark.system("compares whole runs with references")
def test_rigid_body_on_springs():
    """Three springs to the ground and gravity: the equations of the free body solved by SciPy."""
    m = Mechanism("table", gravity=(0.0, -9.81), settings=static(0.5, 1.0))
    anchors, pins = ((-1.0, 0.0), (0.2, -0.3), (1.3, 0.1)), ((-0.6, 0.8), (0.1, 0.8), (0.7, 0.9))
    stiffness, free = (900.0, 700.0, 1100.0), (0.9, 1.1, 1.0)
    m.rigid_body(
        "t", mass=20.0, inertia=1.0, center=(0.1, 1.0), pins={f"p{k}": pin for k, pin in enumerate(pins)}
    )
    for k, anchor in enumerate(anchors):
        m.point(f"g{k}", *anchor)
        m.spring(f"s{k}", f"ground.g{k}", f"t.p{k}", stiffness=stiffness[k], free_length=free[k])
    record = settled(m)

    def forces(q, factor):
        c, s = math.cos(q[2]), math.sin(q[2])
        total = np.array([0.0, -9.81 * 20.0 * factor, 0.0])
        for anchor, pin, k, size in zip(anchors, pins, stiffness, free, strict=True):
            r = np.array([[c, -s], [s, c]]) @ (np.array(pin) - (0.1, 1.0))
            away = q[:2] + r - np.array(anchor)
            length = np.hypot(*away)
            f = -k * (length - size) * away / length
            total += [*f, r[0] * f[1] - r[1] * f[0]]
        return total

    for factor, found in zip((0.5, 1.0), at(record, "t", "center"), strict=True):
        q = root(forces, found, args=(factor,), tol=1e-13).x
        assert np.abs(forces(q, factor)).max() < 1e-8
        assert found == pytest.approx(q, abs=1e-6)


@pytest.mark.system("compares whole runs with references")
def test_a_journal_settles_in_its_bearing():
    """Under its weight at the lowest point, as deep as the law says: m g = K d^1.5."""
    m = Mechanism("journal", gravity=(0.0, -9.81), settings=static(1.0, 2.0))
    m.point("O", 0.0, 0.0)
    m.point_mass("j", mass=1.0)
    m.clearance_joint(
        "J",
        "ground.O",
        "j.center",
        clearance=1e-3,
        bearing_radius=0.01,
        contact=LankaraniNikravesh(stiffness=6.6e10),
        friction=Frictionless(),
    )
    record = settled(m)
    for factor, place in zip((1.0, 2.0), at(record, "j", "center"), strict=True):
        depth = (9.81 * factor / 6.6e10) ** (2.0 / 3.0)
        assert place[1] == pytest.approx(-1e-3 - depth, rel=1e-6)
    assert record.block("contact_normal_force")[1:, 0] == pytest.approx([9.81, 19.62], rel=1e-5)


@pytest.mark.system("compares whole runs with references")
def test_a_journal_finds_the_lowest_point():
    """Under a force askew it rolls down to where the force points."""
    m = Mechanism("journal", gravity=(5.0, -9.81), settings=static())
    m.point("O", 0.0, 0.0)
    m.point_mass("j", mass=1.0)
    m.clearance_joint(
        "J",
        "ground.O",
        "j.center",
        clearance=1e-3,
        bearing_radius=0.01,
        contact=LankaraniNikravesh(stiffness=6.6e10),
    )
    x, y, _ = at(settled(m), "j", "center")[0]
    assert math.atan2(x, -y) == pytest.approx(math.atan2(5.0, 9.81), abs=1e-6)


@pytest.mark.system("relaxes a long rod")
@pytest.mark.parametrize("clear", [False, True])
def test_a_rod_comes_to_hang(clear):
    m = Mechanism("rod", gravity=(0.0, -9.81), settings=static())
    m.point("O", 0.0, 0.0)
    m.link("rod", length=1.0, mass=2.0)
    if clear:
        m.clearance_joint(
            "J",
            "ground.O",
            "rod.start",
            clearance=1e-3,
            bearing_radius=0.01,
            contact=LankaraniNikravesh(stiffness=6.6e10),
        )
    else:
        m.revolute("J", "ground.O", "rod.start")
    found = at(settled(m), "rod", "start")[0]
    depth = 1e-3 + (2.0 * 9.81 / 6.6e10) ** (2.0 / 3.0) if clear else 0.0
    assert found == pytest.approx([0.0, -0.5 - depth, -0.5 * math.pi], abs=5e-6)


@pytest.mark.system("compares whole runs with references")
def test_a_driven_crank_holds_a_weight():
    """A crank turned by a table: its torque is that of the weight at its end, sector by sector."""
    m = Mechanism("crank", gravity=(0.0, -9.81), settings=static(1.0, 2.0, 3.0))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.5, mass=2.0)
    m.revolute("A", "ground.O", "crank.start")
    m.drivers["crank"] = AngleTable(body="crank", times=(0.0, 1.0, 2.0, 3.0), values=(0.0, 0.3, 0.6, 0.9))
    record = settled(m)
    expected = [factor * 2.0 * 9.81 * 0.25 * math.cos(0.3 * factor) for factor in (1.0, 2.0, 3.0)]
    assert record.block("driven_torque")[1:, 0] == pytest.approx(expected, rel=1e-6)
