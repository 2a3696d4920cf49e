"""Companions: the same motion with other step sizes, beside a run that does not feel them; the step they
find, what they call sensitive.
"""

from __future__ import annotations

import dataclasses
import json
import math
import pickle
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import vfife
from support import TURN, four_bar, journal_in_bearing
from support import lanes as beside
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import StepChoice
from vfife.errors import ModelError
from vfife.kernels.arrays import Layout
from vfife.laws import Ambrosio, Frictionless
from vfife.measures.catalogue import PEAKS, measures
from vfife.measures.error_ranges import (
    band,
    companion_records,
    over_tries,
    own_ranges,
    ranged,
    spreads_after_parting,
)
from vfife.measures.extrapolation import VANISHING
from vfife.measures.trust import trust
from vfife.measures.turns import record_of_companion
from vfife.measures.values import Measured
from vfife.model.drivers import Harmonic
from vfife.model.mechanism import Mechanism
from vfife.report.trust import verdict
from vfife.simulation.result import Result
from vfife.solvers.companion_lanes import SeparateLanes, SynchronisedLanes
from vfife.solvers.companions import DEFAULT, SENSITIVE, CompanionRecorder, Parting, PartingWatch, step_counts
from vfife.solvers.record import lasting_rows, recorded_rows
from vfife.solvers.transient import run

ACCELERATION, FORCE = "follower.angular_acceleration.max", "C.force.max"
STEP = 2.5e-6  # s
REFERENCE = {
    "C": (29201.05, 65794.78),
    "BCD": (38153.31, 68842.16),
}  # of tests/verification/test_reference_cases.py
ROUGH = Ambrosio(coefficient=0.3, v0=1e-4, v1=1e-2)


@cache
def simulated(clear: str = "BCD", **options: object) -> Result:
    return vfife.simulate(four_bar(clear), turns=2, reference=False, **options)  # type: ignore[arg-type]


@cache
def rough() -> Result:
    return vfife.simulate(four_bar("BCD", friction=ROUGH), turns=2, reference=False)


# -------------------------------------------------------------------------------------------------- the lanes


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_the_run_is_what_it_would_be_alone(count: int) -> None:
    assembly = assemble(four_bar("BCD"), STEP, duration=0.3 * TURN)
    alone, accompanied = run(assembly), run(assembly, companions=count)
    assert alone.companions is None
    assert np.array_equal(alone.rows, accompanied.rows)
    assert (
        alone.final is not None
        and accompanied.final is not None
        and np.array_equal(alone.final, accompanied.final)
    )


def test_companions_of_both_loops_are_the_same() -> None:
    assembly = assemble(journal_in_bearing(), 1e-6, duration=7e-4)
    one, other = (run(assembly, companions=2, loop=loop).companions for loop in ("generated", "data-driven"))  # type: ignore[arg-type]
    assert one is not None and other is not None
    assert np.array_equal(one.rows, other.rows)


def choice(every: int, step: float = 1.0, stable: float = math.inf) -> StepChoice:
    return StepChoice(step, stable, "", False, (), None, every, 1)


@pytest.mark.parametrize(
    ("every", "companions", "expected"),
    [
        (20, 3, [14, 12, 10]),
        (20, 1, [10]),
        (20, 2, [14, 10]),
        (20, 7, [16, 15, 14, 13, 12, 11, 10]),
        (44, 3, [31, 26, 22]),
        (20, 0, []),
        (4, 3, [6, 3, 2]),
        (2, 3, [4, 3, 1]),
        (1, 3, [4, 3, 2]),
    ],
)
def test_companions_make_whole_numbers_of_steps_between_outputs(
    every: int, companions: int, expected: list[int]
) -> None:
    """A half to five sevenths of the run's; more where an interval has too few steps for that."""
    assert step_counts(choice(every), companions).tolist() == expected


