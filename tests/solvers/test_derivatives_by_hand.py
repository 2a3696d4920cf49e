"""What derivatives are put together from: pairs of records, spans of outputs, tables of functions; numbers
that a test writes.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from support import four_bar
from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.solvers import tangents
from vfife.solvers.record import Columns, recorded_rows
from vfife.solvers.tangents import Neighbours, changes, comparable, displaced, rates, spans


@pytest.mark.parametrize(
    ("turn", "steps", "whole", "found"),
    [
        (0.1, 3000, False, [(10, 300)]),
        (0.1, 3000, True, [(2000, 1), (1000, 1)]),
        (0.1, 1000, True, [(1000, 1)]),
        (0.1, 600, True, [(600, 1)]),
        (None, 600, True, [(600, 1)]),
        (0.1, 1001, True, [(1, 1), (1000, 1)]),
    ],
)
def test_outputs_are_all_or_the_last_turn_and_what_comes_before(
    turn: float | None, steps: int, whole: bool, found: list[tuple[int, int]]
) -> None:
    choice = SimpleNamespace(turn=turn, step=1e-4, steps=steps, outputs_every=10, outputs=steps // 10)
    assert spans(SimpleNamespace(choice=choice), whole) == found  # type: ignore[arg-type]


def test_both_sides_of_a_run_lie_half_of_the_distance_away_and_extremes_are_sizes() -> None:
    assembly = assemble(four_bar("C"), 1e-6, turns=1, force_step=True)
    seen = Columns(assembly.layout, recorded_rows(assembly))
    rng = np.random.default_rng(5)
    rows, slopes = rng.normal(size=(3, len(seen.row_numbers))), rng.normal(size=(3, len(seen.row_numbers)))
    up, down = tangents._pair(Neighbours(assembly, assembly, 0.2), np.array([0, 5, 10]), seen, rows, slopes)
    size = np.isin(seen.row_numbers, assembly.layout.of("extreme"))
    for side, sign in ((up, 1.0), (down, -1.0)):
        wanted = rows + sign * 0.1 * slopes
        assert side.rows[:, ~size] == pytest.approx(wanted[:, ~size], rel=1e-14)
        assert side.rows[:, size] == pytest.approx(
            np.maximum(wanted[:, size], 0.0), rel=1e-14
        ) and side.steps.tolist() == [0, 5, 10]


def function(period: float, starts: list[float], rows: list[list[float]]) -> np.ndarray:
    """The table of a function: its pieces, a period with its kinks or none, where they start, seven
    coefficients of each.
    """
    head = [float(len(starts))] if not period else [-float(len(starts)), period, 0.0]
    return np.array([*head, *starts, *(value for row in rows for value in (row + [0.0] * 7)[:7])])


@pytest.mark.parametrize("period", [0.0, 4.0])
def test_tables_of_functions_have_their_derivatives(period: float) -> None:
    """f = 1 + 2 x + 3 x^2 and 7 - x^3: rates 2 + 6 x and -3 x^2; f' is what a later start takes away."""
    pieces = [[1.0, 2.0, 3.0], [7.0, 0.0, 0.0, -1.0]]
    table = np.concatenate([[99.0], function(period, [0.0, 2.0], pieces)])
    assembly: Any = SimpleNamespace(tables=table, topology=SimpleNamespace(function_start=(1,)))
    found = rates(assembly)[-14:].reshape(2, 7)
    derived = np.array([[2.0, 6.0, 0, 0, 0, 0, 0], [0.0, 0.0, -3.0, 0, 0, 0, 0]])
    assert found == pytest.approx(derived) and rates(assembly)[:-14].tolist() == table[:-14].tolist()
    up, down = table.copy(), table.copy()
    up[-14], down[-14] = 1.3, 0.7  # the constant of the first piece, by 0.6
    first = len(table) - 14 - 2
    up[first + 1], down[first + 1] = 2.1, 1.9  # the second begins later by 0.2
    sides: Any = SimpleNamespace(
        up=SimpleNamespace(tables=up), down=SimpleNamespace(tables=down), distance=0.5
    )
    change = changes(assembly, sides)[-14:].reshape(2, 7)
    assert change == pytest.approx(np.array([[1.2, 0, 0, 0, 0, 0, 0], -0.4 * derived[1]]))


def test_displaced_runs_are_spread_in_a_step_and_in_its_parts() -> None:
    """Four runs and eight parts: at 0, 2 1/4, 4 1/2 and 6 3/4 of the parts."""
    assert displaced(4, 8) == pytest.approx((0.0, 2.25 / 8.0, 4.5 / 8.0, 6.75 / 8.0))
    assert displaced(1, 8) == (0.0,) and displaced(3, 8)[1] == pytest.approx((2.0 + 1.0 / 3.0) / 8.0)


