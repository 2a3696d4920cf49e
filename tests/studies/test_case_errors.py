"""Numerical errors of cases: a sample repeated with another step, kept in the study file, and told with
every measure.
"""

import dataclasses
import hashlib
import json
import math
import sqlite3

import numpy as np
import pytest
from typer.testing import CliRunner

import vfife
from vfife.cli.app import app
from vfife.measures.extrapolation import LEAST_ERROR
from vfife.modelfile import load
from vfife.numerics.outward import UP
from vfife.plots.study import bar_words
from vfife.report.amounts import quantity
from vfife.report.case_errors import error_words
from vfife.report.pages import study_page
from vfife.results.case_errors import (
    ErrorEstimate,
    RepeatedCase,
    SampleErrors,
    error_over_change,
    sample_of,
    sample_size,
)
from vfife.results.study import Study
from vfife.store.studyfile import REPEATS
from vfife.studies.engine.cases import run_cases
from vfife.studies.engine.outcome import Outcome
from vfife.studies.engine.study_engine import STEP, Engine, description_of, open_study
from vfife.studies.methods.tolerance import failing_share, spreads
from vfife.studies.spec.limits import Bound, quantile
from vfife.studies.spec.plan import CaseSpec
from vfife.studies.spec.study_file import StudyTables, plain_tables

CASE_B, IDEAL = "examples/four_bar_case_b.toml", "examples/four_bar_ideal.toml"
SIZE = 1e-6


def slope(clearance: float) -> float:
    """Error of a case for a step of a microsecond (N)."""
    return 100.0 + 1e6 * clearance


class Linear:
    """Stands for the engine: C.force.max = 1e9 c + k h^order with the step h (µs) and k = 100 + 1e6 c, which
    is below 1 % of it; it counts what it is asked for.
    """

    size, interval = 1e9, 3

    def __init__(
        self, order: int = 1, coarsest: float = math.inf, finest: float = 0.0, stops: float = math.inf
    ) -> None:
        self.order, self.coarsest, self.finest, self.stops = order, coarsest, finest, stops
        self.repeated: list[dict] = []

    def __call__(self, base, numbers, wanted, *, workers, lanes, stop):
        for k, one in enumerate(numbers):
            size = one.get(STEP, SIZE)
            if STEP in one:
                if len(self.repeated) >= self.stops:
                    raise KeyboardInterrupt
                self.repeated.append(dict(one))
                if not self.finest < size < self.coarsest:
                    yield k, Outcome(status="failed", reason="a step too large or too small")
                    continue
            value = self.value(one["joint.C.clearance"], 1e6 * size)
            yield (
                k,
                Outcome(
                    {"C.force.max": value, "C.impacts": 3.0},
                    2,
                    None,
                    "complete",
                    None,
                    size,
                    2 * self.interval * 720,
                ),
            )

    def value(self, clearance: float, step: float) -> float:
        """C.force.max (N) of a case with a step (µs)."""
        return self.size * clearance + slope(clearance) * step**self.order


class Coarse(Linear):
    """The step changes measures by 5 to 10 %, but they converge."""

    size = 1e7


class Scattering(Linear):
    """A motion that does not repeat: each step gives another value, of a deviation of 3 %."""

    interval = 60

    def value(self, clearance: float, step: float) -> float:
        seed = int.from_bytes(hashlib.blake2b(f"{clearance:.12g} {step:.6g}".encode()).digest()[:8], "big")
        return self.size * clearance * (1.0 + 0.03 * np.random.default_rng(seed).normal())


class Agreeing(Scattering):
    """A motion that scatters, whose values at three steps agree by chance: that of the case, 1.5 times and
    twice it.
    """

    def value(self, clearance: float, step: float) -> float:
        agrees = min(abs(step - ratio) for ratio in (1.0, 1.5, 2.0)) < 1e-6
        mean, scattered = self.size * clearance, super().value(clearance, step)
        return mean * (1.0 + 1e-4 * step) if agrees else mean * (1.03 if scattered > mean else 0.97)


