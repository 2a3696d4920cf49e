"""Static analyses as runs: results, files, messages, loads that depend on the factor."""

import dataclasses
import json
import math
import time
from pathlib import Path

import numpy as np
import pytest

import vfife
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.laws import Material
from vfife.model.bodies import Section
from vfife.model.drivers import AngleTable, ConstantSpeed, StepTo, Torque
from vfife.model.joints.clearance_revolute import ClearanceRevolute
from vfife.model.joints.ideal_revolute import IdealRevolute
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.simulation.result import Result
from vfife.solvers.relaxation import Relaxation
from vfife.solvers.statics import equilibrium

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def beam(*factors: float, **settings) -> Mechanism:
    """A cantilever of L = 1 m, EI = 1 N m^2."""
    m = Mechanism("beam", settings=Settings(analysis="static", load_factors=factors or (1.0,), **settings))
    m.point("O", 0.0, 0.0)
    m.link(
        "b",
        length=1.0,
        mass=1.0,
        model="elastic",
        elements=4,
        section=Section(1.0, 1e-4),
        material=Material(youngs_modulus=1e4),
    )
    m.weld("clamp", "ground.O", "b.start")
    return m


def tip(result: Result) -> np.ndarray:
    return result.record.block("particle_y")[:, result.record.assembly.bodies["b"].nodes["end"]]


def test_gravity_and_constant_loads_are_multiplied_and_tables_are_read():
    """Small deflections: F L^3/3EI for each."""
    m = beam(0.5, 1.0)
    m.loads["constant"] = PointForce(name="constant", at="b.end", force=(0.0, 1e-4))
    m.loads["table"] = PointForce(
        name="table", at="b.end", force=(0.0, 1e-4), times=(0.0, 0.5, 1.0), factors=(0.0, 3.0, 0.0)
    )
    found = tip(vfife.simulate(m))
    assert found == pytest.approx(np.array([0.0, 0.5 + 3.0, 1.0]) * 1e-4 / 3.0, rel=1e-4, abs=1e-12)
    n = beam(0.5, 1.0)
    n.gravity = (0.0, -1e-4)
    sag = tip(vfife.simulate(n))
    assert sag[2] == pytest.approx(2.0 * sag[1], rel=1e-4)
    lumped = sum(
        w * s**2 * (3.0 - s) / 6.0 for w, s in ((0.25, 0.25), (0.25, 0.5), (0.25, 0.75), (0.125, 1.0))
    )
    assert sag[2] == pytest.approx(-1e-4 * lumped, rel=1e-4)


def test_a_prescribed_travel_counts_from_the_start():
    m = beam(0.5, 1.0)
    m.drivers["push"] = StepTo(point="b.end", direction=(0.0, 1.0), travel=0.01, duration=1.0)
    result = vfife.simulate(m)
    assert tip(result) == pytest.approx([0.0, 0.005, 0.01], abs=1e-9)
    k = result.record.assembly.ideals.index("push")
    assert result.record.block("joint_fy")[1:, k] == pytest.approx([0.015, 0.03], rel=1e-3)


def test_a_torque_over_the_angle_is_multiplied():
    """Torque T (1 - 2 a) against a torsional spring k: a = f T/(k + 2 f T)."""
    m = Mechanism("lever", settings=Settings(analysis="static", load_factors=(0.5, 1.0)))
    m.point("O", 0.0, 0.0)
    m.link("arm", length=1.0, mass=1.0)
    m.revolute("J", "ground.O", "arm.start")
    m.torsional_spring("k", "ground", "arm", stiffness=4.0)
    m.drivers["arm"] = Torque(body="arm", value=(1.0, 0.0), angles=(0.0, 0.5))
    angle = equilibrium(assemble(m)).block("particle_theta")[1:, 1]
    assert angle == pytest.approx([0.5 / (4.0 + 1.0), 1.0 / (4.0 + 2.0)], rel=1e-6)


def test_the_result_is_one_equilibrium_a_factor(tmp_path):
    m = beam(0.5, 1.0)
    m.loads["F"] = PointForce(name="F", at="b.end", force=(0.0, 1.0))
    result = vfife.simulate(m)
    assert result.time.tolist() == [0.0, 0.5, 1.0]
    data = result.data
    assert data["time"].attrs["units"] == "1"
    assert not {"kinetic_energy", "energy_residual", "driver_work", "particle_u"} & set(data)
    assert (data["iterations"][1:] > 100).all()
    assert float(data["unbalanced"].max()) <= 1e-6
    work = 0.5 * float(data["displacement"][-1])
    assert float(data["strain_energy"][-1]) == pytest.approx(work, rel=0.1)
    assert result.summary["energy_error"] is None
    assert "work" not in str(result.summary["energy"])
    assert result.measures["clamp.moment.max"] == pytest.approx(0.9436, rel=0.01)
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    assert again.time.tolist() == result.time.tolist()
    assert (again.record.rows == result.record.rows).all()
    assert again.measures == result.measures
    assert set(result.plot()) == {"mechanism", "forces", "moments"}


