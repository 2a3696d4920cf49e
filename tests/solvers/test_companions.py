"""Companions: the same motion with displaced steps, beside a run that does not feel them; the step that they find, and what they call sensitive."""

from __future__ import annotations

import json
import math
import pickle
from functools import cache

import numpy as np
import pytest

import vfife
from support import TURN, four_bar, journal_in_bearing
from support import lanes as beside
from vfife.analysis.measured import Measured
from vfife.analysis.ranges import band, companion_records, ranged
from vfife.analysis.trust import trust
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError
from vfife.kernels.arrays import Layout
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh
from vfife.model.drivers import Harmonic
from vfife.model.mechanism import Mechanism
from vfife.report.trust import verdict
from vfife.result import Result
from vfife.solvers.companions import SENSITIVE, Gathering, Watch, displacements, lanes
from vfife.solvers.record import recorded_rows
from vfife.solvers.transient import run

ACCELERATION, FORCE = "follower.angular_acceleration.max", "C.force.max"
STEP = 2.5e-6  # s
REFERENCE = {"C": (29201.05, 65794.78), "BCD": (38153.31, 68842.16)}  # of tests/verification/test_reference_cases.py
ROUGH = Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2)


@cache
def simulated(clear: str = "BCD", **options: object) -> Result:
    return vfife.simulate(four_bar(clear), turns=2, reference=False, **options)  # type: ignore[arg-type]


@cache
def rough() -> Result:
    return vfife.simulate(four_bar("BCD", friction=ROUGH), turns=2, reference=False)


# ------------------------------------------------------------------------------------------------------------- the lanes


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_the_run_is_what_it_would_be_alone(count: int) -> None:
    assembly = assemble(four_bar("BCD"), STEP, duration=0.3 * TURN)
    alone, accompanied = run(assembly), run(assembly, companions=count)
    assert alone.companions is None
    assert np.array_equal(alone.rows, accompanied.rows)
    assert alone.final is not None and accompanied.final is not None and np.array_equal(alone.final, accompanied.final)


def test_companions_of_both_loops_are_the_same() -> None:
    assembly = assemble(journal_in_bearing(), 1e-6, duration=7e-4)
    one, other = (run(assembly, companions=2, loop=loop).companions for loop in ("generated", "data-driven"))  # type: ignore[arg-type]
    assert one is not None and other is not None
    assert np.array_equal(one.rows, other.rows)


def test_first_steps_divide_a_step() -> None:
    assert displacements(3).tolist() == [0.25, 0.5, 0.75]
    assert lanes(2, "generated").tolist() == [0.0, 1.0 / 3.0, 2.0 / 3.0, 0.0]  # a vector holds four
    assert lanes(2, "data-driven").tolist() == [0.0, 1.0 / 3.0, 2.0 / 3.0]
    assert len(lanes(7, "generated")) == 8


def test_a_displaced_journal_lands_elsewhere() -> None:
    """In free flight at 1 m/s step n of companion k is at (n + k/7) dt: where its first contact lands follows."""
    step, clearance = 3.1e-6, 5e-4
    m = journal_in_bearing(contact=LankaraniNikravesh(restitution=0.9), friction=Frictionless())
    record = run(assemble(m, step, duration=6e-4, force_step=True), companions=6)
    left = record.companions
    assert left is not None
    deepest = left.rows[-1, np.flatnonzero(left.kept == record.assembly.layout["contact_deepest"][0])[0]]
    every = np.array([record.block("contact_deepest")[-1, 0], *deepest])
    shares = np.arange(7) / 7.0
    steps = np.ceil(clearance / step - shares)
    coarse = (steps + shares) * step - clearance  # of a step; in eight parts the first of them beyond the wall
    parts = coarse - np.floor(coarse / (step / 8.0)) * step / 8.0
    assert every == pytest.approx(parts, abs=1e-12)


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_a_displaced_first_step_follows_what_is_prescribed(loop: str) -> None:
    """After it a body turned by a law of time is where the law has it at that part of a step, and turns as fast."""
    m = Mechanism("prescribed")
    m.point("O", 0.0, 0.0)
    m.link("rod", length=0.3, mass=1.0)
    m.revolute("O", "ground.O", "rod.start")
    m.drivers["rod"] = Harmonic(body="rod", amplitude=0.4, frequency=20.0)
    a = assemble(m, 1e-3, duration=0.01)
    runner = beside([a] * 4, loop, shares=[0.0, 0.25, 0.5, 0.75])
    runner.advance(1, 1)
    i = a.bodies["rod"].particles[0]
    t = np.array([0.0, 0.25, 0.5, 0.75]) * 1e-3
    swing = 2.0 * math.pi * 20.0
    assert runner.states[a.layout.row("particle_theta", i)] == pytest.approx(0.4 * np.sin(swing * t), abs=1e-7)
    assert runner.states[a.layout.row("particle_w", i)] == pytest.approx(0.4 * swing * np.cos(swing * t), rel=1e-5)


