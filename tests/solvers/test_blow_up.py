"""Numbers that leave all bounds are seen within a thousand steps, in every loop and lane by lane; the step
and the likely cause are told.
"""

import dataclasses
import math

import numpy as np
import pytest

from support import SQUARE, bits, four_bar, lanes
from vfife import gallery, simulate
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import watched
from vfife.compiler.runtime.loops import python_line
from vfife.compiler.runtime.runner import Runner
from vfife.laws import Material
from vfife.model.mechanism import Mechanism
from vfife.report.divergence import cause, diverged, first_infinite
from vfife.solvers.ensemble import ensemble
from vfife.solvers.record import recorded_rows
from vfife.solvers.transient import run

LOOK = 1000  # steps between two looks of a run at its lanes, as docs/internals.md says

SOUND, TOO_LARGE = 2e-6, 2e-4  # s; 1.3e-5 s is stable
SOFT = 1e5  # N/m^1.5
WITHIN = 1000  # steps in which numbers that leave all bounds are seen: what a run says of itself
RADIUS = 0.01  # m, of the bearings: a deeper penetration has left the joint


def side_by_side(steps, loop: str, look: int | None = None, seen=None) -> Runner:
    """Case c in lanes with steps of their own, of which some are looked at, every ``look`` steps or as often
    as a run is.
    """
    every = [assemble(four_bar("BCD"), step, duration=0.02, force_step=True) for step in steps]
    first = every[0]
    states, tables = np.stack([a.state for a in every], axis=1), np.stack([a.tables for a in every])
    own = watched(every, np.array([True] * len(every) if seen is None else seen))
    runner = Runner(
        first.topology,
        states,
        tables,
        loop if loop != "straight line" else "interpreted",
        recorded_rows(first),
        watched=own,
    )
    if loop == "straight line":
        runner.take = python_line(runner.topology)(runner.memory)
    runner.look = runner.look if look is None else look
    return runner


@pytest.fixture(scope="module")
def burst() -> int:
    """The step after which a journal of case c has first left its bearing, or a number is infinite, looked
    for step by step.
    """
    runner = lanes([assemble(four_bar("BCD"), TOO_LARGE, duration=0.02, force_step=True)], "generated")
    depths = runner.layout["contact_penetration"]
    for step in range(2 * WITHIN):
        runner.advance(1, 1)
        if (
            not (runner.states[depths] < RADIUS).all()
            or not np.isfinite(runner.states[runner.row_numbers]).all()
        ):
            return step
    raise AssertionError("it never left")


@pytest.mark.parametrize(
    ("loop", "look"),
    [("generated", None), ("data-driven", None), ("generated", 1), ("data-driven", 1), ("straight line", 1)],
)
def test_a_lane_that_breaks_is_seen_where_somebody_looks(loop, look, burst):
    runner = side_by_side([TOO_LARGE], loop, look)
    runner.advance(1, 1)
    runner.advance(3 * WITHIN, 2)
    assert 0 <= runner.broken[0] - 1 - burst < (look or WITHIN)
    assert runner.broken[0] % (look or runner.look) == 0


def test_the_kernel_itself_looks(burst):
    """The text under a debugger: from the state three steps before."""
    before = lanes([assemble(four_bar("BCD"), TOO_LARGE, duration=0.02, force_step=True)], "generated")
    before.advance(burst - 2, 1)
    runner = side_by_side([TOO_LARGE], "interpreted", 1)
    runner.S[:], runner.done = before.S, before.done
    runner.advance(10, 3)
    assert runner.broken[0] - 1 == burst


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_a_lane_that_breaks_stops_no_other(loop, burst):
    steps = [SOUND, TOO_LARGE, 0.9 * SOUND, SOUND]
    runner, alone = side_by_side(steps, loop), [side_by_side([step], loop) for step in (steps[0], steps[2])]
    found = [one.advance(2500, 2) for one in (runner, *alone)]
    assert runner.broken[[0, 2, 3]].tolist() == [0.0, 0.0, 0.0]
    assert burst < runner.broken[1] <= burst + WITHIN
    for lane, rows in zip((0, 2), found[1:], strict=True):
        assert (bits(found[0][:, :, lane]) == bits(rows[:, :, 0])).all()


def test_lanes_that_nobody_looks_at_go_on():
    """What companions do when they break is theirs."""
    runner = side_by_side([SOUND, TOO_LARGE], "generated", seen=[True, False])
    runner.advance(2500, 2)
    assert runner.broken.tolist() == [0.0, -1.0]
    last = side_by_side([TOO_LARGE, TOO_LARGE], "generated", seen=[True, False])
    last.advance(10 * WITHIN, 2)
    assert (last.broken > 0.0).tolist() == [True, False]  # and the call was over then: nobody is waited for