def plan_of(count: int, model: str = CASE_B):
    raw = plain_tables({
        "measures": ["C.force.max", "C.impacts"], "turns": 2, "method": "random", "count": count,
        "vary": {"play": {"path": "joint.C.clearance", "from": 1e-4, "to": 3e-4}},
    })  # fmt: skip
    return StudyTables(raw, "test", base=load(model), name="s").plan()


def made(path, count: int, runner, contacts: bool = True) -> Study:
    plan = plan_of(count)
    base = plan.base
    with open_study(path, description_of(plan), plan.numbers()) as file:
        engine = Engine(file, base, runner=runner)
        assert engine.run()
        engine.base = base if contacts else load(IDEAL)
        engine.repeat_sample()
        return engine.study()


def test_the_error_over_the_change_follows_from_the_order() -> None:
    """First order: err(h) = (y(1.5 h) - y(h)) / 0.5. It is never less than the change, which a higher order
    would have it.
    """
    assert error_over_change(1.5, 1) == pytest.approx(2.0) and error_over_change(1.5, 2) == 1.0
    assert error_over_change(2.0 / 3.0, 1) == pytest.approx(3.0) and error_over_change(
        2.0 / 3.0, 2
    ) == pytest.approx(1.8)


@pytest.mark.parametrize("count, size", [(3, 3), (20, 20), (50, 20), (2000, 20), (8192, 82)])
def test_so_many_cases_are_repeated(count, size) -> None:
    assert sample_size(count) == size


@pytest.mark.parametrize("contacts", [True, False])
def test_the_error_of_a_method_of_known_order_is_found(contacts, tmp_path) -> None:
    """Of first order with contacts, and of second order without, where the change is the larger one."""
    order = 1 if contacts else 2
    found = made(tmp_path / "a.study", 30, engine := Linear(order), contacts)
    assert len(engine.repeated) == 20 and len({one["joint.C.clearance"] for one in engine.repeated}) == 20
    one = found.errors["C.force.max"]
    assert (
        one.count == 20 and one.failed == 0 and one.step_ratio == pytest.approx(1.5)
    )  # 3 steps between two outputs, then 2
    over = (
        1.0 if contacts else 1.5**2 - 1.0
    )  # the error, and the change, which is larger than the error by the order 2
    truth = np.sort([over * slope(case["joint.C.clearance"]) for case in engine.repeated])
    assert [one.typical, one.rms] == pytest.approx([np.median(truth), np.sqrt(np.mean(truth**2))], rel=1e-6)
    # With Roache's factor of safety, and not below what other cases of the sample have.
    least, most = (1.25, 2.0) if contacts else (1.0, 1.0)
    assert least * truth[-1] <= one.most * (1.0 + 1e-6) and one.most <= most * truth[-1] * (1.0 + 1e-6)
    assert found.errors["C.impacts"].most == (1.0 if contacts else 0.0)
    assert found.repeats[sample_of(found.cases, found.outcomes)[0].number]["step"] == pytest.approx(
        1.5 * SIZE
    )


def test_a_study_that_grew_has_the_sample_of_one_made_at_once(tmp_path) -> None:
    """What was repeated of the smaller one and is in no sample of the larger one does not count."""
    made(tmp_path / "a.study", 25, Linear())
    grown = made(tmp_path / "a.study", 60, engine := Linear())
    once = made(tmp_path / "b.study", 60, Linear())
    assert grown.errors == once.errors and 0 < len(engine.repeated) < 20 < len(grown.repeats)
    made(tmp_path / "c.study", 2, Linear())
    assert made(tmp_path / "c.study", 60, Linear()).errors == once.errors
    known = {one.hash for one in sample_of(once.cases, once.outcomes)}
    assert known == {one.hash for one in sample_of(grown.cases, grown.outcomes)} and len(known) == 20


def test_a_sample_goes_on_where_it_was_broken_off(tmp_path) -> None:
    """Nothing is repeated twice, and what is kept has the same bits."""
    first, second = Linear(stops=7), Linear()
    part = made(tmp_path / "a.study", 30, first)
    assert len(first.repeated) == 7 == part.errors["C.force.max"].count and part.status == "complete"
    whole = made(tmp_path / "a.study", 30, second)
    assert len(second.repeated) == 13
    once = made(tmp_path / "b.study", 30, Linear())
    assert whole.repeats == once.repeats and whole.errors == once.errors
    made(tmp_path / "a.study", 30, third := Linear())
    assert third.repeated == []


