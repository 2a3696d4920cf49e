"""Whether turns repeat, and with which period: sequences whose periods are known, a decay whose rate is, a
ball on a table.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.measures.chaos import period, verdict
from vfife.measures.repetition import FEWEST_TURNS, MANY_TURNS, PEAK_STREAK, Turns, classify
from vfife.solvers.companions import TurnRows
from vfife.solvers.record import recorded_rows
from vfife.solvers.repeating import (
    LONGEST,
    Comparison,
    Points,
    Settling,
    TurnGrid,
    distance,
    outputs_of_a_turn,
    repeated_since,
    settles,
    turn_grid,
)


class Plain:
    """Compares turns by all of their numbers."""

    def distance(self, before: np.ndarray, after: np.ndarray) -> float:
        return distance(before, after)


def sequence(values: np.ndarray) -> list[np.ndarray]:
    """Turns with a peak each."""
    return [np.array([[0.1], [value], [0.2]]) for value in values]


def say(values: np.ndarray, tolerance: float = 1e-3) -> Turns:
    return classify(sequence(values), Plain(), tolerance)  # type: ignore[arg-type]


def logistic(r: float, count: int, start: float = 0.3) -> np.ndarray:
    x = [start]
    while len(x) < count:
        x.append(r * x[-1] * (1.0 - x[-1]))
    return np.array(x)


# Periods of x -> r x (1 - x), May, Nature 261 (1976): doublings at 3, 1 + sqrt 6, 3.5441; chaos beyond 3.5699
# but for windows, 3 from 1 + sqrt 8.
@pytest.mark.parametrize(
    ("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (1.0 + math.sqrt(8.0) + 0.003, 3)]
)
def test_the_logistic_map_has_the_periods_it_is_known_for(r: float, period: int) -> None:
    found = say(logistic(r, 300))
    assert (found.motion, found.period) == ("periodic", period)
    assert (
        found.since is not None
        and found.first >= found.since
        and (found.last - found.first + 1) % period == 0
    )
    assert found.last == found.count == 300


@pytest.mark.parametrize("r", [3.58, 3.7, 3.9, 4.0])
def test_chaos_is_not_periodic(r: float) -> None:
    found = say(logistic(r, 60))
    assert found.motion == "not repeating" and found.period is None and found.since is None
    assert (found.first, found.last) == (31, 60)


def test_a_quasi_periodic_sequence_is_not_periodic() -> None:
    """Turns of the golden mean come near each other after 1, 2, 3, 5, 8 ... turns, by 1/(sqrt 5 n) of a round
    at the nearest.
    """
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    found = say(2.0 + np.sin(2.0 * math.pi * golden * np.arange(80)), 0.01)
    assert found.motion == "not repeating" and found.distance > 0.01


def test_a_period_longer_than_is_looked_for_is_none() -> None:
    assert say(np.tile(np.arange(1.0, LONGEST + 1.0), 5)).period == LONGEST
    assert say(np.tile(np.arange(1.0, LONGEST + 2.0), 5)).motion == "not repeating"


@pytest.mark.parametrize(("rate", "tolerance"), [(0.5, 1e-3), (0.8, 1e-2), (0.9, 1e-2)])
def test_a_transient_of_known_rate_ends_where_it_must(rate: float, tolerance: float) -> None:
    """Peaks 1 + a q^k: turn k is |a (1 - q) q^(k - 1)| from the one before, as a share of the
    larger; the first within the tolerance counts.
    """
    k = np.arange(60)
    x = 1.0 + 0.4 * rate**k
    apart = np.abs(np.diff(x)) / np.maximum(x[1:], x[:-1])
    since = 2 + int(np.argmax(apart <= tolerance))  # turns are counted from 1
    found = say(x, tolerance)
    assert (found.motion, found.period, found.since) == ("periodic", 1, since)
    assert found.first == since and found.distance == pytest.approx(apart[-1])
    short = say(x[: since - 1], tolerance)
    assert short.motion == ("settling" if since > 6 else "unsettled") and (short.first, short.last) == (
        short.count,
        short.count,
    )


def test_a_slow_decay_is_settling_and_chaos_is_not() -> None:
    assert settles(0.95 ** np.arange(30)) and not settles(np.abs(np.diff(logistic(3.9, 30))))
    assert not settles(np.full(20, 0.3)) and not settles([0.1, 0.05]) and not settles(0.99 ** np.arange(20))


def test_a_run_of_few_turns_is_told_by_its_last_period() -> None:
    x = np.array([5.0, *np.ones(20)])
    for count in range(3, FEWEST_TURNS):
        found = say(x[:count])
        assert (found.motion, found.since, found.first, found.last) == ("periodic", 3, count, count)
    longer = say(x[: FEWEST_TURNS + 3])
    assert (longer.since, longer.first, longer.last) == (3, 3, FEWEST_TURNS + 3)
    assert (
        say(logistic(3.9, MANY_TURNS - 1)).motion == "unsettled"
        and say(logistic(3.9, MANY_TURNS)).motion == "not repeating"
    )
    assert math.isnan(say(x[:1]).distance)


def test_means_are_over_period_means() -> None:
    found = say(np.array([9.0, *[1.0, 2.0, 3.0] * 6, 1.0]))
    assert found.period == 3 and (found.last - found.first + 1) % 3 == 0 and found.first > found.since - 1 > 3  # type: ignore[operator]


def test_means_are_over_a_hundred_turns_at_the_most() -> None:
    regular, wild = say(np.ones(250)), say(logistic(3.9, 300))
    assert (regular.motion, regular.first, regular.last) == ("periodic", 151, 250)
    assert (wild.motion, wild.first, wild.last) == ("not repeating", 201, 300)
    assert say(logistic(3.9, 150)).first == 76, "the second half"


def bounces(acceleration: float, restitution: float, count: int) -> np.ndarray:
    """Speeds after each landing of a ball that bounces high on a table which goes up and down, the map of
    Holmes, J. Sound Vib. 84 (1982): in units in which the table's period is 2 pi and the time of flight is
    the speed.
    """
    phase = 0.01 - math.acos(
        max(-1.0, 2.0 * math.pi * (restitution - 1.0) / acceleration)
    )  # near where it lands once a period of the table
    speed, found = 2.0 * math.pi, []
    for _ in range(count):
        phase = phase + speed
        speed = restitution * speed - acceleration * math.cos(phase)
        found.append(abs(speed))
    return np.array(found)


def test_a_bouncing_ball_doubles_its_period_where_theory_says() -> None:
    """Holmes: bouncing once a period is born at gamma = 2 pi (1 - alpha), where alpha is the restitution, and
    doubles its period at gamma^2 = (2 pi (1 - alpha))^2 + 4 (1 + alpha)^2.
    """
    alpha = 0.4
    born = 2.0 * math.pi * (1.0 - alpha)
    doubled = math.sqrt(born**2 + 4.0 * (1.0 + alpha) ** 2)
    assert say(bounces(1.02 * born, alpha, 600)).period == 1
    assert say(bounces(0.99 * doubled, alpha, 2000), 1e-4).period == 1
    assert say(bounces(1.02 * doubled, alpha, 2000), 1e-4).period == 2


# ------------------------------------------------------------------------------------------------------ while
# a run goes on


@pytest.fixture(scope="module")
def cut():
    """A run in which a turn has five outputs, and the rows that turns are compared by."""
    assembly = assemble(four_bar("C"), 1e-5, turns=40, outputs=5)
    return assembly, recorded_rows(assembly)


def rows_of(cut, values: np.ndarray) -> np.ndarray:
    """Outputs of turns in which the force of the contact has such peaks, output 0 with them."""
    assembly, kept = cut
    rows = np.zeros((5 * len(values) + 1, len(kept)))
    column = int(np.flatnonzero(kept == assembly.layout["contact_force_squared_max"][0])[0])
    rows[3::5, column] = 1e6 * values
    return rows


@pytest.mark.parametrize(
    "values", [logistic(3.2, 40), logistic(3.5, 40), 1.0 + 0.5 ** np.arange(40), logistic(3.9, 40)]
)
def test_a_run_ends_where_it_is_found_to_repeat(cut, values: np.ndarray) -> None:
    """The watch ends it at the first turn after which the whole run would be called periodic, whatever pieces
    outputs come in.
    """
    rows = rows_of(cut, values)
    ends = []
    for piece in (1, 2, 5):
        watch, at = Settling(*cut, 1e-3), 1
        while at < len(rows) and not watch.settled:
            some = min(piece, watch.remaining)
            watch.take(rows[at : at + some])
            at += some
        ends.append((at - 1) / 5 if watch.settled else None)
    assert len(set(ends)) == 1
    comparison = Comparison(*cut)
    turns = [rows[1 + 5 * k : 6 + 5 * k][:, comparison.columns] for k in range(40)]

    def repeats(n: int, period: int) -> bool:
        some = max(period, 2)
        return n >= period + some and all(
            comparison.distance(turns[k - period], turns[k]) <= 1e-3 for k in range(n - some, n)
        )

    wanted = next((n for n in range(1, 41) if any(repeats(n, period) for period in range(1, 9))), None)
    assert ends[0] == wanted
    assert wanted is None or repeated_since(turns[:wanted], comparison, 1e-3) is not None


@pytest.mark.parametrize("done", [1, 40, 66, 98])
def test_a_watch_that_is_taken_up_ends_where_it_would_have(cut, done: int) -> None:
    rows = rows_of(cut, np.array([*logistic(3.9, 12), *logistic(3.5, 28, 0.874997)]))
    ends = []
    for taken in (0, done):
        watch = Settling(*cut, 1e-3)
        watch.restore(rows[: taken + 1])
        at = taken + 1
        while not watch.settled and at < len(rows):
            watch.take(rows[at : at + 1])
            at += 1
        ends.append(at)
    assert ends[0] == ends[1] < len(rows)


def test_what_is_next_to_nothing_does_not_keep_turns_apart(cut) -> None:
    """Noise in an idle joint, a thousandth of the largest of its kind, does not count; a tenth of it does."""
    comparison = Comparison(*cut)
    columns = list(comparison.families["squares"])
    before, after = np.zeros((2, 5, len(comparison.columns)))
    before[2, columns[0]] = after[2, columns[0]] = 1e8
    before[3, columns[1]], after[3, columns[1]] = 1e2, 9e2
    assert comparison.distance(before, after) < 1e-3
    after[3, columns[1]] = 1e6
    assert comparison.distance(before, after) == pytest.approx(1.0, rel=1e-3)


def test_rounding_of_what_carries_nothing_does_not_keep_turns_apart(cut) -> None:
    """A torque of 1e-5 N m beside forces of 10 kN is none, nor are second differences of an angle that is
    known to sixteen digits.
    """
    comparison = Comparison(*cut)
    before, after = np.zeros((2, 5, len(comparison.columns)))
    before[2, comparison.families["squares"][0]] = after[2, comparison.families["squares"][0]] = 1e8
    moment, turning = (comparison.families[kind][0] for kind in ("moments", "accelerations"))
    before[3, moment], after[3, moment] = 1e-5, 3e-5
    before[3, turning], after[3, turning] = 1e-16 / 1e-5**2, -1e-16 / 1e-5**2
    assert comparison.distance(before, after) < 0.01
    after[3, moment] = 0.1
    assert comparison.distance(before, after) > 0.9


@pytest.mark.parametrize("pieces", [[12], [1] * 12, [5, 2, 5], [3, 9]])
def test_rows_of_turns_do_not_depend_on_the_pieces_that_come(pieces: list[int]) -> None:
    """Extremes are the largest of a turn, sums its last; a checkpoint in the middle of one, too."""
    rows = np.random.default_rng(3).normal(size=(12, 2, 3))
    gathered, at = TurnRows(TurnGrid(5.0), np.array([True, False])), 0
    for piece in pieces:
        again = TurnRows(TurnGrid(5.0), gathered.extreme)
        again.restore(json.loads(json.dumps(gathered.checkpoint)), gathered.turns)
        gathered = again
        gathered.take(rows[at : at + piece])
        at += piece
    found = gathered.array(3)
    assert np.array_equal(found[:, 0], rows[:10, 0].reshape(2, 5, 3).max(axis=1)) and np.array_equal(
        found[:, 1], rows[[4, 9], 1]
    )
    assert gathered.array(3, 9).shape == (1, 2, 3)


def test_turns_are_counted_where_they_can_be() -> None:
    assert outputs_of_a_turn(assemble(four_bar("C"), 1e-5, turns=3, outputs=100)) == 100
    assert outputs_of_a_turn(assemble(four_bar("C"), 1.03e-5, turns=3, outputs=100)) is None
    assert turn_grid(assemble(four_bar("C"), 1e-5, turns=3, outputs=100)) == TurnGrid(100.0)
    between = turn_grid(assemble(four_bar("C"), 1.03e-5, turns=3, outputs=100))
    assert between is not None and not between.has_integral_turns
    assert turn_grid(assemble(four_bar("C"), 1.03e-5, turns=3, outputs=12)) is None, "too few to tell ends"


def test_a_turn_between_two_outputs_ends_at_the_nearer_one() -> None:
    grid = TurnGrid(7.4)
    assert [grid.end(turn) for turn in range(6)] == [0, 7, 15, 22, 30, 37]
    assert [grid.count(outputs) for outputs in (6, 7, 14, 15, 21, 22, 37)] == [0, 1, 1, 2, 2, 3, 5]
    gathered = TurnRows(grid, np.array([True, False]))
    rows = np.arange(30.0)[:, None, None] * np.ones((1, 2, 1))
    assert gathered.take(rows[:20]) == 2 and gathered.take(rows[20:]) == 2
    assert gathered.array(1)[:, 0, 0].tolist() == [6.0, 14.0, 21.0, 29.0]


# Turns of a motion with the ``period`` 1 to 3, a peak in each that an output meets or misses at random, and a
# largest value that scatters by ``scatter``.
@pytest.mark.parametrize(
    ("period", "scatter", "known"), [(1, 0.002, 1), (2, 0.004, 2), (3, 0.002, 3), (1, 0.05, None)]
)
def test_turns_that_scatter_about_a_periodic_motion_have_its_period(
    period: int, scatter: float, known: int | None
) -> None:
    random = np.random.default_rng(7)
    peaks = 1.0 + 0.3 * (np.arange(40) % period) + scatter * (random.random(40) - 0.5)
    turns = [np.array([[0.1], [peak * random.random()], [peak]]) for peak in peaks]
    found = classify(
        turns,
        Plain(),  # type: ignore[arg-type]
        0.01,
        lambda first, last: Points(peaks[first - 1 : last, None], np.array([peaks.max()])),
    )
    assert found.period == known and found.scatters == (known is not None)
    if known:
        assert (
            found.motion == "periodic"
            and found.distance <= scatter
            and (found.last - found.first + 1) % known == 0
        )
        assert found.first >= 21 and not found.repeats
    else:
        assert found.motion == "not repeating"
    assert classify(turns, Plain(), 0.01).motion == "not repeating"  # type: ignore[arg-type]


def test_a_long_transient_leaves_the_last_quarter() -> None:
    random = np.random.default_rng(3)
    peaks = np.concatenate([1.0 + 0.5 * random.random(26), 1.0 + 0.002 * random.random(14)])
    for count, first in ((32, None), (40, 31), (56, 29)):
        more = np.concatenate([peaks, 1.0 + 0.002 * random.random(16)])[:count]
        turns = [np.array([[peak * random.random()], [peak]]) for peak in more]
        found = classify(
            turns,
            Plain(),  # type: ignore[arg-type]
            0.01,
            lambda low, high, values=more: Points(values[low - 1 : high, None], np.ones(1)),
        )
        assert (found.first if found.scatters else None) == first


def test_largest_values_alone_must_repeat_three_times() -> None:
    """Of thirteen turns the last two may be like the two before by chance."""
    values = np.array([5.0, 3.0, 4.0, 1.0, 2.5, 4.5, 3.5, 1.5, 2.0, 6.0, 3.0, 6.0, 3.0])
    assert say(values).period == 2
    turns = sequence(values)
    once = classify(turns, Plain(), 1e-3, None, PEAK_STREAK)  # type: ignore[arg-type]
    assert once.motion == "not repeating"
    again = [*turns, *turns[-2:], *turns[-2:]]
    assert classify(again, Plain(), 1e-3, None, PEAK_STREAK).period == 2  # type: ignore[arg-type]


def test_turns_that_alternate_settle_in_a_run_and_in_a_section() -> None:
    """Both have one criterion; after the same turns both would be of period 2 without it."""
    points = 1.0 + 0.06 * (-0.844) ** np.arange(38.0)
    assert say(points, 1e-4).period == period(points) == 2

    def points_of(first: int, last: int) -> Points:
        return Points(points[first - 1 : last, None], np.ones(1))

    run = classify(sequence(points), Plain(), 1e-4, points_of)  # type: ignore[arg-type]
    assert run.motion == "settling" and run.decay == pytest.approx(0.156)
    section = verdict(points)
    assert section.kind == "not settled" and "by 16 % a turn" in section.evidence


def places(count: int, known: int) -> list[int]:
    """The output at which a stop is met in each turn: at random, but in pairs in the last ``known`` turns."""
    random = np.random.default_rng(5).integers(1, 60, count)
    return [*random[: count - known], *([3, 40] * known)[:known]]


def struck(peaks: np.ndarray, outputs: list[int]) -> list[np.ndarray]:
    """Turns with a peak each at an output."""
    turns = np.zeros((len(peaks), 60, 1))
    turns[np.arange(len(peaks)), outputs, 0] = peaks
    return list(turns)


@pytest.mark.parametrize(("count", "step"), [(7, 0.0), (16, 0.0), (7, 0.1), (16, 0.1)])
def test_a_period_of_several_turns_needs_turns_that_differ(count: int, step: float) -> None:
    """Outputs agree in pairs at the end by chance. Largest values that are the same every turn, but for a
    scatter of 0.05 %, are of period 1; those that alternate by a tenth are of period 2.
    """
    peaks = 1.0 + step * (np.arange(count) % 2) + 5e-4 * np.random.default_rng(2).random(count)

    def points_of(first: int, last: int) -> Points:
        return Points(peaks[first - 1 : last, None], np.ones(1))

    found = classify(struck(peaks, places(count, 6)), Plain(), 0.01, points_of)  # type: ignore[arg-type]
    assert found.motion == "periodic" and found.period == (2 if step else 1)
    assert classify(struck(peaks, places(count, 6)), Plain(), 0.01).period == 2  # type: ignore[arg-type]


def test_points_that_approach_each_other_are_settling_wherever_the_outputs_are() -> None:
    """A geometric decay of e^-0.5 a turn, as of a pendulum that meets a stop at another output in each turn;
    the same turns with chaotic largest values do not repeat.
    """
    for peaks, motion in (
        (1.0 + 2.0 * math.exp(-0.5) ** np.arange(13.0), "settling"),
        (1.0 + 0.3 * (-1.0) ** np.arange(13) + 2.0 * 0.5 ** np.arange(13.0), "settling"),
        (1.0 + logistic(3.9, 13), "not repeating"),
    ):

        def points_of(first: int, last: int, peaks: np.ndarray = peaks) -> Points:
            return Points(peaks[first - 1 : last, None], np.ones(1))

        turns = struck(peaks, places(13, 0))
        assert classify(turns, Plain(), 1e-3).motion == "not repeating"  # type: ignore[arg-type]
        assert classify(turns, Plain(), 1e-3, points_of).motion == motion  # type: ignore[arg-type]


def test_a_watch_does_not_end_where_turns_alternate_and_still_settle(cut) -> None:
    """Squares of forces that are multiplied by -0.844 about their limit agree in pairs at 1 % of it when they
    are 1.8 times as far from the next; the run ends when these are, too.
    """
    values = 1.0 + 0.3 * (-0.844) ** np.arange(40)
    rows, watch, at = rows_of(cut, values), Settling(*cut, 0.01), 1
    while not watch.settled:
        watch.take(rows[at : at + 5])
        at += 5
    count = (at - 1) // 5
    last = np.abs(np.diff(values[:count])[-3:]) / values.max()
    pairs = next(n for n in range(8, 40) if 0.3 * 0.844 ** (n - 4) * (1.0 - 0.844**2) <= 0.01)
    assert last.max() <= 0.01 and count > pairs + 4
