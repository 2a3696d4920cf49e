"""Measures of a run of many turns: means after the transient, what varies, what is not known; runs that end
by themselves.
"""

from __future__ import annotations

import dataclasses
import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import vfife
from support import TURN, four_bar, journal_in_bearing
from vfife.errors import ModelError, VfifeError
from vfife.measures.catalogue import measures
from vfife.measures.error_ranges import over_turns
from vfife.measures.extrapolation import SCATTER_OF_MEANS, error_of_mean, error_range
from vfife.measures.values import Measured
from vfife.report.amounts import amount, decimals, percent, prefixed
from vfife.report.digits import measure_text, plain_number
from vfife.report.summary import show
from vfife.report.trust import scatter_over_turns, turn_lines, verdict
from vfife.simulation.result import Result

OUTPUTS = 200


@cache
def settled() -> Result:
    """Case c, whose turns come a tenth nearer to each other with each; with a step that shows it."""
    return vfife.simulate(four_bar("BCD"), turns=9, step="5 us", outputs=OUTPUTS, companions=3)


@cache
def astray() -> Result:
    """A slider-crank with a loose pin and no friction: no two turns of it are alike."""
    return vfife.simulate(
        vfife.gallery.slider_crank_loose_pin(),
        turns=12,
        outputs=OUTPUTS,
        companions=3,
        step=math.pi / 50.0 / (150 * OUTPUTS),
    )


def peaks(result: Result, block: str, k: int) -> np.ndarray:
    """Largest value in each turn, from the extremes within the output intervals."""
    return result.record.block(block)[1:, k].reshape(-1, OUTPUTS).max(axis=1)


# ----------------------------------------------------------------------------------------------------- values


def test_a_measure_is_the_mean_of_its_turns_after_the_transient() -> None:
    result = settled()
    said = result.motion
    assert said is not None and (said.motion, said.period, said.count) == ("periodic", 1, 9)
    assert said.since is not None and 3 <= said.since <= 6 and said.first == said.since and said.last == 9
    force = np.sqrt(peaks(result, "contact_force_squared_max", 1))[said.first - 1 :]
    one = result.measures["C.force.max"]
    assert one.value == pytest.approx(force.mean(), rel=1e-14)
    assert (one.lowest, one.highest) == pytest.approx((force.min(), force.max()), rel=1e-14)
    alpha = peaks(result, "body_alpha_max", result.record.assembly.bodies["follower"].row)[said.first - 1 :]
    assert result.measures["follower.angular_acceleration.max"].value == pytest.approx(
        alpha.mean(), rel=1e-14
    )
    assert result.reference is not None
    ideal = result.reference.measures["C.force.max"]
    lip = result.measures["C.force.lip"]
    assert (lip.value, lip.lowest) == pytest.approx(
        (100.0 * (force.mean() / ideal - 1.0), 100.0 * (force.min() / ideal - 1.0)), rel=1e-9
    )


def test_what_is_not_known_is_the_range_of_means() -> None:
    """Of each companion one row a turn is kept, which is what a run of its own would leave."""
    result = settled()
    left, said = result.record.companions, result.motion
    assert left is not None and said is not None and left.turns.shape == (9, len(left.row_numbers), 3)
    row = int(
        np.flatnonzero(left.row_numbers == result.record.assembly.layout["contact_force_squared_max"][1])[0]
    )
    means = np.sqrt(left.turns[said.first - 1 :, row]).mean(axis=0)
    one = result.measures["C.force.max"]
    ratios = [1.0, *(result.record.assembly.choice.outputs_every / left.counts)]
    assert (one.low, one.high) == pytest.approx(
        error_range("C.force.max", ratios, [one.value, *means]), rel=1e-14
    )
    assert one.low < min(one.value, *means) and one.high > max(one.value, *means)
    last = left.rows[1:, row].max(axis=0)
    assert np.array_equal(left.turns[-1, row], last)


def test_counts_are_those_of_the_whole_run() -> None:
    result = settled()
    assert [result.measures[f"{joint}.impacts"] for joint in "BCD"] == result.record.block("contact_onsets")[
        -1
    ].tolist()


def test_a_run_of_few_turns_is_told_by_its_last() -> None:
    result = vfife.simulate(
        four_bar("BCD"), turns=2, step="5 us", outputs=OUTPUTS, companions=0, reference=False
    )
    assert result.motion is not None and result.motion.motion == "unsettled"
    assert dict(result.measures) == measures(result.record)
    assert all(
        one.lowest == one.highest == one.low == one.high == one.value for one in result.measures.values()
    )


