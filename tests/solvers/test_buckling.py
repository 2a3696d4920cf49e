"""Stability of equilibria: closed forms of critical loads, and what is stable for another reason."""

import math

import numpy as np
import pytest

import vfife
from vfife.assembly.assemble import assemble
from vfife.laws import Material
from vfife.model.bodies import Section
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.report.front import conclusion
from vfife.report.run import document
from vfife.report.static_cautions import stability_cautions
from vfife.simulation.result import Result
from vfife.solvers.buckling import positive
from vfife.solvers.relaxation import Relaxation
from vfife.solvers.statics import equilibrium

EI = 1.0
SECTION, MATERIAL = Section(1.0, 1e-4), Material(youngs_modulus=1e4)
SHARES = (0.9, 0.98, 1.02, 1.1)


def empty(*factors: float, **settings) -> Mechanism:
    return Mechanism("m", settings=Settings(analysis="static", load_factors=factors, **settings))


def states(m: Mechanism) -> list[bool | None]:
    record = equilibrium(assemble(m))
    assert record.status == "complete", record.message
    assert [factor for factor, _ in record.unstable] == [0.0, *m.settings.load_factors]
    return [state for _, state in record.unstable]


def column(
    *factors: float, load: float, elements: int = 20, angle: float = 0.0, across: float = 0.0
) -> Mechanism:
    """A cantilever of 1 m and EI = 1 N m^2 under a force along it, positive if it presses."""
    m = empty(*factors)
    m.point("O", 0.0, 0.0)
    m.link(
        "b", length=1.0, angle=angle, mass=1.0, model="elastic", elements=elements, section=SECTION,
        material=MATERIAL,
    )  # fmt: skip
    m.weld("clamp", "ground.O", "b.start")
    c, s = math.cos(angle), math.sin(angle)
    m.loads["P"] = PointForce(name="P", at="b.end", force=(-load * c - across * s, -load * s + across * c))
    return m


def strut(*factors: float, load: float) -> Mechanism:
    """A pinned strut whose end slides along it."""
    m = empty(*factors)
    m.point("O", 0.0, 0.0)
    m.point("T", 1.0, 0.0)
    m.link("b", length=1.0, mass=1.0, model="elastic", elements=20, section=SECTION, material=MATERIAL)
    m.point_mass("end", mass=0.1, position=(1.0, 0.0))
    m.revolute("pin", "ground.O", "b.start")
    m.revolute("tip", "b.end", "end.center")
    m.slider("guide", "ground.T", "end.center")
    m.loads["P"] = PointForce(name="P", at="end.center", force=(-load, 0.0))
    return m


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.5 * math.pi])
def test_a_clamped_column_is_unstable_from_its_euler_load_on(angle: float) -> None:
    m = column(*SHARES, 4.0, load=0.25 * math.pi**2 * EI, angle=angle)
    assert states(m) == [False, False, False, True, True, True]


def test_a_pinned_strut_is_unstable_from_its_euler_load_on() -> None:
    assert states(strut(*SHARES, 6.0, load=math.pi**2 * EI)) == [False, False, False, True, True, True]


def test_a_portal_sways_at_its_critical_load() -> None:
    """Clamped legs and a beam alike: kh cot kh = -6, P = (kh)^2 EI/h^2 on each leg."""
    low, high = 0.5 * math.pi + 0.1, math.pi - 0.01
    for _ in range(60):
        k = 0.5 * (low + high)
        low, high = (k, high) if k / math.tan(k) > -6.0 else (low, k)
    assert pytest.approx(2.7165, rel=1e-4) == low
    m = empty(*SHARES, 3.0)
    m.point("A", 0.0, 0.0)
    m.point("B", 1.0, 0.0)
    nodes = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (0.0, 1.0), "d": (1.0, 1.0)}
    members = [vfife.bodies.Member(*ends, elements=10) for ends in (("a", "c"), ("c", "d"), ("b", "d"))]
    m.frame("f", nodes=nodes, members=members, section=SECTION, material=MATERIAL)
    for point, node in ("Aa", "Bb"):
        m.weld(f"clamp {node}", f"ground.{point}", f"f.{node}")
    for node in "cd":
        m.loads[node] = PointForce(name=node, at=f"f.{node}", force=(0.0, -low * low * EI))
    assert states(m) == [False, False, False, True, True, True]


def test_a_fine_mesh_shows_its_buckling_load_too() -> None:
    """The stiffness of the buckling shape is 1e-10 of that of an element."""
    m = column(0.98, 1.02, load=0.25 * math.pi**2 * EI, elements=100)
    assert states(m) == [False, False, True]


def pendulum(*factors: float, press: float, stiffness: float = 0.0) -> Mechanism:
    """A rigid link of 1 m under a force along it, on a torsional spring or free to turn."""
    m = empty(*factors)
    m.point("O", 0.0, 0.0)
    m.link("arm", length=1.0, mass=1.0)
    m.revolute("J", "ground.O", "arm.start")
    if stiffness:
        m.torsional_spring("k", "ground", "arm", stiffness=stiffness)
    m.loads["P"] = PointForce(name="P", at="arm.end", force=(-press, 0.0))
    return m