def test_looks_change_no_bit():
    states = []
    for look in (1, 7, None):
        runner = side_by_side([SOUND] * 4, "generated", look)
        runner.advance(4321, 3)
        states.append(runner.S.copy())
    plain = lanes([assemble(four_bar("BCD"), SOUND, duration=0.02, force_step=True)] * 4, "generated")
    plain.advance(4321, 3)
    assert all((bits(state) == bits(plain.S)).all() for state in states)


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
@pytest.mark.parametrize("outputs", [1, 300])
def test_the_step_of_a_run_is_told_whatever_its_outputs(loop, outputs, burst):
    """A run of a minute with one output, and one whose outputs come every few steps: the same step, and the
    rows before it.
    """
    steps = 600_000 if outputs == 1 else 3000
    assembly = assemble(
        four_bar("BCD"), TOO_LARGE, duration=steps * TOO_LARGE, outputs=outputs, force_step=True
    )
    record = run(assembly, loop=loop, companions=3 if loop == "generated" else 0)
    assert record.status == "diverged"
    assert record.burst.step == burst
    assert record.reached <= burst
    assert record.steps[-1] == (burst - 1) // assembly.choice.outputs_every * assembly.choice.outputs_every
    assert "joint" in first_infinite(record)[1]


def test_members_of_an_ensemble_break_alone():
    """A member that breaks is left where it does, whatever runs beside it: what comes after is no number, and
    no turn of it settles.
    """
    coupler = dataclasses.replace(four_bar("BCD").bodies["coupler"], mass=1e-5)
    wild = dataclasses.replace(four_bar("BCD"), bodies=four_bar("BCD").bodies | {"coupler": coupler})
    options = {"step": 1e-5, "turns": 2, "outputs": 40, "tolerance": 1e-3, "loop": "generated", "workers": 1}
    (alone,) = ensemble([wild], **options)
    sound, beside = ensemble([four_bar("BCD"), wild], **options)
    assert (sound.status, alone.status, beside.status) == ("complete", "diverged", "diverged")
    assert np.isfinite(sound.last.rows).all() and not np.isfinite(alone.last.rows).all()
    assert np.isfinite(alone.last.rows[0]).all() and np.isnan(alone.last.rows[-1]).all()
    assert np.array_equal(bits(alone.last.rows), bits(beside.last.rows))
    assert alone.settled is None and math.isinf(alone.distances[-1])


# ----------------------------------------------------------------------------------------------- likely cause


def told(mechanism: Mechanism, **options) -> str:
    record = simulate(mechanism, reference=False, outputs=5, **options).record
    assert record.status == "diverged"
    return cause(record, first_infinite(record)[0] * record.assembly.choice.step)


def test_a_step_that_was_forced_is_called_that():
    for mechanism in (four_bar("BCD"), four_bar("", "elastic", section=SQUARE)):
        said = told(mechanism, step=TOO_LARGE, turns=5, force_step=True)
        assert (
            "larger than the stable" in said
            and "likely cause" in said
            and "--step auto, without --force-step" in said
        )


def double_pendulum() -> Mechanism:
    m = Mechanism("double pendulum", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link("upper", length=0.3, mass=1.0, angle=0.5)
    m.link("lower", length=0.3, mass=1.0, angle=-0.2)
    m.revolute("O", "ground.O", "upper.start")
    m.revolute("A", "upper.end", "lower.start")
    return m


def test_a_step_far_beyond_the_automatic_one_is_called_that():
    """Nothing drives a double pendulum out of its reach: where no stable step is known, the automatic one is
    what a step is held against.
    """
    said = told(double_pendulum(), step=0.5, duration=500.0)
    assert "automatic step of" in said and "--step auto" in said and "reach" not in said


# ----------------------------------------------------------------------------------------- contact too soft


def soft_pin(stiffness: float) -> Mechanism:
    m = gallery.slider_crank_loose_pin(clearance=1e-4)
    joint = m.joints["pin"]
    contact = dataclasses.replace(joint.contact, stiffness=stiffness)
    return dataclasses.replace(m, joints={**m.joints, "pin": dataclasses.replace(joint, contact=contact)})


@pytest.mark.parametrize("outputs", [20, 2000])
def test_a_contact_that_is_too_soft_is_called_that(outputs: int) -> None:
    """A stiffness in N/mm^1.5: the pin leaves its bearing smoothly, with any step."""
    result = simulate(soft_pin(SOFT), reference=False, outputs=outputs, turns=1)
    assert result.record.status == "diverged"
    for said in (diverged(result.record), *result.summary["warnings"][:1]):
        assert "too soft, or overloaded" in said and "the bearing's radius" in said
        assert f"is it in N/mm^1.5? {SOFT:.4g} N/mm^1.5 are" in said
        assert "half" not in said and "take a smaller step" not in said


def test_a_step_that_lets_a_pin_leap_is_no_soft_contact() -> None:
    result = simulate(four_bar("BCD"), reference=False, step=TOO_LARGE, turns=5, force_step=True)
    assert result.record.status == "diverged"
    assert "too soft" not in diverged(result.record)


@pytest.mark.parametrize(("factor", "unit"), [(1e-6, True), (1e-2, False), (1e2, False), (1e4, False)])
def test_a_stiffness_of_other_materials_is_cautioned_about(factor: float, unit: bool) -> None:
    joint = gallery.slider_crank_loose_pin(clearance=1e-4).joints["pin"]
    pair = joint.pair(Material(), Material())
    notes = [
        note for note in soft_pin(factor * pair.hertz_stiffness).check().notes if "stiffness given" in note
    ]
    assert len(notes) == (not 1e-3 < factor < 1e3)
    assert all(("N/mm^1.5" in note) == unit for note in notes)