def test_an_ideal_mechanism_repeats_from_its_second_turn_on() -> None:
    """Its joints are kept by the same equations in every turn; noise of what carries nothing
    does not count.
    """
    result = vfife.simulate(vfife.gallery.slider_crank(), turns=3, companions=0)
    said = result.motion
    assert said is not None and (said.motion, said.period, said.since, said.first) == ("periodic", 1, 2, 3)
    assert said.distance < 1e-6


def test_turns_that_do_not_repeat_have_means_over_turns_and_companions() -> None:
    result = astray()
    said, left = result.motion, result.record.companions
    assert (
        said is not None
        and left is not None
        and said.motion == "not repeating"
        and (said.first, said.last) == (7, 12)
    )
    own = np.sqrt(peaks(result, "contact_force_squared_max", 0))[6:]
    row = int(
        np.flatnonzero(left.row_numbers == result.record.assembly.layout["contact_force_squared_max"][0])[0]
    )
    every = np.column_stack([own, np.sqrt(left.turns[6:, row])])
    one = result.measures["pin.force.max"]
    assert one.value == pytest.approx(every.mean(), rel=1e-13)
    least, most = every.mean(axis=0).min(), every.mean(axis=0).max()
    reach, error = SCATTER_OF_MEANS * (most - least), error_of_mean(every.T.tolist())
    low, high = min(least - reach, one.value - error), max(most + reach, one.value + error)
    assert (one.low, one.high) == pytest.approx((max(low, 0.0), high), rel=1e-13)
    assert (one.lowest, one.highest) == pytest.approx((every.min(), every.max()), rel=1e-13)
    assert one.variation > 2.0 * (most - least)  # single turns do not hold, means do
    told = result.summary
    assert told["turns"]["motion"] == "not repeating" and verdict(told).startswith(
        "The 12 turns do not repeat: single turns of "
    )
    assert any("or in a longer transient" in line for line in turn_lines(told))
    assert told["warnings"][0] == verdict(told)


def test_the_short_answer_shows_the_highest_turn_of_a_chaotic_motion() -> None:
    result = astray()
    force = result.measures["pin.force.max"]
    assert force.highest > force.high, "single turns exceed the range of the mean"
    row = next(line for line in str(result).splitlines() if line.lstrip().startswith("pin "))
    lowest, highest, prefix = re.findall(r"([\d.]+) to ([\d.]+) (k?)N", row)[-1]
    scale = 1e3 if prefix else 1.0
    assert scale * float(lowest) <= force.lowest and force.highest <= scale * float(highest)
    assert max(map(len, str(result).splitlines())) <= 100


def test_the_force_that_varies_is_named_with_digits() -> None:
    """Not the largest one, whose turns lie "-0 to +0 %" from their mean; nor a small one,
    whatever it does.
    """
    ranges = {
        f"{name}.force.max": {"lowest": low, "highest": high}
        for name, low, high in (("A", 998.0, 1001.0), ("B", 400.0, 515.0), ("C", 0.0, 9.0))
    }
    turns = {"motion": "not repeating", "count": 12, "first": 7, "last": 12}
    told = {"turns": turns, "trust": {}, "ranges": ranges}
    told["measures"] = {"A.force.max": 1000.0, "B.force.max": 500.0, "C.force.max": 3.0}
    assert scatter_over_turns(told).startswith(
        "The 12 turns do not repeat: single turns of B.force.max lie -20 to +3 % from their mean. "
    )
    del ranges["B.force.max"]
    assert "A.force.max lie -0.20 to +0.10 % from" in scatter_over_turns(told)


@pytest.mark.system("runs hundreds of turns")
def test_means_of_a_chaotic_motion_hold_where_single_turns_do_not() -> None:
    """At another step all turns are others; the mean over turns and companions is nearly the same.

    Largest values of turns are independent (their autocorrelation is below 0.06) and deviate by 0.48 to 0.66
    of their mean, so the logarithm of the ratio of two means of 23 turns and four lanes deviates by 0.66
    sqrt(2/92) = 0.097 at the most. Beyond 0.5, which is 5.1 times that, one of the three measures lies with a
    probability of 8e-7, and with one of 5e-8 where the deviation is 0.6. Two single turns differ by a factor
    of more than 2 with a probability of 0.5, so that none of 23 does comes with one of 1e-7.
    """
    one, other = (
        vfife.simulate(
            vfife.gallery.slider_crank_loose_pin(),
            turns=46,
            outputs=OUTPUTS,
            companions=3,
            step=math.pi / 50.0 / (parts * OUTPUTS),
            reference=False,
        )
        for parts in (150, 190)
    )
    turnly = [np.log(peaks(result, "contact_force_squared_max", 0)[23:]) / 2.0 for result in (one, other)]
    assert np.abs(turnly[1] - turnly[0]).max() > math.log(2.0)  # a single turn is anything
    for name in ("pin.force.max", "rod.angular_acceleration.max", "guide.force.max"):
        assert abs(math.log(other.measures[name] / one.measures[name])) < 0.5, name