def test_the_same_bits_again_and_interpreted():
    m = beam(0.2, residual=1e-3)
    m.loads["F"] = PointForce(name="F", at="b.end", force=(0.0, 1.0))
    m.bodies["b"] = dataclasses.replace(
        m.bodies["b"], elements=2, material=Material(youngs_modulus=1e4), section=Section(1.0, 1e-2)
    )
    one, two = equilibrium(assemble(m)), equilibrium(assemble(m), loop="interpreted")
    assert (one.rows == two.rows).all()


def test_iterations_that_do_not_suffice_are_told_and_what_was_found_is_kept():
    m = beam(0.0, 1.0, iterations=2000)
    m.loads["F"] = PointForce(name="F", at="b.end", force=(0.0, 1.0))
    record = equilibrium(assemble(m))
    assert record.status == "not converged"
    assert len(record.steps) == 2
    for said in ("load factor 1", "2,000 iterations", "1.00e-06", "Allow more"):
        assert said in record.message


def test_what_nothing_holds_is_told():
    m = Mechanism("free", gravity=(0.0, -9.81), settings=Settings(analysis="static"))
    m.point_mass("p", mass=1.0)
    record = equilibrium(assemble(m))
    assert record.status == "diverged"
    assert "runs away" in record.message and "3 free motions" in record.message
    assert record.steps.tolist() == [0]


def test_settings_without_meaning_are_refused_together():
    m = beam()
    m.settings = dataclasses.replace(m.settings, load_factors=(), duration=1.0, step=1e-5)
    with pytest.raises(ValueError, match="static analysis") as caught:
        vfife.simulate(m)
    for said in ("load_factors is empty", "duration = 1", "step = 1e-05"):
        assert said in str(caught.value)
    n = Mechanism("crank", settings=Settings(analysis="static"))
    n.point("O", 0.0, 0.0)
    n.link("crank", length=1.0, mass=1.0)
    n.revolute("A", "ground.O", "crank.start")
    n.drive("crank", speed=100.0)
    with pytest.raises(ValueError, match="turns 100 rad"):
        vfife.simulate(n)
    with pytest.raises(ValueError, match="turns = 2"):
        vfife.simulate(beam(), turns=2.0)


def test_a_crank_at_constant_speed_stands_at_speed_times_factor():
    m = Mechanism(
        "crank", gravity=(0.0, -10.0), settings=Settings(analysis="static", load_factors=(1.0, 2.0))
    )
    m.point("O", 0.0, 0.0)
    m.link("crank", length=1.0, mass=1.0, angle=0.2)
    m.revolute("A", "ground.O", "crank.start")
    m.drivers["crank"] = ConstantSpeed(body="crank", speed=0.5)
    record = equilibrium(assemble(m))
    assert record.block("particle_theta")[:, 1] == pytest.approx([0.2, 0.7, 1.2])
    assert record.block("driven_torque")[1:, 0] == pytest.approx(
        [5.0 * math.cos(0.7), 10.0 * math.cos(1.2)], rel=1e-9
    )
    assert record.block("driven_fy")[1:, 0] == pytest.approx([10.0, 20.0], rel=1e-9)


def test_a_table_of_angles_starts_where_it_says():
    m = Mechanism("crank", settings=Settings(analysis="static", load_factors=(1.0,)))
    m.point("O", 0.0, 0.0)
    m.link("crank", length=1.0, mass=1.0)
    m.revolute("A", "ground.O", "crank.start")
    m.drivers["crank"] = AngleTable(body="crank", times=(0.0, 1.0), values=(0.1, 0.4))
    assert equilibrium(assemble(m)).block("particle_theta")[:, 1] == pytest.approx([0.1, 0.4])


def test_progress_tells_the_seconds_since_the_analysis_began():
    heard, began = [], time.perf_counter()
    vfife.simulate(beam(0.5, 1.0), progress=heard.append)
    whole = time.perf_counter() - began
    assert heard and all(0.0 <= one.seconds <= whole for one in heard) and heard[-1].share == 1.0