def test_no_companion_has_an_unstable_step() -> None:
    """At 0.9 of the stable step all are finer than the run, at half of that one has the most
    that is taken.
    """
    assert step_counts(choice(20, 0.9, 1.0), 3).tolist() == [40, 34, 28]
    assert step_counts(choice(20, 0.45, 1.0), 3).tolist() == [14, 12, 10]
    assert step_counts(choice(20, 0.6, 1.0), 3).tolist() == [16, 15, 14]


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
@pytest.mark.parametrize("step", [2.5e-6, 1.25e-5])
def test_a_companion_is_a_run_with_its_step(loop: str, step: float) -> None:
    """Each has the bits of a run by itself with the same step and outputs; at 12.5 us they are finer than the
    run.
    """
    assembly = assemble(four_bar("BCD"), step, duration=0.2 * TURN, outputs=200, force_step=True)
    record = run(assembly, companions=3, loop=loop)  # type: ignore[arg-type]
    left = record.companions
    assert left is not None
    for k, count in enumerate(left.counts.tolist()):
        state = assembly.state.copy()
        size = step * assembly.choice.outputs_every / count
        state[assembly.layout["step"]] = size
        own = dataclasses.replace(assembly.choice, step=size, outputs_every=count)
        alone = run(dataclasses.replace(assembly, choice=own, state=state), loop=loop)  # type: ignore[arg-type]
        columns = [int(np.flatnonzero(alone.row_numbers == row)[0]) for row in left.row_numbers]
        assert np.array_equal(left.rows[:, :, k], alone.rows[:, columns])
        own, found = measures(alone), measures(record_of_companion(record, k))
        assert len(found) > 40 and {name: own[name] for name in found} == found


def test_calls_of_any_length_give_the_same_bits() -> None:
    """Cut inside and at the ends of output intervals; lanes wait for each other at each cut."""
    assembly = assemble(four_bar("BCD"), 2.5e-6, duration=0.1 * TURN)
    kept, counts = recorded_rows(assembly), np.array([20, *step_counts(assembly.choice, 3)])
    assert assembly.choice.outputs_every == 20
    whole, cut = (SynchronisedLanes(assembly, counts, kept, 16) for _ in range(2))
    separate = SeparateLanes(assembly, counts, kept, "data-driven")
    for one in (whole, cut, separate):
        one.advance(1, 1)
    every = whole.advance(20, 12)
    pieces = []
    for lengths in ((20,), (7, 13), (1, 1, 18), (19, 1), (20,), (3, 3, 3, 3, 8)):
        inside = 0
        for length in lengths:
            ends = inside + length == 20
            rows = cut.advance(length, 1, reset=inside == 0, record=ends)
            assert separate.advance(length, 1, reset=inside == 0, record=ends).shape == rows.shape
            inside += length
        pieces.append(rows)
    pieces.append(cut.advance(20, 6))
    separate.advance(20, 6)
    assert np.array_equal(np.concatenate(pieces), every)
    lasting = lasting_rows(assembly.layout)
    assert np.array_equal(cut.states[lasting], whole.states[lasting]) and np.array_equal(
        separate.states[lasting], whole.states[lasting]
    )


def test_a_run_has_three_companions_whatever_the_registers_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for width in (2, 4, 8):
        monkeypatch.setattr("vfife.compiler.runtime.native.widest", lambda width=width: width)
        left = vfife.simulate(four_bar("C"), turns=0.1, step=1e-5, reference=False).record.companions
        assert left is not None and len(left.counts) == DEFAULT == 3
        found.append(left.rows)
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])


@pytest.mark.parametrize("loop", ["generated", "data-driven"])
def test_a_displaced_first_step_follows_what_is_prescribed(loop: str) -> None:
    """After it a body turned by a law of time is where the law has it at that part of a step, and turns as
    fast.
    """
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
    assert runner.states[a.layout.row("particle_theta", i)] == pytest.approx(
        0.4 * np.sin(swing * t), abs=1e-7
    )
    assert runner.states[a.layout.row("particle_w", i)] == pytest.approx(
        0.4 * swing * np.cos(swing * t), rel=1e-5
    )


