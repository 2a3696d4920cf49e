"""Searches whose answers are known: a parabola, a limit that binds, the front of two parabolas; and a search
that is broken off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from vfife.errors import VfifeError
from vfife.studies.methods import optimise
from vfife.studies.methods.optimise import (
    Axis,
    Candidate,
    Parameters,
    Search,
    Values,
    ask_and_tell,
    pareto_front,
)
from vfife.studies.spec.limits import Bound

pytest.importorskip("optuna")

XY = (Axis("x", -2.0, 3.0), Axis("y", 0.1, 10.0, logarithmic=True))


def parabola(asked: Sequence[Parameters]) -> list[Values | None]:
    """Least, 1, at x = 1, y = 1."""
    return [
        {"f": 1 + (float(one["x"]) - 1) ** 2 + math.log(float(one["y"])) ** 2, "x": float(one["x"])}
        for one in asked
    ]


def test_the_least_is_found() -> None:
    search = Search(XY, ("f",), cases=112, seed=1)
    (found,) = pareto_front(search, ask_and_tell(search, parabola))
    assert found.values is not None
    assert found.values["f"] == pytest.approx(1.0, abs=0.03)
    assert found.parameters["x"] == pytest.approx(1.0, abs=0.2)


def test_a_limit_binds() -> None:
    """At most 0.5 of x: the least is 1.25, on the limit."""
    search = Search(XY, ("f",), (Bound("x", high=0.5),), cases=112, seed=1)
    cases = ask_and_tell(search, parabola)
    (found,) = pareto_front(search, cases)
    assert found.parameters["x"] <= 0.5
    assert found.values is not None and found.values["f"] == pytest.approx(1.25, abs=0.08)
    assert any(not one.feasible for one in cases)


def two(asked: Sequence[Parameters]) -> list[Values | None]:
    return [{"a": float(one["x"]) ** 2, "b": (float(one["x"]) - 2) ** 2} for one in asked]


def test_the_front_of_two_parabolas() -> None:
    """x² and (x - 2)²: the front is √a + √b = 2, and none of it dominates another."""
    search = Search(XY[:1], ("a", "b"), cases=96, seed=2)
    front = pareto_front(search, ask_and_tell(search, two))
    assert len(front) > 15
    for one in front:
        assert one.values is not None
        assert math.sqrt(one.values["a"]) + math.sqrt(one.values["b"]) == pytest.approx(
            2.0, abs=0.02
        )  # the ends of it may lie a little outside
    values = [tuple(one.values.values()) for one in front if one.values]
    assert values == sorted(values)
    smaller = [(one, other) for one in values for other in values if one != other and one[0] <= other[0]]
    assert all(one[1] > other[1] for one, other in smaller)


@pytest.mark.parametrize("minimised", [("f",), ("f", "x")])
def test_a_search_broken_off_asks_for_the_same_cases_again(minimised: tuple[str, ...]) -> None:
    """What was computed before the break is not computed again, and the end is that of a search in one go."""
    search = Search(
        (*XY, Axis("word", values=("a", "b"))), minimised, (Bound("f", high=20.0),), cases=56, seed=3, batch=8
    )
    whole = ask_and_tell(search, parabola)
    kept: dict[tuple[object, ...], Values | None] = {}
    computed = 0

    def through(asked: Sequence[Parameters]) -> list[Values | None]:
        nonlocal computed
        for one in asked:
            key = tuple(one.items())
            if key not in kept:
                if computed == 27:
                    raise KeyboardInterrupt
                computed += 1
                kept[key] = parabola([one])[0]
        return [kept[tuple(one.items())] for one in asked]

    with pytest.raises(KeyboardInterrupt):
        ask_and_tell(search, through)
    computed = -1000
    assert ask_and_tell(search, through) == whole
    assert computed == -1000 + len(kept) - 27


def test_cases_that_fail_do_not_end_it() -> None:
    def failing(asked: Sequence[Parameters]) -> list[Values | None]:
        return [
            None if float(one["x"]) > 1 else {"g": 0.0} if float(one["x"]) < -1 else found
            for one, found in zip(asked, parabola(asked), strict=True)
        ]

    search = Search(XY, ("f",), (Bound("x", low=-10.0),), cases=48, seed=4)
    found = ask_and_tell(search, failing)
    assert len(found) == 48
    assert {
        one.feasible for one in found if float(one.parameters["x"]) > 1 or float(one.parameters["x"]) < -1
    } == {False}
    assert pareto_front(search, found)[0].parameters["x"] <= 1


def test_nothing_within_the_limits_has_no_pareto_front() -> None:
    search = Search(XY, ("f",), (Bound("f", high=0.5),), cases=16)
    assert pareto_front(search, ask_and_tell(search, parabola)) == []


def test_without_optuna_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "optuna", None)
    with pytest.raises(VfifeError, match=r"vfife\[optimise\]"):
        optimise.optuna_module()


def test_a_front_of_what_shall_be_small_and_what_shall_be_large() -> None:
    """Of x^2, to be small, and 4 x - x^2, to be large: both grow up to x = 2, where the front ends; brute
    force says which cases are on it.
    """
    values = [(float(x), {"a": x * x, "b": 4.0 * x - x * x}) for x in np.linspace(0.0, 3.0, 13)]
    found = [Candidate(k, {"x": x}, one, True) for k, (x, one) in enumerate(values)]
    search = Search((Axis("x", 0.0, 3.0),), ("a",), maximised=("b",))
    assert [one.parameters["x"] for one in pareto_front(search, found)] == [x for x, _ in values if x <= 2.0]
    (only,) = pareto_front(Search((Axis("x", 0.0, 3.0),), (), maximised=("b",)), found)
    assert only.parameters["x"] == 2.0


def test_the_largest_is_found() -> None:
    search = Search((Axis("x", -2.0, 3.0),), (), cases=48, seed=1, maximised=("g",))
    cases = ask_and_tell(search, lambda asked: [{"g": 3.0 - (float(one["x"]) - 1.0) ** 2} for one in asked])
    (found,) = pareto_front(search, cases)
    assert found.values is not None and found.values["g"] == pytest.approx(3.0, abs=0.02)
