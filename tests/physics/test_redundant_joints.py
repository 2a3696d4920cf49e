"""Joints that hold more than there is to hold, and positions where they hold less: reactions by closed forms,
change points of coupled cranks.
"""

import dataclasses
import math
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from mechanisms import geared_ring
from support import go, joint_gap
from vfife.assembly.assemble import assemble
from vfife.assembly.checks import shared
from vfife.kinematics.initial import ideal_motion
from vfife.measures.error_ranges import ranged
from vfife.measures.forces import joint_force, joint_rows
from vfife.model.mechanism import Mechanism
from vfife.report.freedom import freedom, freedom_words
from vfife.report.summary import show
from vfife.simulation.result import Result
from vfife.simulation.simulate import simulate


@pytest.mark.system("runs a million steps")
def test_moments_of_gears_in_a_ring_do_not_drift():
    """Nothing is accelerated, so no moment is right; extrapolated reactions came to 587 and 1467 N m within
    20 s.
    """
    record = go(geared_ring(), "auto", duration=20.0, outputs=200)
    assert np.abs(record.block("joint_moment")).max() < 1e-5


def beam(cranks: int, speed: float, radius: float = 0.1, start: float = 0.7) -> Mechanism:
    """A beam of 3 kg on cranks 0.3 m apart, the first one driven."""
    m = Mechanism("coupled wheels")
    names = [f"crank{k}" for k in range(cranks)]
    pins = {f"p{k}": (0.3 * k, 0.0) for k in range(cranks)}
    at = (radius * math.cos(start), radius * math.sin(start))
    m.rigid_body("beam", mass=3.0, inertia=0.1, pins=pins, center=(0.15 * (cranks - 1), 0.0), position=at)
    for k, name in enumerate(names):
        m.point(f"O{k}", 0.3 * k, 0.0)
        m.link(name, length=radius, mass=1.0, angle=start)
        m.revolute(f"O{k}", f"ground.O{k}", f"{name}.start")
        m.revolute(f"B{k}", f"{name}.end", f"beam.p{k}")
    m.drive(names[0], speed=speed)
    return m


@pytest.mark.parametrize("start", [0.7, -0.3])
@pytest.mark.parametrize("step", [1e-3, 1e-4, 2e-5])
def test_a_beam_on_three_cranks_passes_its_change_points(step, start):
    """Twice a turn all cranks are in line with the beam and any of them could turn back; they go on, and the
    beam's weight in w^2 r is carried.
    """
    speed, radius = 20.0, 0.1
    record = go(beam(3, speed, radius, start), step, duration=min(3.0, 4e4 * step), outputs=400)
    assert record.status == "complete"
    turn = record.block("particle_theta")
    assert max(np.abs(turn[:, 3:5] - turn[:, 2:3]).max(), np.abs(turn[:, 1]).max()) < 100.0 * step**2 + 1e-7
    assert max(joint_gap(record, joint) for joint in ("B0", "B1", "B2")) < 1e-6 * (step / 1e-3) + 1e-11
    names = record.assembly.ideals
    total = sum(
        record.block(f"joint_{axis}")[1:, names.index(f"B{k}")] * part
        for k in range(3)
        for axis, part in (("fx", 1.0), ("fy", 1j))
    )
    wanted = -3.0 * speed**2 * radius * np.exp(1j * turn[1:, 2])
    assert np.abs(total - wanted).max() < (0.1 * step / 1e-3 + 1e-4) * np.abs(wanted).max()


@pytest.mark.parametrize("factor", [1e-16, 1.0, 1e6])
def test_what_is_left_open_does_not_depend_on_the_unit_of_mass(factor):
    """All cranks share what the beam presses on them with, the pivot of the driven one too; its torque
    follows from the work.
    """
    one = assemble(beam(3, 20.0), 1e-4, duration=0.01)
    state = one.state.copy()
    for kind in ("mass", "inertia"):
        state[one.layout[f"particle_inverse_{kind}"]] /= factor
    names = one.ideals, one.pivots, [name for name, body in one.bodies.items() if body.driven is not None]
    found = shared(one.layout, state, one.topology, *names)
    assert (
        found == shared(one.layout, one.state, one.topology, *names)
        and "O0.force" in found
        and "crank0.torque" not in found
    )


MASSES = (1.0, 2.5, 0.4)  # kg, of the cranks
START, RADIUS = 0.7, 0.1


def unequal(start: float = START, driven: bool = True) -> Mechanism:
    """The beam on three cranks of different masses, under gravity, with a pendulum on its middle pin."""
    m = dataclasses.replace(beam(3, 20.0, RADIUS, start), gravity=(0.0, -9.81))
    for k, mass in enumerate(MASSES):
        m.bodies[f"crank{k}"] = dataclasses.replace(m.bodies[f"crank{k}"], mass=mass)
    m.link("pendulum", length=0.2, mass=0.5, angle=-1.2)
    m.revolute("P", "beam.p1", "pendulum.start")
    if not driven:
        m.drivers.clear()
    return m


