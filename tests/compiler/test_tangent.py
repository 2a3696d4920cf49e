"""Derivatives of traced operations against those of calculus, and of whole steps: the numbers themselves keep
their bits.
"""

import math

import numpy as np
import pytest

import mechanisms
import vfife
from support import bits
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner
from vfife.compiler.trace.straight_line import trace
from vfife.compiler.trace.tangent import shared_tangent, tangent
from vfife.compiler.trace.tape import Mathematics, Rows, Symbol, Tape, Trace, select
from vfife.solvers.record import recorded_rows
from vfife.solvers.tangents import Neighbours, changes, rates

FUNCTIONS = {  # of x = row 0 and y = row 1: the function as it is traced, and its derivatives by x and y
    "sum": (lambda x, y: x + 3.0 * y - 2.0, lambda x, y: (1.0, 3.0)),
    "difference": (lambda x, y: 1.0 - x - y * y, lambda x, y: (-1.0, -2.0 * y)),
    "product": (lambda x, y: x * x * y, lambda x, y: (2.0 * x * y, x * x)),
    "quotient": (
        lambda x, y: x / (1.0 + y * y),
        lambda x, y: (1.0 / (1.0 + y * y), -2.0 * x * y / (1.0 + y * y) ** 2),
    ),
    "root": (
        lambda x, y: Mathematics.sqrt(x * x + y * y),
        lambda x, y: (x / math.hypot(x, y), y / math.hypot(x, y)),
    ),
    "negative": (lambda x, y: -(x * y), lambda x, y: (-y, -x)),
    "magnitude": (
        lambda x, y: abs(x - y),
        lambda x, y: (math.copysign(1.0, x - y), -math.copysign(1.0, x - y)),
    ),
    "choice": (
        lambda x, y: select(x > y, lambda: x * x, lambda: y),
        lambda x, y: (2.0 * x, 0.0) if x > y else (0.0, 1.0),
    ),
    "rounding": (lambda x, y: x.tape.emit("round", x) + y, lambda x, y: (0.0, 1.0)),
}


def traced(function) -> Trace:
    """Row 2 becomes the function of rows 0 and 1."""
    tape = Tape()
    rows = Rows(tape, {}, {2})
    rows[2] = function(rows[0], rows[1])
    stores = rows.stores()
    return Trace(
        tape.needed(stores.values()),
        {row: value.name if isinstance(value, Symbol) else value for row, value in stores.items()},
    )


def carried_out(trace: Trace, state: list[float]) -> list[float]:
    """A trace on numbers, operation by operation, by Python's own operators."""
    values = {}

    def of(operand):
        if not isinstance(operand, str):
            return operand
        return state[int(operand[1:])] if operand[0] == "v" else 7.0 if operand == "n" else values[operand]

    does = {
        "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a,
        b: a / b if b else math.nan, "sqrt": math.sqrt, "abs": abs, "neg": lambda a: -a, ">": lambda a,
        b: a > b, "<": lambda a, b: a < b, "select": lambda c, a, b: a if c else b, "round": round,
        "==": lambda a, b: a == b, "!=": lambda a, b: a != b, ">=": lambda a, b: a >= b, "<=": lambda a,
        b: a <= b, "and": lambda a, b: a and b, "or": lambda a, b: a or b, "fused": lambda a, b, c: a * b + c,
    }  # fmt: skip
    for name, operator, operands in trace.operations:
        values[name] = does[operator](*map(of, operands))
    after = list(state)
    for row, operand in trace.stores.items():
        after[row] = of(operand)
    return after