def test_a_case_that_fails_with_a_coarser_step_is_repeated_with_a_finer_one(tmp_path) -> None:
    found = made(tmp_path / "a.study", 20, engine := Linear(coarsest=1.1 * SIZE))
    assert len(engine.repeated) == 40
    one = found.errors["C.force.max"]
    assert (
        one.count == 20
        and one.step_ratio == pytest.approx(0.75)
        and one.most
        >= 1.25 * (1.0 - 1e-6) * max(slope(each["joint.C.clearance"]) for each in engine.repeated)
    )
    none = made(tmp_path / "b.study", 20, Linear(coarsest=1.1 * SIZE, finest=0.9 * SIZE))
    assert none.errors == {} and len(none.repeats) == 20
    some = made(tmp_path / "c.study", 20, Sometimes())
    assert (
        some.errors["C.force.max"].count + some.errors["C.force.max"].failed == 20
        and some.errors["C.force.max"].failed == 10
    )
    assert "10 more gave no value" in some.errors["C.force.max"].words


class Sometimes(Linear):
    """Every second repetition fails with any step."""

    def __call__(self, base, numbers, wanted, **more):
        for k, outcome in super().__call__(base, numbers, wanted, **more):
            bad = (
                STEP in numbers[k]
                and sorted({one["joint.C.clearance"] for one in self.repeated + list(numbers)}).index(
                    numbers[k]["joint.C.clearance"]
                )
                % 2
            )
            yield k, Outcome(status="failed", reason="no") if bad else outcome


def test_a_file_without_repetitions_is_read_and_gets_them_later(tmp_path) -> None:
    """As 0.2 wrote it, without the table and without a tally."""
    path = tmp_path / "a.study"
    made(path, 5, Linear())
    with sqlite3.connect(path) as connection:
        connection.execute("DROP TABLE repeats")
        connection.execute("DELETE FROM meta WHERE key IN ('repeats', 'tally')")
        connection.execute("PRAGMA user_version = 1")
    connection.close()
    former = Study.open(path)
    assert former.errors == {} and former.data["C.force.max"].attrs["numerical_error"] == "not estimated"
    assert (
        "not estimated, because no case was repeated" in invoke("study", "show", str(path))
        and json.loads(invoke("study", "show", str(path), "--json"))["errors"] is None
    )
    assert "Limits cover sampling alone" in invoke("study", "tolerance", str(path))
    assert made(path, 5, Linear()).errors["C.force.max"].count == 5


def invoke(*args: str) -> str:
    result = CliRunner().invoke(app, list(args))
    assert result.exit_code == 0, result.output
    return result.output


def test_limits_of_quantiles_and_shares_hold_the_numerical_error(tmp_path) -> None:
    """They are those of the sample, and so much wider as cases are not known."""
    found = made(tmp_path / "a.study", 60, Linear())
    error = found.errors["C.force.max"]
    bare = Study(found.path, found.meta, found.cases, found.outcomes)
    shares = (0.05, 0.5, 0.9)
    bound = Bound("C.force.max", high=float(np.median(found.values("C.force.max"))))
    wide, narrow = spreads(found, (bound,), shares)[0], spreads(bare, (bound,), shares)[0]
    for share in shares:
        one, other = wide.quantiles[share], narrow.quantiles[share]
        assert one.value == other.value == quantile(found.values("C.force.max"), share).value
        assert other.low - one.low == pytest.approx(error.at_quantile(share)) or math.isinf(one.low)
        assert one.high - other.high == pytest.approx(error.at_quantile(share)) or math.isinf(one.high)
    assert wide.numerical == error and narrow.numerical is None
    assert (
        narrow.average.low - wide.average.low == pytest.approx(error.rms) and wide.average.value == wide.mean
    )
    half = 2.000995 * narrow.deviation / math.sqrt(60)  # Student's t of 59 degrees of freedom
    assert narrow.average.high - narrow.mean == pytest.approx(half, rel=1e-5)
    assert wide.failing.value == narrow.failing.value == 0.5
    assert wide.failing.low <= narrow.failing.low and wide.failing.high >= narrow.failing.high