def oscillator(damping: float) -> vfife.Mechanism:
    """A crank that turns at 10 rad/s, and beside it a block on a spring, pulled by a constant force, let go
    from where the spring is slack.
    """
    m = vfife.Mechanism("oscillator")
    for name, x in (("A", 0.0), ("G", 1.0), ("S", 1.5)):
        m.point(name, x, 0.0)
    m.link("crank", length=0.1, mass=1.0)
    m.revolute("A", "ground.A", "crank.start")
    m.drive("crank", speed=10.0)
    m.rigid_body("block", mass=MASS, inertia=1e-3, position=(1.0, 0.0))
    m.slider("G", "ground.G", "block.center")
    m.spring("S", "ground.S", "block.center", stiffness=STIFFNESS, damping=damping)
    m.force("pull", "block.center", force=(PULL, 0.0))
    return m


MASS, STIFFNESS, PULL = 1.0, 4000.0, 100.0


@pytest.mark.parametrize("decay", [0.8, 1.2])
def test_an_oscillator_settles_when_its_transient_has_gone(decay: float) -> None:
    """The spring bears P + exp(-d t) (...) by the closed form; from which turn on that repeats within 1 % is
    known without a run.
    """
    turn, outputs = 2.0 * math.pi / 10.0, 720
    result = vfife.simulate(
        oscillator(2.0 * decay * MASS), turns=20, outputs=outputs, settle=0.01, companions=0
    )
    omega = math.sqrt(STIFFNESS / MASS - decay**2)
    t = np.arange(20 * outputs * 8 + 1) * turn / (outputs * 8)
    x0 = -PULL / STIFFNESS  # from where it rests in the end
    x = np.exp(-decay * t) * x0 * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    a = (
        -2.0 * decay * (-np.exp(-decay * t) * x0 * (omega + decay**2 / omega) * np.sin(omega * t))
        - STIFFNESS / MASS * x
    )
    squares = (PULL - MASS * a) ** 2
    intervals = np.maximum(squares[1:].reshape(-1, 8).max(axis=1), squares[:-1:8]).reshape(20, outputs)
    apart = [
        float(np.abs(two - one).max() / max(one.max(), two.max()))
        for one, two in zip(intervals, intervals[1:], strict=False)
    ]
    wanted = 2 + next(k for k in range(len(apart)) if apart[k] <= 0.01)
    said = result.motion
    assert (
        said is not None
        and (said.motion, said.since, said.count) == ("periodic", wanted, wanted + 1)
        and 3 < wanted < 19
    )
    assert said.distance == pytest.approx(apart[wanted - 1], rel=0.05)
    assert math.log(apart[wanted - 1] / apart[wanted - 2]) == pytest.approx(-decay * turn, rel=0.05)


def test_statistics_over_turns_of_made_up_lanes() -> None:
    lanes = [[{"a": 1.0}, {"a": 2.0}], [{"a": 4.0}, {"a": 5.0}]]
    one, both = (
        over_turns(lanes, (1.0, 2.0), all_lanes=False)["a"],
        over_turns(lanes, (1.0, 2.0), all_lanes=True)["a"],
    )
    assert (one.value, one.low, one.high, one.lowest, one.highest) == (1.5, 1.5, 4.5, 1.0, 2.0)
    assert (both.value, both.low, both.high, both.lowest, both.highest) == (3.0, 1.5, 4.5, 1.0, 5.0)
    assert both.mean_error == 0.0, "turns of a periodic motion that scatter are no sample"
    chaotic = over_turns(lanes, (1.0, 2.0), all_lanes=True, chaotic=True)["a"]
    assert chaotic.mean_error > 0.0 and chaotic.draws("a") == pytest.approx(
        (3.0 - chaotic.mean_error, 3.0 + chaotic.mean_error)
    )
    assert Measured(2.0, lowest=1.0, highest=2.5).variation == 1.5


def test_a_run_file_gives_them_back(tmp_path: Path) -> None:
    result = settled()
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path)
    assert again.summary == result.summary and again.motion == result.motion
    for name, one in result.measures.items():
        other = again.measures[name]
        assert (one, one.low, one.high, one.lowest, one.highest) == (
            other,
            other.low,
            other.high,
            other.lowest,
            other.highest,
        )


# ------------------------------------------------------------------------------------------------------ turns