# --------------------------------------------------------------------------------------------------------------- ranges


@pytest.mark.parametrize("clear", REFERENCE)
def test_the_reference_lies_in_the_range(clear: str) -> None:
    result = simulated(clear)
    for name, truth in zip((ACCELERATION, FORCE), REFERENCE[clear], strict=True):
        one = result.measures[name]
        assert one.low - 0.005 * one <= truth <= one.high + 0.005 * one
    said = trust(result.record)
    assert said is not None and not said.sensitive


def test_more_friction_is_called_sensitive() -> None:
    """Its follower's acceleration, 48401 rad/s^2 by a reference at a thirtieth of the step, is nobody's to tell at any step worth taking."""
    result = rough()
    said = trust(result.record)
    assert said is not None and said.sensitive and said.apart > 0.05
    one = result.measures[ACCELERATION]
    assert one.low < 48401.0 < one.high
    assert said.parting is not None and said.parting.joint in "BCD" and 0.0 < said.parting.time < 2.0 * TURN
    sentence = verdict(result.summary)
    assert sentence.startswith("This run is sensitive") and f"in joint {said.parting.joint}" in sentence
    assert result.summary["warnings"][0] == sentence


def test_runs_do_part_where_they_are_said_to() -> None:
    """Two runs at other steps, which know nothing of companions, agree up to about there and not beyond."""
    record = rough().record
    assert record.companions is not None and record.companions.parting is not None
    parting, step = record.companions.parting.time, record.assembly.choice.step
    one, other = (run(assemble(four_bar("BCD", friction=ROUGH), size, turns=2, outputs=720)) for size in (step, 2.0 * step))
    forces = [np.sqrt(each.block("contact_force_squared_max")) for each in (one, other)]
    apart = np.abs(forces[0] - forces[1]).max(axis=1) / forces[0].max()
    assert 0.5 * parting < one.steps[np.argmax(apart > 0.05)] * step < 2.0 * parting


def test_a_companion_is_measured_as_a_run_is() -> None:
    """Where nothing displaces them, companions are the run: each measure of theirs is the run's own, to the bit."""
    result = simulated(companions=3, step=STEP)
    record = result.record
    assert record.companions is not None
    own = np.flatnonzero(np.isin(record.steps, record.companions.steps))
    columns = [int(np.flatnonzero(record.kept == row)[0]) for row in record.companions.kept]
    record.companions.rows[:] = record.rows[np.ix_(own, columns)][:, :, None]
    for name, one in ranged(record).items():
        assert one.low == one.high == one.value, name
    simulated.cache_clear()


def test_figures_have_a_band_over_the_last_turn() -> None:
    result = simulated()
    found = band(result.record, lambda record: record.block("body_alpha_max"))
    assert found is not None
    low, high = found
    own = result.record.block("body_alpha_max")[-721:]
    assert low.shape == high.shape == own.shape
    assert np.all((low <= own) & (own <= high)) and np.any(low < high)


def test_a_measure_is_a_number() -> None:
    one = Measured(2.0, 1.5, 2.25)
    assert (one.value, one.low, one.high, one.width) == (2.0, 1.5, 2.25, 0.75)
    assert one + 1.0 == 3.0 and math.sqrt(one) == math.sqrt(2.0) and f"{one:.1f}" == "2.0" and json.dumps(one) == "2.0"
    again = pickle.loads(pickle.dumps(one))
    assert (again, again.low, again.high) == (2.0, 1.5, 2.25)
    alone = Measured(3.0)
    assert alone.low == alone.high == 3.0