def test_machines_near_their_limit_count_to_both_sides() -> None:
    error = ErrorEstimate(20, 0.5, 0.5, 0.5, 1.5)
    values, bound = [0.0, 1.0, 1.4, 1.6, 2.0, 9.0, math.nan], Bound("m", high=1.5)
    exact, wide = failing_share(values, bound, None, 0.95), failing_share(values, bound, error, 0.95)
    assert exact.value == wide.value == 4.0 / 7.0 and wide.low < exact.low and wide.high > exact.high
    assert [bound.fails(value, 0.3) for value in values] == [False, False, False, False, True, True, True]
    assert [bound.fails(value, -0.3) for value in values] == [False, False, True, True, True, True, True]
    band = Bound("m", low=1.0, high=1.1)
    assert (
        not band.fails(1.2, 0.3) and band.fails(2.0, 0.3) and band.fails(0.5, 0.3) and band.fails(1.05, -0.3)
    )


def test_quantiles_move_by_no_more_than_is_said() -> None:
    """Errors of cases, alike or drawn: in the root mean square over all shares quantiles move by less than
    cases do.
    """
    draw = np.random.default_rng(3)
    values = np.sort(draw.normal(size=20_000))
    shares = np.linspace(0.01, 0.99, 99)
    for errors in (
        np.full(20_000, 0.3),
        draw.normal(size=20_000),
        0.2 * np.abs(values),
        np.where(values > 1.0, 2.0, 0.0),
    ):
        moved = np.abs(np.quantile(values + errors, shares) - np.quantile(values, shares))
        one = ErrorEstimate(
            20_000,
            float(np.median(np.abs(errors))),
            float(np.sqrt(np.mean(errors**2))),
            float(np.abs(errors).max()),
            1.5,
        )
        assert np.sqrt(np.mean(moved**2)) <= one.rms * 1.01
        assert (moved <= np.array([one.at_quantile(share) for share in shares.tolist()]) * 1.01).all()
    assert (
        ErrorEstimate(3, 1.0, 1.0, 9.0, 1.5).at_quantile(0.75) == 2.0
        and ErrorEstimate(3, 1.0, 1.0, 2.0, 1.5).at_quantile(0.995) == 2.0
    )


def held(study: Study, steps: np.ndarray) -> np.ndarray:
    """Return whether each case lies within the largest error of its values at other steps (µs)."""
    truth = [[Scattering().value(case.numbers["joint.C.clearance"], h) for h in steps] for case in study.done]
    return np.abs(np.array(truth) - study.values("C.force.max")[:, None]) <= study.errors["C.force.max"].most


@pytest.mark.parametrize("count", [1, 3, 6])
def test_the_largest_error_of_a_motion_that_scatters_holds(count, tmp_path) -> None:
    """One change alone, which may be small by chance, does not hold in studies of few cases."""
    steps, new, former = np.array([1.0 / 3.0, 0.2, 0.7, 1.1, 1.7]), [], []
    for seed in range(60):
        base = plan_of(count)
        raw = {**base.raw, "seed": seed}
        plan = StudyTables(raw, "test", base=load(CASE_B), name="s").plan()
        with open_study(tmp_path / f"{seed}.study", description_of(plan), plan.numbers()) as file:
            engine = Engine(file, plan.base, runner=Scattering())
            assert engine.run() and engine.repeat_sample()
            found = engine.study()
        new.append(held(found, steps).mean())
        first = Study(None, found.meta, found.cases, found.outcomes, found.repeats)
        change = [
            abs(found.repeats[k]["measures"]["C.force.max"] - found.outcomes[k]["measures"]["C.force.max"])
            for k in range(count)
        ]
        most = 2.0 * max(change)
        assert first.errors["C.force.max"].most >= most
        truth = [
            [Scattering().value(case.numbers["joint.C.clearance"], h) for h in steps] for case in found.done
        ]
        former.append((np.abs(np.array(truth) - found.values("C.force.max")[:, None]) <= most).mean())
    assert np.mean(new) > 0.95 and np.mean(new) > np.mean(former)
    assert count > 1 or np.mean(former) < 0.85


