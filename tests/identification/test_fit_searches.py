"""Searches and doubts of a fit on curves of closed forms, which stand in the place of runs: wrong places,
errors of steps, what does not repeat.
"""

import dataclasses
import json
import math

import numpy as np
import pandas
import pytest

from vfife.errors import ModelError, VfifeError
from vfife.identification.batched_queries import Evaluations, Query
from vfife.identification.curve_sensitivity import sensitivity_of
from vfife.identification.curves import Trace
from vfife.identification.descents import Budget, Descents
from vfife.identification.fit_task import assembled_within
from vfife.identification.measurements import Curve, Measured, columns_of, measured
from vfife.identification.other_minima import Search
from vfife.identification.parameters import FitParameter
from vfife.identification.residuals import FitRecord, Misfit
from vfife.identification.run_length import Offset, RunLength
from vfife.identification.step_uncertainty import concluded
from vfife.measures.chaos import Exponent
from vfife.report.amounts import quantities
from vfife.results.fit import FitValue

STEPS = RunLength("time", None, 1.0, 200, 10, 1e-3)
PLACES = np.linspace(0.0, 1.0, 200)
NOISE = 0.02 * np.random.default_rng(2).standard_normal(len(PLACES))


@dataclasses.dataclass(frozen=True)
class Closed:
    """Stands for curves: ``form(t, numbers, step)``, over time, and of what turns over ten turns of 0.2 s."""

    form: object
    length: RunLength = STEPS
    more: float = 0.0
    has_contacts: bool = False

    def changed(self, finer, turns, denser=1):
        steps = self.length.steps_per_output + finer
        return dataclasses.replace(
            self,
            length=dataclasses.replace(
                self.length,
                steps_per_output=steps,
                step=self.length.step * self.length.steps_per_output / steps,
            ),
            more=turns,
        )

    def case_traces(self, cases):
        return [one.trace(numbers) for one, numbers in cases]

    def trace(self, numbers):
        turn = None if self.length.turns is None else 0.2
        t = (
            PLACES
            if turn is None
            else np.linspace(0.0, turn * (10.0 + self.more), self.length.outputs * (10 + int(self.more)) + 1)
        )
        return Trace(t, self.form(t, numbers, self.length.step)[:, None], turn)


def fitted(curves, names, truth, *, noise=NOISE, offset=None, starts=1, screened=8, known=0.0, progress=None):
    """A fit to the form at its finest step; what the search left, and the fit."""
    sought = [FitParameter(name, (name,), "m", 0.0, 1.0) for name in names]
    values = curves.form(PLACES + known, truth, 0.0)
    seen = Measured("time", PLACES, (Curve("x", "x", values + noise * values.std()),))
    misfit = Misfit(seen, offset or Offset(0.0, 0.0), 0.0)
    looked = Evaluations([FitRecord(curves, sought, misfit)], sought, progress=progress)
    ended = Search()
    Descents(looked, ended, "differences").run(screened, starts, 3)
    slopes = looked.slopes(Query(tuple(looked.best[1]), None, False), looked.best[2])
    return looked, ended, concluded("closed", {"x": "m"}, looked, ended, slopes, 0.95)


def test_contacts_widen_limits() -> None:
    """They make the sum of squares rough."""

    def line(t, numbers, step):
        return numbers["a"] * t

    calm, rough = (
        fitted(Closed(line, has_contacts=contacts), ["a"], {"a": 0.4})[2] for contacts in (False, True)
    )
    widths = [found.values[0].high - found.values[0].low for found in (calm, rough)]
    assert widths[1] == pytest.approx(1.25 * widths[0])
    words = "limits are 1.25 times as wide as those of least squares"
    assert words in " ".join(str(rough).split()) and words not in " ".join(str(calm).split())


@pytest.mark.parametrize("contacts", [False, True])
def test_where_contacts_make_the_sum_of_squares_rough_searches_go_on_around_the_best_point(contacts) -> None:
    """A ripple makes many minima; that of 0.62 is least, and a search ended in that of 0.70."""

    def ripple(t, numbers, step):
        a = numbers["a"]
        return a * np.sin(5.0 * t) + 0.05 * math.sin(2.0 * math.pi * a / 0.05) * np.cos(23.0 * t)

    curves = Closed(ripple, has_contacts=contacts)
    found = fitted(curves, ["a"], {"a": 0.62}, starts=1, screened=6)[2].values[0]
    assert (abs(found.value - 0.62) < 1e-3) is contacts and found.known is contacts
    assert not contacts or found.low < 0.62 < found.high < found.low + 1e-3