# ----------------------------------------------------------------------------------------------------- ranges


@pytest.mark.parametrize("clear", REFERENCE)
def test_the_reference_lies_in_the_range(clear: str) -> None:
    result = simulated(clear)
    for name, truth in zip((ACCELERATION, FORCE), REFERENCE[clear], strict=True):
        one = result.measures[name]
        assert one.low - 0.005 * one <= truth <= one.high + 0.005 * one
    said = trust(result.record)
    assert said is not None and not said.sensitive


def test_more_friction_is_called_sensitive() -> None:
    """Its follower's acceleration, 48401 rad/s^2 by a reference at a thirtieth of the step, is nobody's to
    tell at any step worth taking.
    """
    result = rough()
    said = trust(result.record)
    assert said is not None and said.sensitive and said.apart > 0.05
    one = result.measures[ACCELERATION]
    assert one.low < 48401.0 < one.high
    assert said.parting is not None and said.parting.joint in "BCD" and 0.0 < said.parting.time < 2.0 * TURN
    sentence = verdict(result.summary)
    assert sentence.startswith("This run is sensitive") and f"(joint {said.parting.joint})" in sentence
    assert result.summary["warnings"][0] == sentence
    assert ("Leave the step out" in sentence) != result.summary["trust"]["automatic"]
    for automatic in (False, True):  # only an automatic step has tries, and their values in its ranges
        summary = result.summary | {"trust": result.summary["trust"] | {"automatic": automatic}}
        assert ("Leave the step out" in verdict(summary)) is not automatic


def test_case_c_without_friction_is_told_with_its_error() -> None:
    """With companions of one step it was told as 35,810 rad/s^2 within 0.04 %; a step of 0.1 us gives 39,501,
    and ever finer ones hold to that.
    """
    one = vfife.simulate(four_bar("BCD", friction=Frictionless()), turns=2, reference=False).measures[
        ACCELERATION
    ]
    assert one.low < 39500.7 < one.high and one.width < 0.02 * one


def rejected(result: Result) -> dict[str, tuple[float, float]]:
    """Ranges of the values at the step sizes of the try before, by a run of its own."""
    choice = result.record.assembly.choice
    before = assemble(four_bar("BCD", friction=ROUGH), choice.tried[-1][0], turns=2, outputs=720)
    record = run(before, companions=3)
    return {name: (one.low, one.high) for name, one in own_ranges(record).items()}


def test_the_range_of_a_step_that_was_given_up_is_kept(tmp_path: Path) -> None:
    result = rough()
    left = result.record.companions
    assert left is not None and left.earlier == rejected(result)
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite").record.companions
    assert again is not None and again.earlier == left.earlier and again.tries == left.tries


def test_the_ranges_of_a_sensitive_run_cover_all_its_tries() -> None:
    """No step brings them together, so that the values of a coarser one count as much as its own."""
    result = rough()
    left = result.record.companions
    assert left is not None and len(result.record.assembly.choice.tried) > 1
    judgement = trust(result.record)
    assert judgement is not None and judgement.sensitive
    wider = 0
    for name, (low, high) in left.tries.items():
        last_low, last_high = left.earlier[name]
        assert low <= last_low and last_high <= high
        wider += high - low > last_high - last_low
        measured = result.measures[name]
        assert name.endswith(VANISHING) or (measured.low <= low and high <= measured.high)
    assert wider > 10


def test_a_run_that_left_its_estimated_range_tells_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """An estimate at twice the step that does not hold what comes out has failed, and with it what the run
    tells of itself.
    """
    record = simulated(companions=3, step=STEP).record
    left = record.companions
    assert left is not None
    alone, calm = ranged(record)[FORCE], trust(record)
    assert calm is not None and not calm.sensitive
    monkeypatch.setattr(left, "earlier", {FORCE: (alone - 1.0, alone + 1.0)})
    assert (ranged(record)[FORCE].low, ranged(record)[FORCE].high) == (alone.low, alone.high)
    below = 0.9 * alone
    monkeypatch.setattr(left, "earlier", {FORCE: (below, below + 1.0)})
    both, said = ranged(record)[FORCE], trust(record)
    assert (
        both.low < below
        and both.high > alone.high
        and said is not None
        and said.sensitive
        and said.measure == FORCE
    )
    # A range that is as wide as the distance from it holds the value: convergence of first order.
    monkeypatch.setattr(left, "earlier", {FORCE: (below, below + 0.06 * alone)})
    assert ranged(record)[FORCE].low == alone.low