def test_a_sensitive_sample_is_repeated_with_further_steps(tmp_path) -> None:
    """Six values of each case, as there are few cases of which the largest error is known; every answer says
    so.
    """
    found = made(tmp_path / "a.study", 3, engine := Scattering())
    assert len(engine.repeated) == 3 * 5 and found.sensitive == (3, 3)
    assert all(len(trials) == 4 for trials in found.step_trials.values())
    one = found.errors["C.force.max"]
    assert one.sensitive == 3 and one.steps == 6 and one.most > 2.0 * one.typical
    bars = found.error_bars("C.force.max")
    assert bars.max() == one.most and bars.shape == (3,) and len(set(bars)) == 3, "each case has its own"
    again = made(tmp_path / "a.study", 3, second := Scattering())
    assert second.repeated == [] and again.errors == found.errors
    shown = " ".join(invoke("study", "show", str(tmp_path / "a.study")).split())
    assert "3 of 3 sampled cases depend on the step" in shown and "6 steps; 3 sensitive" in shown
    number, names = next(iter(found.sensitive_measures.items()))
    assert len(found.sensitive_measures) == 3 and f"(cases 0, 1, 2; case {number} in {names[0]})" in shown
    told = json.loads(invoke("study", "show", str(tmp_path / "a.study"), "--json"))
    assert told["sensitive"] == {"cases": 3, "sample": 3, "numbers": [0, 1, 2]}
    assert told["errors"]["C.force.max"]["sensitive"] == 3
    assert found.data["C.force.max"].attrs["sensitive_cases"] == 3
    assert "3 of 3 sampled cases are sensitive to the step" in bar_words(found)
    assert "3 of 3 sampled cases depend on the step" in study_page(found, {})


def test_a_table_of_cases_has_the_largest_error_beside_each_measure(tmp_path) -> None:
    """Its own of a case of the sample, that of the sample of any other; nothing without an estimate."""
    found = made(tmp_path / "a.study", 3, Scattering())
    table = {column.name: column for column in found.table_columns()}
    assert list(table).index("C.force.max.error") == list(table).index("C.force.max") + 1
    errors = table["C.force.max.error"]
    assert errors.unit == "N" and errors.values == found.error_bars("C.force.max").tolist()
    repeats = {number: found.repeats[number] for number in (0, 1)}
    less = Study(None, found.meta, found.cases, found.outcomes, repeats, found.step_trials)
    bounds = {column.name: column for column in less.table_columns()}["C.force.max.error"].values
    assert bounds[2] == max(bounds) == less.errors["C.force.max"].most and bounds[0] != bounds[1]
    bare = Study(None, found.meta, found.cases, found.outcomes)
    columns = {column.name: column for column in bare.table_columns()}
    assert columns["C.force.max.error"].values == [None] * 3
    assert found.to_dataframe()["C.force.max.error"].tolist() == errors.values


@pytest.mark.parametrize("count", [1, 3])
def test_three_values_of_few_cases_that_agree_by_chance_do_not_hide_a_scatter(count, tmp_path) -> None:
    steps = np.array([1.0 / 3.0, 0.2, 0.7, 1.1, 1.7])
    for k in range(4):
        plan = StudyTables({**plan_of(count).raw, "seed": k}, "test", base=load(CASE_B), name="s").plan()
        with open_study(tmp_path / f"{k}.study", description_of(plan), plan.numbers()) as file:
            engine = Engine(file, plan.base, runner=Agreeing())
            assert engine.run() and engine.repeat_sample()
            found = engine.study()
        truth = [
            [Agreeing().value(case.numbers["joint.C.clearance"], h) for h in steps] for case in found.done
        ]
        misses = np.abs(np.array(truth) - found.values("C.force.max")[:, None])
        assert found.errors["C.force.max"].steps == 6 and found.sensitive[0] >= 1
        assert (misses <= found.errors["C.force.max"].most).all()