def two_hills(t, numbers, step):
    """A tune whose pitch is told sharply, and a tone as loud as a broad hill or a narrow one say: the true
    loudness is that of the narrow one.
    """
    loud = 0.7 * math.exp(-(((numbers["loud"] - 0.2) / 0.2) ** 2)) + math.exp(
        -(((numbers["loud"] - 0.85) / 0.04) ** 2)
    )
    return np.sin(40.0 * (0.5 + numbers["pitch"]) * t) + loud * np.cos(7.0 * t)


def test_a_search_that_ended_in_a_wrong_place_is_begun_again_from_others():
    """The broad hill leaves a tone, which is no noise; the pitch, which is known already, stays while
    loudness is looked for.
    """
    _, ended, found = fitted(Closed(two_hills), ("pitch", "loud"), {"pitch": 0.52, "loud": 0.85}, screened=24)
    best, wrong = found["loud"].value, min(ended.ends, key=lambda one: abs(one[1][1] - 0.2))[1][1]
    assert best == pytest.approx(0.85, abs=0.01) and wrong == pytest.approx(0.2, abs=0.05), (
        "the first search ended on the broad hill"
    )
    assert found["pitch"].value == pytest.approx(0.52, abs=1e-3) and found.share == pytest.approx(
        0.02, rel=0.15
    )


def test_progress_grows_to_its_end_only_when_the_fit_ends():
    """The number of runs of which it is a share grows when searches begin again."""
    reports = []
    looked, ended, _ = fitted(
        Closed(two_hills), ("pitch", "loud"), {"pitch": 0.52, "loud": 0.85}, screened=24,
        progress=lambda state: reports.append((looked_runs(state), state.done / state.steps)),
    )  # fmt: skip
    shares = [share for _, share in reports]
    assert len(ended.ends) > 1 and max(shares) < 1.0
    looked.finish()
    assert reports[-1] == (looked.runs, 1.0)


def looked_runs(state):
    return int(state.text.split(" ")[0])


def test_noise_alone_is_not_searched_again():
    line = Closed(lambda t, numbers, step: numbers["a"] * t)
    _, ended, found = fitted(line, ("a",), {"a": 0.4})
    assert len(ended.ends) == 1 and found["a"].known and found["a"].low < 0.4 < found["a"].high


def searched(form, starts):
    """Points (shares of the bounds, in order) that searches of ``a`` from these places ask for, with the
    search; the truth is 0.5.
    """
    curves, parameter = Closed(form), FitParameter("a", ("a",), "m", 0.0, 1.0)
    values = form(PLACES, {"a": 0.5}, 0.0)
    misfit = Misfit(Measured("time", PLACES, (Curve("x", "x", values),)), Offset(0.0, 0.0), 0.0)
    looked = Evaluations([FitRecord(curves, [parameter], misfit)], [parameter])
    descents = Descents(looked, Search(), "differences")
    descents.descend(descents.screen(np.array(starts)[:, None]))
    return [one[1][0] for one in looked.points[len(starts) :]], descents.search


def flat(t, numbers, step):
    """A parameter whose distance from the truth a search reduces by a ninth at most in each step."""
    return t * (1.0 + 1e20 * (numbers["a"] - 0.5) ** 9)


def test_a_search_ends_after_forty_points():
    points, search = searched(flat, [0.9])
    assert len(set(points)) == 40 and len(search.ends) == 1


def test_a_search_far_above_the_best_point_is_abandoned_after_eight_points():
    """Another search finds the truth at once; the point after the eighth ends this one, which has no end."""
    points, search = searched(
        lambda t, numbers, step: t * (0.5 + numbers["a"]) if numbers["a"] < 0.6 else flat(t, numbers, step),
        [0.45, 0.9],
    )
    assert len({one for one in points if one >= 0.6}) == 8 + 1
    assert [values for _, values in search.ends] == [pytest.approx((0.5,))]


def test_errors_know_the_error_of_the_step():
    """y = a t (1 + 20 h) at a step of h = 1 ms: a comes out 2 % too low, without noise, and its error says
    so.
    """
    line = Closed(lambda t, numbers, step: numbers["a"] * t * (1.0 + 20.0 * step))
    _, _, found = fitted(line, ("a",), {"a": 0.5}, noise=0.0)
    one = found["a"]
    assert (
        one.value == pytest.approx(0.5 / 1.02, rel=1e-6)
        and one.error == pytest.approx(0.01, rel=0.05)
        and one.low < 0.5 < one.high
    )