def test_turns_lie_over_each_other() -> None:
    result = settled()
    turns = result.turns
    assert (
        turns.sizes["turn"] == 8
        and turns.sizes["crank_angle"] == OUTPUTS
        and turns.turn.values.tolist() == list(range(2, 10))
    )
    assert turns.crank_angle.values == pytest.approx(np.arange(OUTPUTS) * 360.0 / OUTPUTS)
    force = result.data["joint_force"].sel(joint="C").values[1:].reshape(9, OUTPUTS)
    assert np.array_equal(turns["joint_force"].sel(joint="C").values, np.roll(force[1:], 1, axis=1))
    assert turns["joint_force"].dims == ("turn", "crank_angle", "joint") and turns["joint_force"].units == "N"
    assert float(turns.time.sel(turn=9)[0]) == pytest.approx(9 * TURN)  # at 0 degrees the turn ends
    assert turns.attrs["measures_of"] == result.measures.part


def test_turns_that_there_are_not_are_told() -> None:
    with pytest.raises(VfifeError, match="journal in bearing: there are no turns to lay over each other"):
        vfife.simulate(journal_in_bearing(), step="1 us", duration="0.1 ms", companions=0).turns  # noqa: B018


def test_turns_that_hold_no_whole_number_of_steps_are_compared_by_their_largest_values() -> None:
    result = vfife.simulate(four_bar("C"), turns=6, step="10.3 us", companions=0, reference=False)
    turns = result.motion
    assert turns is not None and turns.peaks_only and (turns.motion, turns.period) == ("periodic", 1)
    ends = [
        round(turn * result.record.assembly.choice.turn / (result.time[1] - result.time[0]))
        for turn in range(7)
    ]  # type: ignore[operator]
    peaks = [
        math.sqrt(result.record.block("contact_force_squared_max")[first + 1 : last + 1, 0].max())
        for first, last in zip(ends[turns.first - 1 : -1], ends[turns.first :], strict=True)
    ]
    force = result.measures["C.force.max"]
    assert force.value == pytest.approx(np.mean(peaks), rel=1e-14)
    assert (force.lowest, force.highest) == pytest.approx((min(peaks), max(peaks)), rel=1e-14)
    (note,) = result.summary["run"]["notes"]
    assert "does not divide a turn" in note and "largest values only" in note
    assert "does not divide a turn" in " ".join(str(result).split())
    remedy = float(note.rpartition("Take a step of ")[2].partition(" s")[0])
    finer = vfife.simulate(four_bar("C"), turns=2, step=remedy, companions=0, reference=False)
    assert finer.motion is not None and not finer.motion.peaks_only and not finer.summary["run"]["notes"]
    with pytest.raises(VfifeError, match="a step that divides a turn"):
        result.turns  # noqa: B018


def test_companions_keep_turns_that_end_between_outputs(tmp_path: Path) -> None:
    """Their values and those of the run are of the same times, from a file too, and after a continuation."""
    options = {"step": "10.3 us", "outputs": 100, "companions": 2, "reference": False}
    result = vfife.simulate(four_bar("C"), turns=5, file=tmp_path / "run.sqlite", **options)  # type: ignore[arg-type]
    companions = result.record.companions
    assert companions is not None and companions.turns.shape[0] == 5
    force = result.measures["C.force.max"]
    assert force.low < force.value < force.high < 1.2 * force.low
    read = vfife.load_result(tmp_path / "run.sqlite")
    assert read.measures == result.measures and read.motion == result.motion


def test_too_few_outputs_to_tell_turns_apart_are_named_in_the_first_lines() -> None:
    result = vfife.simulate(four_bar(""), turns=6, step="10.3 us", outputs=10, reference=False)
    assert result.motion is None and result.summary["turns"] == {}
    assert dict(result.measures) == measures(result.record)
    first_lines = " ".join(str(result).split())[:400]
    assert "turns cannot be compared" in first_lines and "last turn alone" in first_lines


# --------------------------------------------------------------------------------------------------------
# until it repeats


def test_a_run_ends_when_it_has_settled() -> None:
    """Two turns in a row are within the tolerance; the bits are those of a run that went on."""
    result, longer = (
        vfife.simulate(four_bar("BCD"), turns=9, step="5 us", outputs=OUTPUTS, companions=3, settle=one)
        for one in ("0.2 %", None)
    )
    done = len(result.record.steps)
    assert result.record.status == "complete" and 5 * OUTPUTS < done < 9 * OUTPUTS and done % OUTPUTS == 1
    assert np.array_equal(result.record.rows, longer.record.rows[:done])
    said = result.motion
    assert said is not None and (said.motion, said.since, said.tolerance) == (
        "periodic",
        said.count - 1,
        0.002,
    )
    assert result.record.companions is not None and len(result.record.companions.turns) == said.count
    assert result.record.final is not None