def test_the_displacement_of_a_rigid_body_is_that_of_its_centre_of_mass() -> None:
    """A lever that turns about its end by a moment M against a torsional spring k: its middle moves by
    2 (l/2) sin(M/2k).
    """
    m = Mechanism("lever")
    m.point("O", 0.0, 0.0)
    m.link("lever", length=0.2, mass=1.0)
    m.revolute("A", "ground.O", "lever.start")
    m.torsional_spring("s", "ground", "lever", stiffness=10.0, free_angle=0.0)
    m.moment("M", "lever.end", moment=3.0)
    settings = dataclasses.replace(m.settings, analysis="static", load_factors=(1.0,))
    result = vfife.simulate(dataclasses.replace(m, settings=settings))
    assert result.measures["displacement.max"] == pytest.approx(0.2 * math.sin(0.15), rel=1e-5)
    moved = result["lever.x"][-1] - result["lever.x"][0], result["lever.y"][-1] - result["lever.y"][0]
    assert math.hypot(*moved) == pytest.approx(result.measures["displacement.max"], rel=1e-9)


def said_of_a_leap(m: Mechanism) -> str:
    """What a run says of a leap; empty if it says nothing."""
    texts = vfife.simulate(m, companions=0).summary["warnings"]
    return next((text for text in texts if "leaps" in text or "snapped" in text), "")


@pytest.mark.parametrize(
    "factors", [(0.001, 1.0), (0.01, 1.0), (0.02, 1.0), (0.0, 1.0), (0.01, 0.5, 0.501, 1.0), (0.5, 0.51, 1.0)]
)
def test_a_linear_structure_does_not_leap_whatever_its_load_factors_are(factors: tuple[float, ...]) -> None:
    m = beam(*factors)
    m.loads["P"] = PointForce(name="P", at="b.end", force=(0.0, 1e-4))
    assert said_of_a_leap(m) == ""


def test_a_linear_structure_under_a_table_of_loads_does_not_leap() -> None:
    """The table, not the load factor, states by how much the load rises."""
    m = beam(0.5, 0.9, 1.0)
    table = {"times": (0.0, 0.9, 1.0), "factors": (0.0, 0.01, 1.0)}
    m.loads["P"] = PointForce(name="P", at="b.end", force=(0.0, 1e-4), **table)
    assert said_of_a_leap(m) == ""


def truss(*factors: float, rise: float = 0.2) -> Mechanism:
    """Von Mises' truss of half span 1 m and EA = 1 MN under a unit force (N) at its apex."""
    m = Mechanism("truss", settings=Settings(analysis="static", load_factors=factors))
    m.point("A", 0.0, 0.0)
    m.point("B", 2.0, 0.0)
    size, angle = math.hypot(1.0, rise), math.atan2(rise, 1.0)
    section, steel = Section(1e-3, 1e-9), Material(youngs_modulus=1e9)
    bar = {"length": size, "mass": 1.0, "model": "two-particle", "release": "both", "section": section}
    m.link("left", angle=angle, material=steel, **bar)
    m.link("right", angle=math.pi - angle, material=steel, **bar)
    for name, ends in {"a": ("ground.A", "left.start"), "b": ("ground.B", "right.start")}.items():
        m.revolute(name, *ends)
    m.revolute("c", "left.end", "right.end")
    m.loads["P"] = PointForce(name="P", at="left.end", force=(0.0, -1.0))
    return m


LIMIT = 2e6 * 0.2**3 / (3.0 * math.sqrt(3.0))  # N, of a flat truss: 2 EA (rise/half span)^3/3 sqrt(3)


@pytest.mark.parametrize(
    ("shares", "words"),
    [
        ((0.25, 0.5, 0.75, 0.9, 1.02), "Between load factors 2771.28 and 3140.79 the structure"),
        ((0.8, 0.9, 0.91, 1.0, 1.01), "snapped through"),
        ((0.5, 0.55, 1.05), "snapped through"),
        ((0.01, 1.1), "snapped through"),
        ((0.5, 1.05), "snapped through"),
        ((1.0, 3.0), "Between load factors 0 and"),
        ((3.0,), "snapped through"),
        ((0.9, 100.0), "snapped through"),
        ((0.01, 0.9), ""),
        ((0.1, 0.9), ""),
        ((0.01, 0.1, 0.2, 0.9), ""),
        ((0.9,), ""),
        ((-1.0, -10.0), ""),
    ],
)
def test_a_truss_that_snaps_through_is_reported_and_below_its_limit_load_it_is_not(
    shares: tuple[float, ...], words: str
) -> None:
    said = said_of_a_leap(truss(*(share * LIMIT for share in shares)))
    assert words in said and bool(said) == bool(words)