def test_few_cases_whose_values_agree_have_the_least_error_of_a_range(tmp_path) -> None:
    """Extremes are taken at whole steps: no error is told below that of the ranges of runs."""

    class Constant(Linear):
        def value(self, clearance: float, step: float) -> float:
            return self.size * clearance

    found = made(tmp_path / "a.study", 1, engine := Constant())
    assert len(engine.repeated) == 3, "four values, as of a run and its companions"
    assert found.errors["C.force.max"].most == LEAST_ERROR * found.values("C.force.max")[0]
    assert found.errors["C.force.max"].typical == 0.0
    floor = found.errors["C.force.max"].floor
    assert floor == LEAST_ERROR * found.values("C.force.max")[0]
    assert f"typically below {quantity(floor, 'N', UP)}" in error_words(found.errors["C.force.max"], "N")
    assert found.errors["C.impacts"].most == 1.0


def test_a_sensitive_case_has_the_least_error_of_all_others() -> None:
    """A measure may agree by chance, or be taken at the same whole step, where another one scatters."""
    steps = ((1.0, 5.0), (1.4, 8.0), (1.7, 4.0), (2.0, 7.0))
    values = {"F.force.max": 5800.0, "F.impacts": 3.0}
    outcomes = [{"step": step, "measures": {**values, "F.torque.max": torque}} for step, torque in steps]
    case = RepeatedCase(0, outcomes[0], tuple(outcomes[1:]), {**values, "F.torque.max": 8.0})
    assert case.sensitive
    bounds = {name: error.bound for name in outcomes[0]["measures"] if (error := case.error(name, 1))}
    assert bounds["F.force.max"] == pytest.approx(0.58) and bounds["F.impacts"] == 1.0
    assert bounds["F.torque.max"] > 3.0 * 4.0


def test_two_values_that_agree_by_chance_have_the_error_of_the_sample() -> None:
    """The change of one case is no error of it where other cases change a hundred times as much."""
    sample = []
    for number, change in enumerate((1e-6, 4.0, 5.0, 3.0)):
        ends = [
            {"step": step, "measures": {"F.force.max": force}}
            for step, force in ((1.0, 1e3), (1.5, 1e3 + change))
        ]
        sample.append(RepeatedCase(number, ends[0], (ends[1],), {"F.force.max": 1e3}))
    alone, *_ = SampleErrors(sample[:1], ["F.force.max"], {REPEATS: {"order": 1}}).bounds("F.force.max", [0])
    bounds = SampleErrors(sample, ["F.force.max"], {REPEATS: {"order": 1}}).bounds("F.force.max", range(4))
    assert alone == pytest.approx(0.1, rel=1e-3), "no less than a ten-thousandth, as of a run"
    assert 5.0 < bounds[0] < bounds[2] == pytest.approx(1.25 * 2.0 * 5.0)


def test_a_coarse_step_is_not_called_sensitive(tmp_path) -> None:
    """Measures that change much, but converge, have the error of their order with Roache's factor."""
    found = made(tmp_path / "a.study", 5, engine := Coarse())
    one = found.errors["C.force.max"]
    assert len(engine.repeated) == 15 and found.sensitive == (0, 5)
    assert (found.error_bars("C.force.max") == one.typical).all()
    truth = max(slope(case.numbers["joint.C.clearance"]) for case in found.cases)
    assert truth < one.most < 2.0 * truth
    assert "depend on the step" not in invoke("study", "show", str(tmp_path / "a.study"))


def test_few_cases_that_scatter_make_all_of_the_sample_known_better(tmp_path) -> None:
    """A regular motion of many cases has one repetition of each, and no caution."""
    found = made(tmp_path / "a.study", 30, engine := Linear())
    assert len(engine.repeated) == 20 and found.step_trials == {} and found.sensitive == (0, 20)
    assert "depend on the step" not in invoke("study", "show", str(tmp_path / "a.study"))


@pytest.mark.parametrize("stops", [4, 8, 14])
def test_further_repetitions_go_on_where_they_were_broken_off(stops, tmp_path) -> None:
    part = made(tmp_path / "a.study", 3, first := Scattering(stops=stops))
    assert len(first.repeated) == stops and part.status == "complete"
    whole = made(tmp_path / "a.study", 3, second := Scattering())
    once = made(tmp_path / "b.study", 3, Scattering())
    assert len(second.repeated) == 15 - stops
    assert whole.step_trials == once.step_trials and whole.errors == once.errors