def rotor(
    mass: float = 1.0,
    values: tuple[float, ...] = (0.0, 1.0, 0.0),
    period: float = 0.2,
    spring: bool = False,
    duration: float = 0.1,
    outputs: int = 10,
) -> Assembly:
    """A rod about a pivot under a torque by a table and a moment that repeats."""
    m = Mechanism("rotor")
    rod = m.link("rod", length=1.0, mass=mass)
    m.revolute("A", m.point("pivot", 0.0, 0.0), rod.start)
    m.torque("rod", value=values, times=tuple(0.1 * k for k in range(len(values))))
    m.moment("load", "rod.end", moment=1.0, factors=(1.0, 2.0, 1.0), times=(0.0, 0.1, period), repeat=True)
    if spring:
        m.spring("s", m.point("anchor", 2.0, 0.0), rod.end, stiffness=1.0)
    return assemble(m, 1e-3, duration=duration, outputs=outputs)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"mass": 1.1}, True),
        ({"values": (0.0, 2.0, 0.0)}, True),
        ({"values": (0.0, 2.0, 1.0, 0.0)}, False),
        ({"period": 0.3}, False),
        ({"duration": 0.2}, False),
        ({"outputs": 5}, False),
        ({"spring": True}, False),
    ],
    ids=["mass", "value", "pieces", "period", "steps", "outputs", "topology"],
)
def test_neighbours_are_comparable_if_only_their_numbers_differ(
    change: dict[str, Any], expected: bool
) -> None:
    """A step's derivative knows one topology, one count of steps and one division of each table."""
    base, other = rotor(), rotor(**change)
    assert comparable(base, Neighbours(other, base, 0.1)) is expected
    assert comparable(base, Neighbours(base, other, 0.1)) is expected


class Captured(Exception):
    """What a runner was made of."""


def test_each_lane_starts_with_the_run_and_its_own_change(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two numbers, two displaced runs each, in four lanes: the run below the change of its number; tables of
    f, f' and its change.
    """

    def runner(
        topology: Any, states: np.ndarray, tables: np.ndarray, loop: str, kept: np.ndarray, **more: Any
    ) -> None:
        raise Captured(states, tables, kept, more)

    monkeypatch.setattr(tangents, "Runner", runner)
    table = np.concatenate([[99.0], function(0.0, [0.0], [[1.0, 2.0, 3.0]])])
    model: Any = SimpleNamespace(
        layout=SimpleNamespace(rows=3),
        state=np.array([1.0, 2.0, 3.0]),
        tables=table,
        topology=SimpleNamespace(function_start=(1,)),
        mechanism=SimpleNamespace(settings=SimpleNamespace(parts=8)),
    )
    some = []
    for slope, constant in ((np.array([1.0, 0.0, -1.0]), 5.0), (np.array([0.0, 7.0, 0.0]), 0.0)):
        sides = []
        for sign in (0.25, -0.25):
            tables = table.copy()
            tables[-7] += sign * constant
            sides.append(SimpleNamespace(state=model.state + sign * slope, tables=tables))
        some.append(Neighbours(*sides, 0.5))  # type: ignore[arg-type]
    with pytest.raises(Captured) as got:
        tangents.TangentPass(
            model, np.array([0.0, 0.5]), 4, 1, np.array([0, 2], dtype=np.uint32), [(1, 1)], lambda: None
        ).pairs(some)
    states, tables, kept, more = got.value.args
    assert states.reshape(2, 3, 4)[0] == pytest.approx(np.tile(model.state[:, None], 4))
    assert pytest.approx(np.array([[1.0, 0, -1]] * 2 + [[0, 7.0, 0]] * 2)) == states.reshape(2, 3, 4)[1].T
    assert (
        kept.tolist() == [0, 2, 3, 5]
        and more["shares"].tolist() == [0.0, 0.5, 0.0, 0.5]
        and more["directions"] == 1
    )
    each = tables.reshape(4, 3, -1)
    assert each[:, 0] == pytest.approx(np.tile(table, (4, 1)))
    assert each[:, 1, -7:] == pytest.approx(np.tile([2.0, 6.0, 0, 0, 0, 0, 0], (4, 1)))
    assert each[:, 2, -7:] == pytest.approx(np.array([[5.0, 0, 0, 0, 0, 0, 0]] * 2 + [[0.0] * 7] * 2))
