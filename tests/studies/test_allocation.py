"""Allocation of fits, where a measure is linear in the clearances, so that its quantile is known, against
trying every choice.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from vfife.errors import Fault, VfifeError
from vfife.studies.methods.allocation import (
    AllocationTable,
    Option,
    allocate,
    by_cost,
    options_of,
    same_grades,
)
from vfife.studies.spec.distributions import Array, Normal

SLOPES = np.array([3.0, 1.0, 2.0])
TABLE = AllocationTable("C.force.max", seed=0)
COSTS = {"IT6": 9.0, "IT7": 5.5, "IT8": 3.2, "IT9": 2.0}
JOINTS = [options_of("H/f", size, COSTS) for size in (0.02, 0.04, 0.012)]


def linear(rows: Sequence[Sequence[float]]) -> Array:
    return np.asarray(np.asarray(rows) @ SLOPES)


def closed_form(options: Sequence[Option], share: float) -> float:
    """Quantile of the sum of six truncated normal numbers, in all but name a normal one: mean and variance
    are exact.
    """
    kept = 1 - 6 * stats.norm.pdf(3) / (2 * stats.norm.cdf(3) - 1)
    mean, variance = 0.0, 0.0
    for slope, option in zip(SLOPES, options, strict=True):
        fit = option.clearance.fit  # type: ignore[attr-defined]
        mean += slope * 0.25 * (fit.least + fit.most)
        variance += kept * (slope / 2) ** 2 * sum((zone.width / 6) ** 2 for zone in (fit.hole, fit.shaft))
    return mean + stats.norm.ppf(share) * math.sqrt(variance)


@pytest.mark.parametrize("limit", [120e-6, 150e-6])
def test_the_cheapest_is_that_of_all_choices(limit: float) -> None:
    """Of 7³ choices, each with its closed form. A sample that shall show 99 % with confidence asks for a
    little more than that: the choice taken keeps the limit, and no choice cheaper than it would keep it by a
    tenth of what its clearance scatters.
    """
    every = sorted(
        (math.fsum(one.cost for one in options), closed_form(options, 0.99))
        for options in itertools.product(*JOINTS)
    )
    found = allocate(JOINTS, linear, limit, replace(TABLE, count=1000, seed=2))
    assert found.choice is not None and found.estimate is not None
    assert closed_form(found.choice.options, 0.99) <= limit
    assert found.estimate.value == pytest.approx(closed_form(found.choice.options, 0.99), rel=0.02)
    cheapest = next(cost for cost, value in every if value <= limit)
    assert found.choice.cost == pytest.approx(cheapest) or all(
        value > 0.97 * limit for cost, value in every if cost < found.choice.cost - 1e-9
    )
    assert all(one.cost <= found.choice.cost for one in found.rejected)
    assert found.machines < 0.25 * 1000 * len(every)


def test_it_is_what_trying_every_choice_finds() -> None:
    """The same machines, all choices in full, no order and no short cut."""
    limit, count = 140e-6, 500
    from vfife.studies.spec.distributions import places
    from vfife.studies.spec.limits import allowed_failures

    unit, allowed = places("random", count, 3, 5), allowed_failures(count, 0.05, 0.9)
    drawn = [
        [(one.cost, slope * one.clearance.quantile(unit[:, k])) for one in JOINTS[k]]
        for k, slope in enumerate(SLOPES)
    ]
    passing = []
    for options in itertools.product(*drawn):
        if np.count_nonzero(sum(values for _, values in options) > limit) <= allowed:
            passing.append(math.fsum(cost for cost, _ in options))
    found = allocate(JOINTS, linear, limit, replace(TABLE, share=0.95, confidence=0.9, count=count, seed=5))
    assert found.choice is not None
    assert found.choice.cost == pytest.approx(min(passing))
    assert found.failures <= allowed


def test_choices_come_by_cost_each_once() -> None:
    every = list(by_cost(JOINTS))
    assert len({one.names for one in every}) == len(every) == math.prod(map(len, JOINTS))
    assert [one.cost for one in every] == pytest.approx(
        sorted(math.fsum(o.cost for o in two) for two in itertools.product(*JOINTS))
    )


def test_nothing_that_keeps_the_limit_is_told() -> None:
    found = allocate(JOINTS[:1], lambda rows: linear([[*row, 0, 0] for row in rows]), 1e-6, TABLE)
    assert found.choice is None and found.estimate is None
    assert len(found.rejected) == len(JOINTS[0])
    assert found.machines < 299


def test_a_machine_without_a_value_is_beyond_the_limit() -> None:
    option = Option("any", 1.0, Normal(1.0, 0.1))
    assert allocate([[option]], lambda rows: np.full(len(rows), math.nan), 10.0, TABLE).choice is None
    found = allocate([[option]], lambda rows: np.ones(len(rows)), 1.0, TABLE)
    assert found.choice is not None and (found.failures, found.count) == (0, 299)


@pytest.mark.parametrize(("bad", "taken"), [(1, True), (2, False)])
def test_one_of_473_may_fail_and_no_second(bad: int, taken: bool) -> None:
    """Whichever they are: the last that are asked for."""
    asked = 0

    def failing(rows: Sequence[Sequence[float]]) -> Array:
        nonlocal asked
        asked += len(rows)
        return np.array([2.0 if k > 473 - bad else 1.0 for k in range(asked - len(rows) + 1, asked + 1)])

    found = allocate([[Option("any", 1.0, Normal(1.0, 0.1))]], failing, 1.5, replace(TABLE, count=473))
    assert (found.choice is not None) is taken
    assert found.machines == asked == 473


def test_options_are_pairs_of_grades_or_fits() -> None:
    assert {one.name: one.cost for one in options_of("H/g", 0.02, {"IT6": 4.0, "IT7": 2.5})} == {
        "H6/g6": 8.0,
        "H7/g6": 6.5,
        "H7/g7": 5.0,
    }
    assert [one.name for one in options_of("", 0.02, {"H7/g6": 3.0, "H8/f7": 1.0})] == ["H8/f7", "H7/g6"]


@pytest.mark.parametrize(
    ("letters", "costs", "said"),
    [
        ("H/f", {}, "no costs"),
        ("H/f", {"IT7": -1.0}, "an invalid cost"),
        ("H/f", {"IT7": math.nan}, "an invalid cost"),
        ("Hf", {"IT7": 1.0}, "not the letters"),
        ("H/f", {"7": 1.0}, "neither"),
        ("H/f", {"IT7": 1.0, "H8/f7": 2.0}, "neither"),
        ("H/k", {"IT7": 1.0}, "transition"),
        ("H/f", {"IT19": 1.0}, "grade"),
    ],
)
def test_what_is_no_option_is_refused(letters: str, costs: dict[str, float], said: str) -> None:
    with pytest.raises(Fault, match=said):
        options_of(letters, 0.02, costs)


def test_too_few_machines_and_too_many_choices_are_refused() -> None:
    with pytest.raises(Fault, match="too few machines"):
        allocate(JOINTS, linear, 1.0, replace(TABLE, count=298))
    with pytest.raises(VfifeError, match="choices of fits"):
        allocate(JOINTS * 3, linear, 1.0, TABLE)


SIZES = (0.02, 0.04, 0.012, 0.02, 0.03)
SLOPES_OF_FIVE = np.array([3.0, 1.0, 2.0, 0.1, 4.0])
FIVE = [options_of("H/f", size, COSTS) for size in SIZES]


def five(slopes: Array) -> Callable[[Sequence[Sequence[float]]], Array]:
    return lambda rows: np.asarray(np.asarray(rows) @ slopes)


def test_a_descent_finds_fits_of_five_joints_with_few_machines_none_of_which_may_be_cheaper() -> None:
    """All 16,807 choices cost more than 100,000 machines. The answer costs hardly more than the cheapest."""
    table, evaluate = replace(TABLE, count=300, search="descent"), five(SLOPES_OF_FIVE)
    found = allocate(FIVE, evaluate, 330e-6, table)
    assert found.choice is not None and found.estimate is not None and found.estimate.value <= 330e-6
    assert found.machines < 5000 and len(set(found.choice.names)) > 1
    cheapest = allocate(FIVE, evaluate, 330e-6, replace(table, search="all"))
    assert cheapest.choice is not None and found.choice.cost <= 1.15 * cheapest.choice.cost
    for joint in range(5):
        cheaper = [option for option in FIVE[joint] if option.cost < found.choice.options[joint].cost]
        for option in cheaper:
            options = [[one] for one in found.choice.options]
            options[joint] = [option]
            assert allocate(options, evaluate, 330e-6, replace(table, search="all")).choice is None


def test_where_more_clearance_makes_the_measure_smaller_fits_of_a_descent_are_loose_there() -> None:
    slopes = np.array([3.0, -4.0, 2.0, 0.1, -3.0])
    evaluate, table = five(slopes), replace(TABLE, count=300)
    assert allocate(FIVE, evaluate, -80e-6, replace(table, search="same")).choice is None
    found = allocate(FIVE, evaluate, -80e-6, replace(table, search="descent"))
    assert found.choice is not None and found.estimate is not None and found.estimate.value <= -80e-6
    assert found.choice.names[1] == found.choice.names[4] == "H9/f9"


def test_the_same_fit_in_all_joints_is_the_cheapest_that_passes() -> None:
    evaluate, table = five(SLOPES_OF_FIVE), replace(TABLE, count=300, search="same")
    found = allocate(FIVE, evaluate, 330e-6, table)
    assert found.choice is not None and len(set(found.choice.names)) == 1
    letters = [options_of("H/f", SIZES[0], COSTS), options_of("H/g", SIZES[1], COSTS)]
    grades = {tuple(name[1] + name[-1] for name in choice.names) for choice in same_grades(letters)}
    assert len(grades) == 7 and all(first == second for first, second in grades)
    with pytest.raises(VfifeError, match="no grades in common"):
        next(
            same_grades(
                [
                    options_of("H/f", 0.02, {"IT6": 1, "IT7": 2}),
                    options_of("H/f", 0.02, {"IT9": 1, "IT10": 2}),
                ]
            )
        )