def test_runs_do_part_where_they_are_said_to() -> None:
    """Two runs at other steps, which know nothing of companions, agree up to about there and not beyond."""
    record = rough().record
    assert record.companions is not None and record.companions.parting is not None
    parting, step = record.companions.parting.time, record.assembly.choice.step
    one, other = (
        run(assemble(four_bar("BCD", friction=ROUGH), size, turns=2, outputs=720))
        for size in (step, 2.0 * step)
    )
    forces = [np.sqrt(each.block("contact_force_squared_max")) for each in (one, other)]
    apart = np.abs(forces[0] - forces[1]).max(axis=1) / forces[0].max()
    assert 0.5 * parting < one.steps[np.argmax(apart > 0.05)] * step < 2.0 * parting


def test_a_companion_is_measured_as_a_run_is() -> None:
    """Where they have the run's rows and step, companions are the run: each measure of theirs is the run's
    own, to the bit.
    """
    result = simulated(companions=3, step=STEP)
    record = result.record
    assert record.companions is not None
    own = np.flatnonzero(np.isin(record.steps, record.companions.steps))
    columns = [int(np.flatnonzero(record.row_numbers == row)[0]) for row in record.companions.row_numbers]
    record.companions.rows[:] = record.rows[np.ix_(own, columns)][:, :, None]
    record.companions.counts[:] = record.assembly.choice.outputs_every
    for name, one in ranged(record).items():
        # The share of the first steps of contacts goes to zero with the step: its range always contains zero.
        low = 0.0 if name.endswith(".share.impact") else one.value
        assert (one.low, one.high) == (low, one.value), name
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
    assert (
        one + 1.0 == 3.0
        and math.sqrt(one) == math.sqrt(2.0)
        and f"{one:.1f}" == "2.0"
        and json.dumps(one) == "2.0"
    )
    again = pickle.loads(pickle.dumps(one))
    assert (again, again.low, again.high) == (2.0, 1.5, 2.25)
    alone = Measured(3.0)
    assert alone.low == alone.high == 3.0


def test_what_is_kept_does_not_grow_with_the_run() -> None:
    long = vfife.simulate(
        four_bar("C"), turns=6, step="10 us", outputs=100, reference=False, companions=3
    ).record.companions
    assert long is not None and len(long.steps) == 101
    assembly = assemble(four_bar("C"), 1e-5, turns=50, outputs=10)
    recorder = CompanionRecorder(assembly, recorded_rows(assembly), step_counts(assembly.choice, 3))
    for first in range(0, 500, 10):
        recorder.take(
            (first + np.arange(10)) * assembly.choice.outputs_every, np.zeros((10, len(recorder.recorded), 4))
        )
        assert len(recorder.parts) <= 3


def test_a_companion_that_is_lost_makes_a_run_sensitive() -> None:
    record = run(assemble(four_bar("C"), 1e-5, turns=1.0), companions=3)
    assert record.companions is not None
    record.companions.divergent = (1,)
    said = trust(record)
    assert said is not None and said.sensitive and said.lost == 1
    assert len(list(companion_records(record))) == 2