@pytest.mark.parametrize("share", SHARES)
def test_a_rigid_column_on_a_spring_is_unstable_from_k_over_l_on(share: float) -> None:
    assert states(pendulum(share, press=1.0, stiffness=1.0)) == [False, share > 1.0]


def test_a_pendulum_under_a_force_that_presses_is_unstable_and_under_one_that_pulls_is_not() -> None:
    assert states(pendulum(1.0, press=1.0)) == [False, True]
    assert states(pendulum(1.0, press=-1.0)) == [False, False]


def test_tension_and_a_bent_strut_are_stable() -> None:
    euler = 0.25 * math.pi**2 * EI
    assert not any(states(column(1.0, 10.0, load=-euler)))
    assert not any(states(column(0.5, 1.0, 1.5, 2.0, load=euler, across=1e-2)))


def test_what_nothing_holds_and_nothing_loads_is_not_unstable() -> None:
    m = empty(0.0)
    m.point_mass("p", mass=1.0)
    assert states(m) == [False, False]


def test_a_force_that_follows_its_body_has_no_verdict() -> None:
    m = column(1.0, load=0.0)
    m.loads["P"] = PointForce(name="P", at="b.end", force=(0.0, 1.0), follow=True)
    assert states(m)[1] is None


@pytest.mark.parametrize("weight", [1.0, 1e3])
def test_a_journal_at_the_lowest_point_of_its_bearing_is_stable(weight: float) -> None:
    m = empty(1.0)
    m.point("O", 0.0, 0.0)
    m.point_mass("p", mass=1.0)
    m.clearance_joint("J", "ground.O", "p.center", clearance=1e-4, bearing_radius=0.01, axial_length=0.02)
    m.loads["F"] = PointForce(name="F", at="p.center", force=(0.0, -weight))
    assert states(m) == [False, False]


def test_a_column_under_a_load_through_a_loose_pin_buckles() -> None:
    m = column(0.9, 1.1, load=0.0)
    m.point_mass("p", mass=1.0, position=(1.0, 0.0))
    m.clearance_joint("J", "b.end", "p.center", clearance=1e-4, bearing_radius=0.01, axial_length=0.02)
    m.loads["P"] = PointForce(name="P", at="p.center", force=(-0.25 * math.pi**2 * EI, 0.0))
    assert states(m) == [False, False, True]


def test_the_test_changes_no_bit_of_the_equilibria() -> None:
    m = column(0.5, 2.0, load=0.25 * math.pi**2 * EI, elements=8, across=1e-2)
    tested, bare = equilibrium(assemble(m)), equilibrium(assemble(m), examine=False)
    assert (tested.rows == bare.rows).all() and bare.unstable == ()


def test_too_many_coordinates_are_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vfife.solvers.buckling.MOST_COORDINATES", 20)
    m = column(1.0, load=1.0, elements=10)
    assert states(m) == [None, None]
    (text,) = stability_cautions(equilibrium(assemble(m)))
    assert "load factors 0 to 1 are stable is not known" in text


def test_cautions_lead_the_answer_and_data_have_each_load_factor() -> None:
    summary = vfife.simulate(column(0.5, 1.5, load=0.25 * math.pi**2 * EI, elements=6), companions=0).summary
    assert [factor["unstable"] for factor in summary["run"]["factors"]] == [False, False, True]
    kinds = [type(part).__name__ for part in document(summary).parts]
    assert kinds.index("Caution") < kinds.index("Table")
    assert conclusion(summary) == ["The analysis found 2 of 2 equilibria, 1 of them unstable."]


def test_the_caution_brackets_the_load_and_a_file_keeps_it(tmp_path) -> None:
    m = column(0.5, 1.5, 2.0, load=0.25 * math.pi**2 * EI, elements=6)
    result = vfife.simulate(m)
    (text,) = (text for text in result.summary["warnings"] if "unstable" in text)
    for said in ("load factors 1.5 to 2 are unstable", "between 0.5 and 1.5", "imperfection"):
        assert said in text
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    assert again.record.unstable == result.record.unstable
    assert text in again.summary["warnings"]


def test_an_analysis_that_goes_on_from_its_file_remembers() -> None:
    first, second = (Relaxation(assemble(column(1.0, load=1.0, elements=4)), 1.0) for _ in range(2))
    first.unstable = [(0.0, False), (1.0, None)]
    second.restore(first.state, np.arange(len(first.state)), first.checkpoint)
    assert second.unstable == first.unstable


def test_pivots_tell_the_sign() -> None:
    matrix = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 0.6]])
    assert not positive(matrix)  # the determinant is -0.2
    matrix[2, 2] = 0.7
    assert positive(matrix)