def test_it_goes_on_to_the_end_where_it_does_not_repeat() -> None:
    result = vfife.simulate(
        four_bar("BCD"), turns=3, step="5 us", outputs=OUTPUTS, companions=0, settle=1e-6, reference=False
    )
    assert len(result.record.steps) == 3 * OUTPUTS + 1 and result.record.status == "complete"


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"settle": 0.0}, "zero or negative"),
        ({"settle": 2.0}, "above 0 and at most 0.2"),
        ({"settle": 1}, 'This is 100 %; is "1 %" meant'),
        ({"settle": "5"}, 'This is 500 %; is "5 %" meant'),
        ({"settle": "30 %"}, "too large"),
        ({"settle": 0.25}, "This is 25 %"),
        ({"settle": "soon"}, "settle"),
    ],
)
def test_a_tolerance_that_cannot_be_is_told(given: dict[str, object], match: str) -> None:
    with pytest.raises(ModelError, match=match):
        vfife.simulate(four_bar("C"), **given)  # type: ignore[arg-type]


def test_what_has_no_turns_cannot_repeat_them() -> None:
    m = journal_in_bearing()
    m.settings = dataclasses.replace(m.settings, settle=0.01)
    with pytest.raises(ModelError, match="no crank turns at constant speed"):
        vfife.simulate(m, duration="1 ms")


# ------------------------------------------------------------------------------------------------------------
# as it is told


def text_of(result: Result) -> str:
    console = Console(width=150, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    show(console, result, result.reference)
    return console.export_text()


def test_every_table_says_which_part_of_the_run_it_is_of() -> None:
    result, said = settled(), settled().motion
    assert said is not None
    text = text_of(result)
    part = f"mean of turns {said.first} to 9"
    assert result.measures.part == result.summary["part"] == part and part in repr(result.measures)
    assert (
        f"Largest reactions ({part})" in text
        and f"Largest angular accelerations ({part})" in text
        and "Contact (whole run)" in text
    )
    assert f"repeats itself from turn {said.since} on" in text
    short = vfife.simulate(four_bar("C"), turns=2, step="10 us", companions=0, reference=False)
    assert "Largest reactions (last turn, the 2nd)" in text_of(short)
    half = vfife.simulate(four_bar("C"), turns=0.5, step="10 us", companions=0, reference=False)
    assert "Largest reactions (whole run)" in text_of(half)
    odd = vfife.simulate(
        four_bar("C"), turns=2.3, step="10 us", companions=0, reference=False
    )  # the last 360 degrees are of two turns
    assert odd.measures.part == "last turn" and odd.motion is not None and odd.motion.count == 2
    assert "of turns 7 to 12, of the run and 3 companions)" in text_of(
        astray()
    ) and "lowest to highest turn" in text_of(astray())


def test_digits_are_no_finer_than_what_is_known() -> None:
    assert (
        amount(73979.5, "N", 25.3) == "73,980 N"
        and amount(73979.5, "N", 310.0) == "74,000 N"
        and amount(2.4637, "N", 0.3) == "2.5 N"
    )
    assert (
        amount(73979.53, "N") == "73,979.5 N"
        and amount(40.19487, "N") == "40.19 N"
        and amount(40.19487, "N", 1e-9) == "40.19 N"
    )
    assert (
        percent(156.39, 40.0) == "160 %"
        and percent(28.2406, 0.04) == "28.24 %"
        and percent(28.2406) == "28.24 %"
        and percent(None) == ""
    )
    for value in (3.0, 47.11, 815.0, 14500.0):
        for spread in (0.004, 0.07, 3.0, 55.0):
            places = decimals(value, spread)
            assert (
                places <= -math.floor(math.log10(spread)) or 10.0**-places > 0.1 * value
            )  # none finer, but one at the least
            assert abs(round(value, places) - value) <= 0.5 * max(10.0**-places, 1e-9)
    told = {
        "measures": {"a": 14512.3, "b": 4.2e-5, "c": 7.0},
        "ranges": {"a": {"low": 14400.0, "high": 14700.0}},
        "turns": {},
    }
    assert [plain_number(told, name) for name in told["measures"]] == ["14500", "4.2e-05", "7"]
    assert (
        measure_text(told, "a", "N") == "14.5 kN"
        and prefixed(3.756e-3, "N m", 0.9) == "4 mN m"
        and prefixed(142.5e-6, "m", 3e-6) == "142 µm"
    )