def wild(t, numbers, step):
    """Swings that other steps turn into others, and other turns too."""
    return np.sin(2.0 * math.pi * (7.3 + 1e3 * step) * t + 9.0 * numbers["a"]) + 0.2 * numbers["a"]


def turning(t, numbers, step):
    """What dies away over many turns: the next turn is another one."""
    return np.exp(-t * (1.0 + numbers["a"])) * np.sin(10.0 * math.pi * t)


def test_what_steps_decide_is_called_not_known():
    _, _, found = fitted(Closed(wild), ("a",), {"a": 0.4})
    assert (
        not found["a"].known and not found["a"].determined and found.json()["parameters"][0]["known"] is False
    )
    assert any("with other steps, so confidence is not known" in note for note in found.notes)


@pytest.mark.parametrize(("late", "known"), [(0.0, True), (1.0, False)])
def test_what_does_not_repeat_is_called_not_known_where_nobody_knows_the_turn(late, known):
    """A free offset lies in one turn, the data may have begun in any; with one that is given the turn is
    known.
    """
    length = RunLength("time", lambda turn: 10.0, 0.0, 100, 10, 1e-3)
    free = Offset(0.0, 0.2, True) if late else Offset(0.0, 0.0)
    looked, _, found = fitted(Closed(turning, length), ("a",), {"a": 0.4}, offset=free)
    assert found["a"].known is known and looked.records[0].misfit.unknown_turn is bool(late)
    assert any("from the next turn on" in note for note in found.notes) is not known
    assert math.isfinite(found.offset_error) is known


def test_limits_take_in_what_fits_as_well():
    """Points that cost no more than the best one at other steps are within the limits, whatever the linear
    model says.
    """
    looked, _, found = fitted(Closed(wild), ("a",), {"a": 0.4}, screened=30)
    _, shares, best = looked.best
    slopes = looked.slopes(Query(tuple(shares), None, False), best)
    cost = sensitivity_of(looked.records, shares, best, slopes.jacobian, shares).cost
    alike = [at[0] for one, at in looked.points if one <= cost]
    (low, high), unknown = found["a"].ends, (found["a"].error, found["a"].low, found["a"].high)
    assert low <= min(alike) < max(alike) <= high and max(alike) - min(alike) > 0.3
    assert all(map(math.isnan, unknown)), "a confidence that is not known has no limits"
    (value,) = json.loads(json.dumps(found.json(), default=float))["parameters"]
    assert value["known"] is False and all(math.isnan(value[name]) for name in ("standard_error", "low"))
    assert "confidence not known" in repr(found) and "not known" in str(found)


def rough(t, numbers, step):
    """A curve that hardly depends on its number, and not evenly: six values have nearly the same curve."""
    small = 0.01 * math.sin(20.0 * numbers["a"]) + 0.002 * numbers["a"]
    return np.sin(10.0 * t) + small * np.cos(7.0 * t) + numbers["b"] * np.cos(23.0 * t)


def test_searches_that_end_at_other_values_dispute_a_number():
    """Its ends hold all of them and the truth; the other number, on which all searches agree, is known."""
    _, search, found = fitted(Closed(rough), ("a", "b"), {"a": 0.4, "b": 0.3}, starts=4, screened=16)
    ends = [values[0] for _, values in search.ends]
    assert max(ends) - min(ends) > 0.2, "or this test says nothing"
    assert not found["a"].known and found["b"].known
    assert found["a"].ends[0] <= min(*ends, 0.4) and found["a"].ends[1] >= max(*ends, 0.4)
    assert math.isnan(found["a"].error) and found["b"].error > 0.0
    assert any("searches do not agree on a:" in note for note in found.notes)
    near = sum(abs(one - found["a"].value) < 0.01 for one in ends)
    assert any(f"{near} of {len(ends)} searches reached this point" in one for one in found.remarks)
    assert "confidence not known" in repr(found) and "b = 0.3" in repr(found)
    low, high = np.clip(found["a"].ends, 0.0, 1.0)
    shown = " ".join(str(found).split())
    assert f"a fits nearly as well from {quantities(low, high, 'm')}; values outside" in shown
    assert "fits nearly as well from" in found["a"].words(0.95) and "b fits" not in shown
    assert all(one in shown for one in [*found.remarks, *found.notes])


def test_ends_of_an_unknown_confidence_lie_within_the_bounds():
    value = FitValue("a", ("a",), "m", 0.5, 0.4, -0.3, 1.3, (0.0, 1.0), known=False)
    assert value.ends == (0.0, 1.0) and value.json()["ends"] == [0.0, 1.0]