def test_a_further_step_that_is_not_stable_is_replaced_by_another(tmp_path) -> None:
    """Twice the step fails; the values are those of the next trials."""
    found = made(tmp_path / "a.study", 2, Scattering(coarsest=1.8 * SIZE))
    for trials in found.step_trials.values():
        statuses = [trials[trial]["status"] for trial in sorted(trials)]
        assert statuses.count("complete") == 4 and statuses[0] == "failed"
    assert found.errors["C.force.max"].steps == 6


@pytest.mark.system("repeats a sensitive study with finer steps")
def test_cases_of_a_compressor_with_worn_pins_are_known_as_well_as_is_said() -> None:
    """Its motion does not repeat: the largest error holds beside finer steps."""
    model, pins = load("examples/compressor.toml"), ["joint.big-end.clearance", "joint.small-end.clearance"]
    clearances = [8.6e-5, 1.2e-4, 1.7e-4]
    measures = ["big-end.force.max", "small-end.force.max", "rod.angular_acceleration.max"]
    found = vfife.study(model, {"play": {"path": pins, "values": clearances}}, measures, turns=4, last=2)
    assert found.sensitive[0] == 3
    held = []
    for k, clearance in enumerate(clearances):
        for share in (3, 5):
            spec = CaseSpec(tuple(measures), 4, last=2, step=found.outcomes[k]["step"] / share)
            ((_, finer),) = run_cases(model, [dict.fromkeys(pins, clearance)], spec)
            held += [
                abs(finer.values[name] - found.values(name)[k]) <= found.errors[name].most
                for name in measures
            ]
    assert np.mean(held) >= 0.9


@pytest.mark.system("repeats a study with finer steps")
def test_cases_are_known_as_well_as_is_said(tmp_path) -> None:
    """Cases of case b, beside the same with an eighth of the step. Everybody who shows the study tells the
    error.
    """
    path = tmp_path / "b.study"
    clearances = [1e-4, 1.5e-4, 2e-4, 3e-4]
    given = {"turns": 2, "file": path}
    found = vfife.study(
        load(CASE_B),
        {"joint.C.clearance": clearances},
        ["C.force.max", "follower.angular_acceleration.max"],
        **given,
        lanes=2,
    )
    truth = []
    for k, clearance in enumerate(clearances):
        spec = CaseSpec(tuple(found.measures), 2, step=found.rows()[k]["step"] / 8)
        ((_, finer),) = run_cases(load(CASE_B), [{"joint.C.clearance": clearance}], spec)
        truth.append(finer.values)
    for name, one in found.errors.items():
        exact = np.array([values[name] for values in truth])
        assert one.count == 4 and 0.0 < one.typical <= one.rms <= one.most < 0.05 * np.abs(exact).min()
        assert np.abs(found.values(name) - exact).max() <= 1.5 * one.most, name
    again = vfife.study(
        load(CASE_B), {"joint.C.clearance": clearances}, list(found.measures), turns=2, lanes=8, workers=1
    )
    assert again.repeats == found.repeats and again.errors == found.errors
    shown = json.loads(invoke("study", "show", str(path), "--json"))["errors"]
    assert shown == {name: dataclasses.asdict(one) for name, one in found.errors.items()}
    assert "sample of 4, step" in invoke("study", "show", str(path))
    attributes = found.data["C.force.max"].attrs
    assert attributes["numerical_error_typical"] == found.errors["C.force.max"].typical
    assert attributes["numerical_error_largest"] == found.errors["C.force.max"].most


def test_a_step_that_is_given_is_repeated_with_another_one() -> None:
    found = vfife.study(
        load(CASE_B), {"joint.C.clearance": [1e-4, 2e-4]}, ["C.force.max"], turns=1, step="4 us"
    )
    steps = [found.repeats[k]["step"] / found.outcomes[k]["step"] for k in range(2)]
    assert all(1.3 < ratio < 1.7 for ratio in steps) and found.errors["C.force.max"].count == 2