def press(hand: float, count: int) -> Mechanism:
    """The toggle press of the examples with ``count`` even load factors of the hand's force (N)."""
    m = vfife.load(EXAMPLES / "toggle_press.toml")
    m.loads["hand"] = dataclasses.replace(m.loads["hand"], force=(hand, 0.0))
    factors = tuple((k + 1) / count for k in range(count))
    return dataclasses.replace(m, settings=dataclasses.replace(m.settings, load_factors=factors))


@pytest.mark.parametrize(
    ("hand", "count", "ends"),
    [
        (1600.0, 1, (0, 1)), (1600.0, 2, (0.5, 1)), (2000.0, 4, (0.5, 0.75)), (2000.0, 20, (0.65, 0.7)),
        (2000.0, 40, (0.65, 0.675)), (3000.0, 4, (0.25, 0.5)), (10000.0, 1, (0, 1)), (1300.0, 1, ()),
        (1300.0, 13, ()), (800.0, 2, ()),
    ],
)  # fmt: skip
def test_a_toggle_press_over_centre_is_reported_with_any_load_factors(hand, count, ends, tmp_path) -> None:
    """Its knee passes the line at 1305 N of the hand."""
    result = vfife.simulate(press(hand, count), companions=0, file=tmp_path / "run.sqlite")
    assert [pytest.approx(pair) for pair in result.record.snaps] == ([ends] if ends else [])
    for texts in (result.summary["warnings"], Result.load(tmp_path / "run.sqlite").summary["warnings"]):
        said = [text for text in texts if "became unstable" in text]
        assert len(said) == bool(ends) and all(f"{ends[0]:g} and {ends[1]:g} " in text for text in said)


def loose(m: Mechanism, clearance: float) -> Mechanism:
    """``m`` with ``clearance`` (m) in each pin."""
    for name, joint in list(m.joints.items()):
        if isinstance(joint, IdealRevolute):
            m.joints[name] = ClearanceRevolute(
                name=name, bearing=joint.bearing, journal=joint.journal, clearance=clearance,
                bearing_radius=0.015, axial_length=0.03,
            )  # fmt: skip
    return m


@pytest.mark.parametrize("clearance", [1e-5, 5e-5, 2e-4])
@pytest.mark.parametrize(
    ("hand", "count", "ends"),
    [
        (400.0, 1, ()), (400.0, 4, ()), (400.0, 8, ()), (1200.0, 1, ()), (1200.0, 4, ()), (1200.0, 8, ()),
        (1400.0, 1, (0, 1)), (1400.0, 8, (0.875, 1)), (2000.0, 4, (0.5, 0.75)),
    ],
)  # fmt: skip
def test_a_press_that_takes_up_clearance_does_not_snap_and_over_centre_it_does(
    clearance, hand, count, ends
) -> None:
    """Journals that cross their clearances are no snap, nor is a chunk in which contacts outgrow masses."""
    found = equilibrium(assemble(loose(press(hand, count), clearance)))
    assert found.status == "complete"
    assert found.snaps == ((pytest.approx(ends),) if ends else ())


@pytest.mark.parametrize("load", [1.0, 10.0, 100.0])
def test_a_cantilever_that_bends_far_is_stable(load: float) -> None:
    m = beam(load)
    m.loads["P"] = PointForce(name="P", at="b.end", force=(0.0, -1.0))
    assert equilibrium(assemble(m)).snaps == ()


def test_a_strut_beyond_its_buckling_load_becomes_unstable_and_below_it_does_not() -> None:
    m = beam(1.0, 2.0, 4.0)
    m.loads["P"] = PointForce(name="P", at="b.end", force=(-1.0, -0.001))
    assert equilibrium(assemble(m)).snaps == ((2.0, 4.0),)


def test_an_analysis_that_goes_on_from_its_file_remembers_a_snap() -> None:
    relaxation = Relaxation(assemble(truss(1.0)), 1.0)
    relaxation.snaps = [(0.5, 1.0)]
    other = Relaxation(assemble(truss(1.0)), 1.0)
    rows = np.arange(len(other.state))
    other.restore(relaxation.state, rows, json.loads(json.dumps(relaxation.checkpoint)))
    assert other.snaps == [(0.5, 1.0)]


@pytest.mark.parametrize("load", [2500.0, 5000.0, 7400.0])
def test_a_frame_far_beyond_its_limit_load_snaps_in_a_single_load_step(load: float) -> None:
    """Lee's frame, whose limit load is 1860 N, crosses its unstable part between two outputs."""
    m = gallery.lee_frame()
    del m.drivers["push"]
    m.loads["push"] = PointForce(name="push", at="frame.load", force=(0.0, -load))
    m.settings = dataclasses.replace(m.settings, load_factors=(1.0,))
    assert equilibrium(assemble(m)).snaps == ((0.0, 1.0),)
