"""Turns compared, starts in blocks, onsets within their step: arithmetic of numbers that a test writes."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.solvers import repeating
from vfife.solvers.companions import oldest_needed
from vfife.solvers.impact_section import PER_CONTACT, WIDE, ImpactSection, Sectioning
from vfife.solvers.repeating import Comparison, distance, outputs_per_turn, repeated_since
from vfife.solvers.tangents import Neighbours, weights
from vfife.solvers.turn_runner import LANES, Orbits, Start, TurnRunner


def test_two_turns_are_apart_by_the_worst_quantity() -> None:
    """The largest difference over the largest absolute value of both; zeros do not count; what is small is
    compared with its least.
    """
    before = np.array([[1.0, 10.0, 0.0], [-4.0, 20.0, 0.0]])
    after = np.array([[1.5, 10.0, 0.0], [-3.0, 25.0, 0.0]])
    assert distance(before, after) == pytest.approx(1.0 / 4.0) == distance(after, before)
    assert distance(before, after, np.array([10.0, 0.0, 0.0])) == pytest.approx(5.0 / 25.0)
    assert distance(before, before) == 0.0 == distance(np.zeros((2, 2)), np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("turn", "step", "every", "count"),
    [(0.1, 1e-4, 10, 100), (0.1, 1e-4, 11, None), (None, 1e-4, 10, None), (1e-4, 1e-3, 1, None)],
)
def test_a_turn_holds_a_whole_number_of_outputs_or_none(
    turn: float | None, step: float, every: int, count: int | None
) -> None:
    choice: Any = SimpleNamespace(turn=turn, step=step, outputs_every=every)
    assert outputs_per_turn(choice) == count
    if count:
        choice.turn = turn * (1.0 + 1e-8)
        assert outputs_per_turn(choice) is None, "by a hundred-millionth is not"


class Plain:
    """A comparison by the largest difference."""

    def distance(self, before: np.ndarray, after: np.ndarray) -> float:
        return float(np.abs(before - after).max())


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([5.0, 1.0, 1.0], (1, 3)),
        ([1.0, 1.0], (1, 2)),
        ([1.0], None),
        ([9.0, 1.0, 2.0, 1.0, 2.0], (2, 4)),
        ([1.0, 2.0, 1.0, 3.0], None),
        ([9.0, 1.0, 2.0, 1.0], None),
        ([*range(8)] * 2, (8, 9)),
        ([*range(9)] * 2, None),
    ],
)
def test_the_shortest_period_counts_from_the_first_turn_that_repeats(
    values: list[float], found: tuple[int, int] | None
) -> None:
    """A period of p turns is seen when as many turns as it has repeat the ones p before; up to eight."""
    turns = [np.array([[float(one)]]) for one in values]
    assert repeated_since(turns, Plain(), 0.01) == found  # type: ignore[arg-type]


def test_small_forces_are_compared_with_a_tenth_of_the_largest_and_noise_with_what_carries() -> None:
    assembly = assemble(four_bar("C"), 1e-6, turns=1, force_step=True)
    kept = np.arange(assembly.layout.rows, dtype=np.uint32)
    comparison = Comparison(assembly, kept)
    speed = 2.0 * np.pi / assembly.choice.turn  # of the crank: a hundredth of w^2 is compared with that
    size = np.zeros(len(comparison.rows))
    families = comparison.families
    size[families["squares"]] = 9.0
    size[families["squares"][0]] = 1e6  # 1 kN
    size[families["accelerations"]] = 50.0
    least = comparison.smallest_scale(size)
    assert least[families["squares"]] == pytest.approx(1e4) and least[families["accelerations"][0]] >= 5.0
    assert least[families["moments"]] == pytest.approx(1e-5 * 1e3)
    assert least[families["accelerations"][0]] == pytest.approx(
        max(5.0, repeating.OVER_NOISE * repeating.ROUNDING / 1e-12, 1e-2 * speed * speed)
    )
    assert least[families["contact_normal_force"]] == pytest.approx(0.0)


def test_a_small_force_is_compared_with_the_largest_of_either_turn() -> None:
    """1 kN in one output of one turn: a force of 10 N that comes and goes is a hundredth of what counts, a
    tenth of that.
    """
    assembly = assemble(four_bar("C"), 1e-6, turns=1, force_step=True)
    comparison = Comparison(assembly, np.arange(assembly.layout.rows, dtype=np.uint32))
    large, small = comparison.families["squares"][:2]
    before = np.zeros((4, len(comparison.rows)))
    before[2, large] = 1e6
    after = 0.998 * before
    after[1, small] = 100.0
    assert (
        comparison.distance(before, after)
        == pytest.approx(100.0 / 1e4, rel=1e-9)
        == comparison.distance(after, before)
    )


def test_companions_keep_the_rows_of_the_last_turn() -> None:
    """A hundred steps back; all of a shorter run, and all without a crank. Of a turn that begins between two
    outputs, ten steps apart, from the one before its beginning.
    """

    def kept(turn: float | None, last: int) -> int:
        choice = SimpleNamespace(turn=turn, step=1e-3, outputs_every=10)
        return oldest_needed(SimpleNamespace(choice=choice), last)  # type: ignore[arg-type]

    assert [kept(0.1, 1000), kept(0.1, 60), kept(None, 1000)] == [900, 0, 0]
    assert [-(-kept(turn, 1000) // 10) for turn in (0.1004, 0.1006, 0.1099, 0.1101)] == [89, 89, 89, 88]


# ----------------------------------------------------------------------------------------------------- starts


def crank() -> Any:
    """An assembly with so many steps in a turn that a turn at 1/1000 of it is a step."""
    return assemble(
        four_bar("C", speed=50.0), 2.0 * math.pi / 50.0 / 1000, turns=1, outputs=1, force_step=True
    )


def test_motions_begin_a_turn_before_and_at_the_phase() -> None:
    begins = [TurnRunner([crank()], phase).begins for phase in (0.0, 0.25, 0.999, 1.0, -0.25)]
    assert begins == [1001, 1251, 2000, 1001, 1751]


def test_members_as_far_before_the_phase_go_side_by_side() -> None:
    of = Orbits(100, 5, 2)
    starts = [Start(k, lambda: None, 0.5 * (k % 2)) for k in range(11)]  # type: ignore[arg-type,return-value]
    found = [[one.number for one in block] for block in of.blocks(starts)]
    assert found == [[0, 2, 4, 6], [8, 10], [1, 3, 5, 7], [9]] and LANES == 4


def test_members_make_their_turns_and_are_looked_at_once_in_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first step by itself, what comes before the last turn that is dropped, that turn at 36 outputs with
    its rest, then three turns.
    """
    calls: list[tuple[int, int]] = []
    runner = TurnRunner([crank()], 0.25)
    advance = runner.pace.advance
    monkeypatch.setattr(
        runner.pace,
        "advance",
        lambda which, steps, outputs: calls.append((steps, outputs)) or advance(which, steps, outputs),
    )
    path, rows, growth = Orbits(1000, 5, 2).record_turns(runner)
    assert (
        calls == [(2250, 1), (27, 37), (1, 1), (1000, 3)]
        and path.shape == (37, len(runner.row_numbers), 1)
        and rows.shape == (3, len(runner.row_numbers), 1)
        and growth.shape == (0, LANES)
    )
    assert runner.done == 1251 + 5000