@pytest.mark.parametrize("derive", [tangent, shared_tangent])
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("x, y", [(0.7, 1.9), (-2.3, -2.9), (1.1, 0.2)])
def test_operations_have_the_derivatives_of_calculus(name, x, y, derive):
    """Two directions at once: that of x, and one of 2 x and -1 y together."""
    function, derivatives = FUNCTIONS[name]
    step = traced(function)
    both = carried_out(derive(step, 3, 2), [x, y, 0.0, 1.0, 0.0, 0.0, 2.0, -1.0, 0.0])
    by_x, by_y = derivatives(x, y)
    assert both[2] == carried_out(step, [x, y, 0.0])[2]
    assert both[5] == pytest.approx(by_x, rel=1e-14, abs=1e-15)
    assert both[8] == pytest.approx(2.0 * by_x - by_y, rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("derive", [tangent, shared_tangent])
def test_a_magnitude_that_is_zero_has_a_derivative_that_is_no_infinity(derive):
    step = traced(lambda x, y: Mathematics.sqrt(x * x + y * y))
    assert carried_out(derive(step, 3, 1), [0.0, 0.0, 0.0, 1.0, 1.0, 0.0])[5] == 0.0


def test_what_is_not_chosen_may_be_infinite():
    """y / x where x is not zero: at zero neither the number nor its slope is one, and both are left out."""
    step = traced(lambda x, y: select(x == 0.0, lambda: 3.0 * y, lambda: y * y / x))
    assert carried_out(shared_tangent(step, 3, 1), [0.0, 2.0, 0.0, 1.0, 1.0, 0.0])[2:6:3] == [6.0, 3.0]


@pytest.mark.slow("traces the derivative of a whole step")
@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_guide"])
def test_what_directions_share_is_done_once(name):
    """A whole step in eight directions: its numbers are the same, their slopes to rounding, in two thirds of
    the operations at the most.
    """
    assembly = assemble(vfife.load(f"examples/{name}.toml"), force_step=True)
    step, rows, random = trace(assembly.topology), assembly.layout.rows, np.random.default_rng(5)
    plain, shared = tangent(step, rows, 8), shared_tangent(step, rows, 8)
    assert len(shared.operations) < 0.67 * len(plain.operations)
    state = [*(assembly.state * (1.0 + 1e-3 * random.random(rows))), *random.normal(size=8 * rows)]
    expected, found = (np.array(carried_out(one, state)) for one in (plain, shared))
    assert np.array_equal(found[:rows], expected[:rows])
    for row in step.stores:
        these = slice(row + rows, None, rows)
        assert found[these] == pytest.approx(
            expected[these], rel=1e-9, abs=1e-9 * np.abs(expected[these]).max()
        )


@pytest.mark.parametrize("name", ["four_bar", "four_bar_case_c"])
def test_slopes_at_the_start_are_numbers(name):
    """Journals stand in the middle of their bearings, where the direction of the eccentricity is divided by
    next to nothing.
    """
    assembly = assemble(vfife.load(f"examples/{name}.toml"), force_step=True)
    step, rows = trace(assembly.topology), assembly.layout.rows
    state = [*assembly.state, *np.random.default_rng(5).normal(size=rows)]
    plain, shared = (carried_out(derive(step, rows, 1), state) for derive in (tangent, shared_tangent))
    assert np.isfinite(shared).all()
    free = assembly.layout["particle_u"]
    assert np.array(shared)[free + rows] == pytest.approx(np.array(plain)[free + rows], rel=1e-9)


def test_numbers_keep_their_bits_beside_their_derivatives():
    """Contacts, events in smaller steps, functions of time: whatever stands behind the state. The numbers
    alone are the data-driven loop's.
    """
    assembly = assemble(mechanisms.every_drive(), 4e-6, duration=2e-3, force_step=True)
    kept = recorded_rows(assembly)
    states, tables = (
        np.repeat(assembly.state[:, None], 4, axis=1),
        np.repeat(assembly.tables[None, :], 4, axis=0),
    )
    alone = Runner(assembly.topology, states, tables, "data-driven", kept)
    derived = Runner(
        assembly.topology,
        np.concatenate([states, 0.1 * states, -states]),
        np.tile(tables, 4),
        "generated",
        kept,
        directions=2,
    )
    for runner in (alone, derived):
        runner.advance(1, 1)
    assert np.array_equal(bits(alone.advance(250, 2)), bits(derived.advance(250, 2)))


def test_functions_of_time_carry_all_their_derivatives():
    """A harmonic drive whose steps become longer: at step n its time grows by n for each second of them, and
    at the next one by n + 1.
    """
    mechanism = mechanisms.every_drive()
    drive = mechanism.drivers["hung"]
    assembly = assemble(mechanism, 4e-6, duration=2e-3, force_step=True)
    layout, steps, omega = assembly.layout, 250, 2.0 * math.pi * drive.frequency
    states = np.zeros((3 * layout.rows, 4))
    states[: layout.rows] = assembly.state[:, None]
    states[layout.rows + layout.row("step")] = 1.0
    own = np.concatenate(
        [assembly.tables, rates(assembly), *[changes(assembly, Neighbours(assembly, assembly, 1.0))] * 2]
    )
    kept = np.arange(3 * layout.rows, dtype=np.uint32)
    runner = Runner(
        assembly.topology,
        states,
        np.repeat(own[None, :], 4, axis=0),
        "generated",
        kept,
        directions=2,
        parts=1,
    )
    runner.advance(1, 1)
    found = runner.advance(steps, 1)[0, :, 0]
    time = steps * 4e-6
    closed = {
        "rate": drive.amplitude * omega * math.cos(omega * time),
        "acceleration": -drive.amplitude * omega**2 * math.sin(omega * time),
        "third": -drive.amplitude * omega**3 * math.cos(omega * time),
    }
    place = int(np.argmin([abs(found[row] - closed["rate"]) for row in layout["function_rate"]]))
    for block, slope in (
        ("function_value", "rate"),
        ("function_rate", "acceleration"),
        ("function_acceleration", "third"),
    ):
        assert found[layout.rows + layout.row(block, place)] == pytest.approx(steps * closed[slope], rel=1e-6)
    after = (steps + 1) * drive.amplitude * omega * math.cos(omega * (time + 4e-6))
    assert found[layout.rows + layout.row("function_next", place)] == pytest.approx(after, rel=1e-6)