def test_one_search_is_not_disputed_and_its_limits_are_shown():
    """As before; repr has the limits."""
    line = Closed(lambda t, numbers, step: np.sin(10.0 * t) + numbers["b"] * np.cos(23.0 * t))
    _, _, found = fitted(line, ("b",), {"b": 0.3}, starts=1, screened=4)
    one = found["b"]
    assert one.known and one.low < 0.3 < one.high and "95 %:" in repr(found)


def test_columns_that_are_not_compared_are_named(tmp_path):
    """Those with the name of a channel, where other columns were named, else those with that of none."""
    path = tmp_path / "a.csv"
    rows = [f"{0.1 * k},{math.sin(k)},{math.cos(k)},{k % 7}" for k in range(30)]
    path.write_text("\n".join(["time (s),x (m),mic,other", *rows]), encoding="utf-8")
    units = {"x": "m", "y": "m"}
    assert measured(path, units, columns_of({"mic": "y"})).omitted == ("x",)
    assert measured(path, units).omitted == () == measured(path, units, columns_of(["x", "mic=y"])).omitted
    assert measured(path, units, columns_of(["x"])).unknown == ()
    (mic, other), near = measured(path, units).unknown, {"mic.x": "m", "x": "m"}
    assert (mic, other) == ("mic", "other")
    assert measured(path, near).unknown[0] == 'mic (did you mean "mic.x"?)'


def test_the_time_left_is_that_of_runs_with_and_without_derivatives():
    """48 runs of a stage and 52 later ones take 0.1 s each, 24 and 16 with derivatives 2 s."""
    watched = Evaluations([], [])
    watched.begin(np.array([64.0, 24.0]), np.array([52.0, 16.0]))
    watched.counts[0], watched.calls[0], watched.paces[0] = 16, 1, 2.0
    assert watched.time_left() == "", "the first runs compile"
    watched.calls[0], watched.paces[0] = 2, 0.1
    assert watched.time_left() == ", about 14 s left", "140 runs"
    watched.calls[1], watched.paces[1] = 2, 2.0
    assert watched.time_left() == ", about 1 min 30 s left" and watched.expected == 16 + 140
    watched.counts[:] = 100, 40
    assert watched.time_left() == ", about 60 s left", "a stage longer than usual: 25 and 10 more"


@pytest.mark.parametrize("index", [True, False])
def test_a_data_frame_is_read_as_its_csv_file_is(index, tmp_path):
    frame = pandas.DataFrame({"time (ms)": 1e3 * PLACES, "C.force (kN)": NOISE})
    frame.to_csv(tmp_path / "a.csv", index=False)
    expected = measured(tmp_path / "a.csv", {"C.force": "N"})
    found = measured(frame.set_index("time (ms)") if index else frame, {"C.force": "N"})
    assert found.name == "data frame" and found.over == "time"
    assert np.array_equal(found.places, expected.places)
    assert np.array_equal(found.curves[0].values, expected.curves[0].values)
    assert found.curves[0].values == pytest.approx(1e3 * NOISE, rel=1e-12)
    with pytest.raises(ModelError, match="no column of times"):
        measured(frame.drop(columns="time (ms)"), {"C.force": "N"})


def test_bounds_without_a_model_are_named_as_written():
    """The middle of 0.05 to 0.5 m was named, a number that nobody wrote."""

    class NoModel:
        def assembled(self, numbers):
            raise VfifeError(f"clearance (given by set) = {numbers['c']:g}: too large")

    record = FitRecord(
        dataclasses.make_dataclass("Curves", ["cases"])(NoModel()),
        [FitParameter("c", ("c",), "m", 0.05, 0.5)], None,
    )  # fmt: skip
    with pytest.raises(ModelError) as caught:
        assembled_within(record)
    assert "c = 0.05 .. 0.5 m" in str(caught.value) and "clearance = 0.05: too large" in str(caught.value)
    assert "0.158" not in str(caught.value) and "given by set" not in str(caught.value)


def test_an_exponent_is_a_number():
    assert float(Exponent(0.25, 0.1, 0.4, np.array([0.25]), (0.2, 0.3))) == 0.25


def test_searches_by_tangents_are_forecast_as_such():
    """Four searches and three restarts of four, and two rounds, of twenty points each."""
    budget = Budget.of([2], 64, 4)
    assert budget.search_points(3) == 20 * (4 + 12 + 2)
    assert budget.search_points(0) == 20 * (4 + 2)