def test_pieces_of_a_section_end_where_turns_are_dropped() -> None:
    """Ten turns before those that are looked at a difference begins; no piece has more than fifty turns, and
    none crosses an end.
    """
    near = Neighbours(crank(), crank(), 1.0)
    one = Sectioning(crank(), near, 0.25, 180, 75)
    assert one.cuts == [(0, 50), (50, 65), (65, 75), (75, 125), (125, 175), (175, 180)]
    assert (one.motion.begins, one.lead, one.dropped) == (1251, 65, 75)
    few = Sectioning(crank(), near, 1.0, 8, 4)
    assert few.cuts == [(0, 4), (4, 8)] and few.lead == 0 and few.motion.begins == 1001


def test_differences_count_by_kinetic_energy_and_by_a_radian_of_the_crank() -> None:
    assembly = assemble(four_bar("C", speed=50.0), 1e-6, turns=1, force_step=True)
    found, layout = weights(assembly), assembly.layout
    mass = assembly.bodies["coupler"].mass
    p = assembly.bodies["coupler"].particles[0]
    root, inertia = math.sqrt(mass), math.sqrt(1.0 / assembly.state[layout["particle_inverse_inertia"]][p])
    for axis, rate, size in (("x", "u", root), ("y", "v", root), ("theta", "w", inertia)):
        assert found[layout[f"particle_{rate}"]][p] == pytest.approx(size, rel=1e-12)
        assert found[layout[f"particle_{axis}"]][p] == pytest.approx(50.0 * size, rel=1e-12)
    crank = assembly.bodies["crank"].particles[0]
    assert found[layout["particle_u"]][crank] == 0.0 == found[layout["contact_memory"]].sum()