def weights(driven: bool) -> dict[str, np.ndarray]:
    """What a unit force at each pin moves it by along x and y, both bodies together: 1/m + (arm across)^2/I.
    A driven crank does not give way.
    """
    e = np.array([math.cos(START), math.sin(START)])
    found = {}
    for k, mass in enumerate(MASSES):
        crank = (
            np.zeros(2)
            if driven and k == 0
            else 1.0 / mass + (0.5 * RADIUS * e[::-1]) ** 2 / (mass * RADIUS**2 / 12.0)
        )
        beam_arm = np.array([0.0, 0.3 * k - 0.3])
        found[f"B{k}"] = crank + 1.0 / 3.0 + beam_arm**2 / 0.1
        found[f"O{k}"] = crank
    return found


@pytest.mark.parametrize("driven", [True, False])
def test_the_kinematics_shares_reactions_by_least_norm(driven: bool) -> None:
    """Forces 1, -2, 1 along the cranks move nothing: of least norm is what they have no part in, each row
    weighed by what it would move alone.
    """
    e, reaction, weight = (
        np.array([math.cos(START), math.sin(START)]),
        ideal_motion(unequal(driven=driven)).reaction,
        weights(driven),
    )
    parts = [
        part * weight[f"{pin}{k}"] * e * reaction[f"{pin}{k}"][:2]
        for k, part in enumerate((1.0, -2.0, 1.0))
        for pin in "OB"
    ]
    assert abs(np.sum(parts)) < 1e-9 * np.abs(parts).max()


def test_a_run_shares_them_as_the_kinematics_does() -> None:
    """Later reactions of the run are those of the ideal mechanism at the angle that it has then; of least
    norm without weights they are others.
    """
    m, step = unequal(), 1e-5
    m.bodies.pop("pendulum")
    m.joints.pop("P")
    record = go(m, step, duration=400 * step, outputs=4)
    angle = START + 20.0 * step * 400
    reaction, force, names = (
        ideal_motion(_turned(m, angle)).reaction,
        joint_force(record)[-1],
        list(joint_rows(record)),
    )
    largest = np.abs(force).max()
    for name in names:
        assert np.abs(force[names.index(name)] - reaction[name][:2]).max() < 1e-5 * largest


def _turned(m: Mechanism, angle: float) -> Mechanism:
    for k in range(3):
        m.bodies[f"crank{k}"] = dataclasses.replace(m.bodies[f"crank{k}"], angle=angle)
    m.bodies["beam"] = dataclasses.replace(
        m.bodies["beam"], position=(RADIUS * math.cos(angle), RADIUS * math.sin(angle))
    )
    return m


def test_a_door_on_two_hinges_hangs_on_both_alike() -> None:
    """Two pins in one place: half of the weight on each."""
    m = Mechanism("door", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("door", length=0.5, mass=2.0, angle=-0.5 * math.pi)
    m.revolute("upper", "ground.O", "door.start")
    m.revolute("lower", "ground.O", "door.start")
    record = go(m, 1e-4, duration=0.01, outputs=10)
    for name in ("upper", "lower"):
        assert ideal_motion(m).reaction[name][:2] == pytest.approx((0.0, 9.81), abs=1e-9)
        assert joint_force(record)[:, list(joint_rows(record)).index(name)] == pytest.approx(
            np.tile([0.0, 9.81], (11, 1)), abs=1e-6
        )
    assert set(record.assembly.shared) == {"upper.force", "lower.force"}


def test_only_reactions_that_are_left_open_are_called_so(tmp_path: Path) -> None:
    """The pendulum's pin is determined, and so is what turns the crank, since a force along the crank has no
    moment.
    """
    found = simulate(unequal(), duration=2e-3, step=1e-5, companions=0)
    wanted = {f"{pin}{k}.force.max" for pin in "OB" for k in range(3)}
    assert (
        {name for name, one in found.measures.items() if not one.unique}
        == wanted
        == set(found.summary["not_unique"])
    )
    assert found.measures["P.force.max"].unique and found.measures["crank0.torque.max"].unique
    found.save(tmp_path / "run")
    assert {name for name, one in Result.load(tmp_path / "run").measures.items() if not one.unique} == wanted


def test_moments_of_a_ring_of_gears_are_left_open_and_forces_are_not() -> None:
    record = go(geared_ring(), 1e-4, duration=0.01, outputs=2)
    open_ones = {name for name, one in ranged(record).items() if not one.unique}
    assert record.assembly.shared and all(
        name.endswith((".moment", ".torque")) for name in record.assembly.shared
    )
    assert not any(name.endswith(".force.max") for name in open_ones)


def test_what_is_determined_is_not_called_shared() -> None:
    assert assemble(beam(2, 20.0), 1e-4).shared == ()


def test_people_are_told_which_reactions_are_shared() -> None:
    """`vfife check` in a sentence, the summary by a mark and what it means."""
    m, named = unequal(), "B0.force, O1.force, B1.force, O2.force, B2.force, O0.force"
    assert f"Shared by least norm, not unique: {named}." in freedom_words(freedom(assemble(m)))
    told = StringIO()
    show(Console(file=told, width=160), simulate(m, duration=2e-3, step=1e-5, companions=0))
    lines = told.getvalue().splitlines()
    assert any(line.startswith("* shared by least norm, not unique") for line in lines)
    assert [line.split()[0] for line in lines if line.rstrip().endswith("*")] == [
        "O0",
        "B0",
        "O1",
        "B1",
        "O2",
        "B2",
    ]