@pytest.mark.parametrize(("height", "counts"), [(0.97, True), (0.5, False)])
def test_peaks_that_scatter_after_a_parting_count_where_they_may_be_the_largest(
    height: float, counts: bool
) -> None:
    """All lanes agree on the largest penetration, which is before they part; later peaks
    differ by 2 % of it.
    """
    record = run(assemble(four_bar("C"), 5e-6, turns=1.0), companions=3)
    left, row = record.companions, record.assembly.layout["contact_penetration_max"][0]
    assert left is not None
    lanes = [
        record.rows[:, record.row_numbers == row],
        *(left.rows[:, left.row_numbers == row, k] for k in range(3)),
    ]
    largest, middle = max(float(one.max()) for one in lanes), len(record.steps) // 2
    before = [one.copy() for one in lanes]
    shares = (height, height - 0.02, height, height - 0.01)
    for share, one, peaks in zip(shares, lanes, before, strict=True):
        one[:] = np.minimum(peaks, 0.4 * largest)
        one[10], one[middle + 10] = largest, share * largest
    record.rows[:, record.row_numbers == row] = lanes[0]
    for k in range(3):
        left.rows[:, left.row_numbers == row, k] = lanes[k + 1]
    left.parting = Parting(float(record.steps[middle]) * record.assembly.choice.step, "C")
    found = spreads_after_parting(record, over_tries(record))
    assert found.get("C.penetration.max", 0.0) == pytest.approx(0.02 if counts else 0.0, abs=1e-9)
    # Four values that scatter over 2 % have an error of twice their width, beyond the largest of them.
    high = ranged(record, groups=PEAKS)["C.penetration.max"].high / largest
    assert high == pytest.approx(height + 2.0 * 0.02 if counts else 1.0, abs=2e-4)


# ---------------------------------------------------------------------------------------------------- parting


def watched(forces: np.ndarray) -> float | None:
    """Time at which lanes with these forces, shape (outputs, lanes), part."""
    assembly = assemble(four_bar("C"), 1e-5, turns=1.0, outputs=len(forces) - 1)
    kept = recorded_rows(assembly)
    rows = np.zeros((len(forces), len(kept), forces.shape[1]))
    rows[:, np.flatnonzero(kept == Layout(assembly.topology)["contact_force_squared_max"][0])[0]] = forces**2
    watch = PartingWatch(assembly, kept)
    found = [
        watch.parting(np.arange(first, first + 5), rows[first : first + 5])
        for first in range(0, len(rows), 5)
    ]
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


# ------------------------------------------------------------------------------------------------------
# automatic steps


def test_case_c_stays_near_one_and_a_half_microseconds() -> None:
    choice = vfife.simulate(four_bar("BCD"), turns=2).record.assembly.choice
    assert choice.automatic and choice.tried == () and 1e-6 < choice.step < 2e-6


def test_a_step_is_halved_twice_and_no_more() -> None:
    choice = rough().record.assembly.choice
    first = choice.tried[0][0]
    assert [step for step, _ in choice.tried] == pytest.approx(
        [first, first / 2.0]
    ) and choice.step == pytest.approx(first / 4.0)
    assert all(apart is not None and apart > 0.005 for _, apart in choice.tried)
    assert "halved 2 times" in choice.culprit


def test_without_companions_a_step_is_as_fine_as_before() -> None:
    """Eighty steps in half a period of the contact; a search with companions begins with forty, and twenty of
    the coarsest companion.
    """
    alone, accompanied = simulated(companions=0), simulated()
    assert alone.record.companions is None and alone.measures[FORCE].width == 0.0
    assert alone.record.assembly.choice.step == pytest.approx(
        accompanied.record.assembly.choice.step / 2.0, rel=0.1
    )
    assert alone.summary["trust"] == {} and alone.summary["ranges"] == {}


def test_a_step_that_is_asked_for_is_taken() -> None:
    choice = simulated(step=1e-5).record.assembly.choice
    assert choice.step == 1e-5 and choice.tried == () and not choice.automatic


@pytest.mark.parametrize("wrong", [-1, 8, 1.5, "many", True])
def test_companions_that_cannot_be(wrong: object) -> None:
    with pytest.raises(ModelError, match="companions"):
        vfife.simulate(four_bar("C"), companions=wrong)  # type: ignore[arg-type]
