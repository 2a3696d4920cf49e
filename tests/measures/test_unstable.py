"""Companions and tries that blew up: they have no part in ranges, and the answer says so."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import vfife
from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.measures.energy import COMPANION_WORKS, is_unstable, unstable_companions
from vfife.measures.error_ranges import (
    over_tries,
    ranged,
    ranges_of_next_try,
    sensitive_tries,
    sound_companions,
    tries_blew_up,
)
from vfife.measures.trust import HALVINGS, UNSTABLE_TRY, finer, trust
from vfife.report.overview import certainty
from vfife.report.summary import run_summary
from vfife.report.trust import trust_summary, verdict
from vfife.simulation.result import Result
from vfife.solvers.record import Record
from vfife.solvers.transient import run

STEP = 2e-6  # s, so that all companions have larger steps


def scaled(record: Record, companion: int, factor: float, names: tuple[str, ...]) -> None:
    """Multiply rows of a companion."""
    companions, layout = record.companions, record.assembly.layout
    assert companions is not None
    rows = [row for name in names for row in layout.rows_of(name).tolist()]
    columns = np.isin(companions.row_numbers, rows)
    companions.rows[:, columns, companion] *= factor
    if companions.turns.size:
        companions.turns[:, columns, companion] *= factor
    companions.burst = None


@pytest.fixture
def record() -> Record:
    result = run(assemble(four_bar("C"), STEP, turns=1.0), companions=3)
    assert result.companions is not None
    assert (result.companions.counts < result.assembly.choice.outputs_every).all()
    return result


def test_a_companion_that_blew_up_has_no_part_in_ranges(record: Record) -> None:
    assert record.companions is not None and record.companions.counts[2] < record.companions.counts[0]
    assert sound_companions(record) == [0, 1, 2] and unstable_companions(record) == ()
    high = ranged(record)["C.force.max"].high
    scaled(record, 2, 1e8, ("contact_force_squared_max",))
    assert sound_companions(record) == [0, 1, 2], "a force alone may be small in the run by chance"
    assert ranged(record)["C.force.max"].high > 1e3 * high
    scaled(record, 2, 1e8, COMPANION_WORKS)
    assert sound_companions(record) == [0, 1] and unstable_companions(record) == (2,)
    assert ranged(record)["C.force.max"].high < 2.0 * high
    judgement = trust(record)
    assert judgement is not None and judgement.lost == 1 and judgement.sensitive and not judgement.unstable


def test_tries_that_blew_up_are_left_out_and_one_more_is_made(record: Record) -> None:
    scaled(record, 2, 1e8, ("contact_force_squared_max", *COMPANION_WORKS))
    companions = record.companions
    assert companions is not None
    companions.tries = {"C.force.max": (1.0, 2.0)}
    assert ranges_of_next_try(record, None) == ({}, {"C.force.max": (1.0, 2.0)})
    former = tuple((STEP * 2.0**k, UNSTABLE_TRY) for k in range(HALVINGS, 0, -1))

    def choose(tried):
        choice = dataclasses.replace(record.assembly.choice, automatic=True, tried=tried)
        record.assembly = dataclasses.replace(record.assembly, choice=choice)
        return finer(record)

    assert choose(former) == (*former, (STEP, UNSTABLE_TRY)), "one more than usual"
    assert choose((*former, (STEP, UNSTABLE_TRY))) is None


@pytest.mark.parametrize(
    ("times", "spread", "is_stable"), [(40.0, 1e-5, False), (5.0, 1e-5, True), (40.0, 0.1, True)]
)
def test_a_try_that_blew_up_for_a_moment_is_left_out(record: Record, times, spread, is_stable) -> None:
    """Where the run and the last try agree; else its values are draws from the same scatter."""
    companions, name = record.companions, "C.force.max"
    assert companions is not None
    scaled(record, 2, 9.0, ("body_alpha_max",))  # sensitive by an acceleration alone
    own = over_tries(record)[name]
    assert own.width < 1e-3 * own.value
    companions.earlier = {name: (own.value * (1.0 - spread), own.value)}
    companions.tries = {name: (own.value * (1.0 - spread), own.value * times)}
    assert sensitive_tries(record) == (companions.tries if is_stable else companions.earlier)
    assert tries_blew_up(record) == (not is_stable)
    assert (ranged(record)[name].high < 1.01 * own.value) == (not is_stable)
    tried = ((2.0 * STEP, 1.0 - 1e-4), (1.5 * STEP, 0.2), (1.2 * STEP, None))
    choice = dataclasses.replace(record.assembly.choice, automatic=True, tried=tried)
    record.assembly = dataclasses.replace(record.assembly, choice=choice)
    shares = [trial["apart"] for trial in trust_summary(Result(record))["tried"]]
    assert shares == [1.0 - 1e-4 if is_stable else UNSTABLE_TRY, 0.2, None]


def test_a_run_whose_companions_are_all_lost_is_unstable(record: Record) -> None:
    for companion in range(3):
        scaled(record, companion, 1e8, ("contact_force_squared_max", *COMPANION_WORKS))
    judgement = trust(record)
    assert is_unstable(record) and judgement is not None and judgement.unstable


def test_the_answer_names_what_is_left_out() -> None:
    summary = run_summary(vfife.simulate(four_bar("C"), turns=1, step=1e-5))
    lost = summary | {"trust": summary["trust"] | {"lost": 1, "sensitive": True, "apart": 1.0}}
    assert "of 3 runs with other step sizes 1 diverged or blew up, and ranges leave them out" in verdict(lost)
    unstable = lost | {"trust": lost["trust"] | {"unstable": True}}
    assert verdict(unstable).startswith("The step of 10 µs is unstable") and "sensitive" not in verdict(
        unstable
    )
    tried = summary | {
        "trust": summary["trust"] | {"tried": [{"step": 2e-5, "apart": UNSTABLE_TRY}], "automatic": True}
    }
    assert "20 µs, runs diverged or blew up: ranges leave those out" in certainty(tried)


def test_values_that_grow_at_larger_steps_are_no_reactions_in_a_singular_position() -> None:
    summary = run_summary(vfife.simulate(four_bar("C"), turns=1, step=1e-5))
    name = "C.force.max"
    bounds = summary["ranges"][name] | {"high": 1e9 * summary["measures"][name]}
    wild = summary | {
        "ranges": summary["ranges"] | {name: bounds},
        "trust": summary["trust"] | {"measure": name, "sensitive": True},
    }
    assert "not determined" in verdict(wild) and "at larger steps" in verdict(wild)
    assert "as the step becomes smaller" not in verdict(wild)