def test_what_is_kept_does_not_grow_with_the_run() -> None:
    long = vfife.simulate(four_bar("C"), turns=6, step="10 us", outputs=100, reference=False, companions=3).record.companions
    assert long is not None and len(long.steps) == 101
    assembly = assemble(four_bar("C"), 1e-5, turns=50, outputs=10)
    gathering = Gathering(assembly, recorded_rows(assembly), displacements(3))
    for first in range(0, 500, 10):
        gathering.take((first + np.arange(10)) * assembly.choice.outputs_every, np.zeros((10, len(gathering.recorded), 4)))
        assert len(gathering.parts) <= 3


def test_a_companion_that_is_lost_makes_a_run_sensitive() -> None:
    record = run(assemble(four_bar("C"), 1e-5, turns=1.0), companions=3)
    assert record.companions is not None
    record.companions.lost = (1,)
    said = trust(record)
    assert said is not None and said.sensitive and said.lost == 1
    assert len(list(companion_records(record))) == 2


# -------------------------------------------------------------------------------------------------------------- parting


def watched(forces: np.ndarray) -> float | None:
    """Time at which lanes with these forces, shape (outputs, lanes), part."""
    assembly = assemble(four_bar("C"), 1e-5, turns=1.0, outputs=len(forces) - 1)
    kept = recorded_rows(assembly)
    rows = np.zeros((len(forces), len(kept), forces.shape[1]))
    rows[:, np.flatnonzero(kept == Layout(assembly.topology)["contact_force_squared_max"][0])[0]] = forces**2
    watch = Watch(assembly, kept)
    found = [watch.look(np.arange(first, first + 5), rows[first : first + 5]) for first in range(0, len(rows), 5)]
    return next((one.time / assembly.choice.step for one in found if one is not None), None)


def test_a_peak_in_the_interval_beside_is_no_parting() -> None:
    forces = np.full((40, 2), 10.0)
    forces[12, 0] = forces[13, 1] = 30.0
    assert watched(forces) is None
    forces[12, 0] *= 1.0 - 0.9 * SENSITIVE
    assert watched(forces) is None


def test_a_peak_that_only_one_has_is_one() -> None:
    forces = np.full((40, 2), 10.0)
    forces[24, 1] = 30.0
    assert watched(forces) == 24.0


# ------------------------------------------------------------------------------------------------------ automatic steps


def test_case_c_stays_near_three_microseconds() -> None:
    choice = vfife.simulate(four_bar("BCD"), turns=2).record.assembly.choice
    assert choice.automatic and choice.tried == () and 2e-6 < choice.step < 4e-6


def test_a_step_is_halved_three_times_and_no_more() -> None:
    choice = rough().record.assembly.choice
    first = choice.tried[0][0]
    assert [step for step, _ in choice.tried] == pytest.approx([first, first / 2.0, first / 4.0]) and choice.step == pytest.approx(first / 8.0)
    assert all(apart is not None and apart > 0.005 for _, apart in choice.tried)
    assert "halved 3 times" in choice.culprit


def test_without_companions_a_step_is_as_fine_as_before() -> None:
    """Eighty steps in half a period of the contact, where with companions twenty are where a search begins."""
    alone, accompanied = simulated(companions=0), simulated()
    assert alone.record.companions is None and alone.measures[FORCE].width == 0.0
    assert alone.record.assembly.choice.step == pytest.approx(accompanied.record.assembly.choice.step / 4.0, rel=0.1)
    assert alone.summary["trust"] == {} and alone.summary["ranges"] == {}


def test_a_step_that_is_asked_for_is_taken() -> None:
    choice = simulated(step=1e-5).record.assembly.choice
    assert choice.step == 1e-5 and choice.tried == () and not choice.automatic


@pytest.mark.parametrize("wrong", [-1, 8, 1.5, "many", True])
def test_companions_that_cannot_be(wrong: object) -> None:
    with pytest.raises(ModelError, match="companions"):
        vfife.simulate(four_bar("C"), companions=wrong)  # type: ignore[arg-type]