# ----------------------------------------------------------------------------------------------------- onsets


def struck() -> ImpactSection:
    assembly = assemble(four_bar("BC", speed=50.0), 1e-6, turns=1, force_step=True)
    return ImpactSection.of(assembly, (0, 1))


def test_an_onset_lies_within_its_step_where_the_penetration_passes_zero() -> None:
    """From -3 to 1 um: three quarters into the step; the crank, the place and the speed are those there."""
    one = struck()
    rows = np.zeros((4, 1 + 2 * WIDE))
    rows[:, 0] = [1.0, 1.1, 1.3, 1.6]  # crank
    own = rows[:, 1 + WIDE :]  # of the second contact
    own[:, 0], own[:, 1], own[:, 2] = [5, 5, 6, 6], [2.0, 2.0, 2.3, 2.3], [-9e-6, -3e-6, 1e-6, 2e-6]
    start = len(PER_CONTACT)
    own[:, start + 3], own[:, start + 4] = (
        [0.0, 1.0, 5.0, 5.0],
        [0.0, 2.0, 2.0, 2.0],
    )  # the journal's body moves to x = 4 at the onset
    ((contact, time, crank, place, speed, count),) = one._onsets(rows, 100, 1)
    assert (contact, count) == (1.0, 1.0) and speed == pytest.approx(0.3)
    assert time == pytest.approx((100 + 1 + 0.75) * one.assembly.choice.step, rel=1e-12)
    assert crank == pytest.approx(1.1 + 0.75 * 0.2, rel=1e-12)
    layout, state = one.assembly.layout, one.assembly.state
    pins = {
        side: [state[layout.row(f"contact_{side}_{axis}", 1)] for axis in "xy"]
        for side in ("bearing", "journal")
    }
    x, y = 4.0 + pins["journal"][0] - pins["bearing"][0], 2.0 + pins["journal"][1] - pins["bearing"][1]
    assert place == pytest.approx(math.atan2(y, x) % math.tau, rel=1e-9)
    assert one._onsets(rows, 100, 0).shape == (0, 6), "the first contact did not begin"


def test_an_onset_without_a_passage_lies_in_the_middle_of_its_step() -> None:
    """A contact that ended and began again within a step: its penetration is above zero at both ends, and
    there were two.
    """
    one = struck()
    rows = np.zeros((2, 1 + 2 * WIDE))
    rows[:, 1], rows[:, 2], rows[:, 3] = [1, 3], [0.1, 0.7], [1e-6, 2e-6]
    ((_, time, _, _, speed, count),) = one._onsets(rows, 0, 0)
    assert (
        time == pytest.approx(0.5 * one.assembly.choice.step) and speed == pytest.approx(0.3) and count == 2.0
    )


def test_the_rows_of_an_onset_are_those_of_its_contact_and_bodies() -> None:
    one = struck()
    layout, topology = one.assembly.layout, one.assembly.topology
    assert len(one.rows) == 1 + 2 * WIDE and one.rows[0] == layout.row("particle_theta", topology.driven[0])
    for k in (0, 1):
        own = one.rows[1 + WIDE * k : 1 + WIDE * (k + 1)]
        assert own[:3].tolist() == [layout.row(name, k) for name in PER_CONTACT]
        assert own[5] == layout.row("particle_theta", topology.contact_bearing[k])
        assert own[8] == layout.row("particle_theta", topology.contact_journal[k])
