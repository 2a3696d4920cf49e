"""The straight line as data: what it may hold, in which order, how long it is, and which runs take it."""

import dataclasses
import re
from pathlib import Path

import pytest

import vfife
from support import SQUARE, four_bar, with_settings
from vfife.assembly.assemble import assemble
from vfife.compiler.backends import llvm
from vfife.compiler.backends.modules import module
from vfife.compiler.trace import schedule
from vfife.compiler.trace.straight_line import estimated_lines, trace
from vfife.compiler.trace.tape import OPERATORS, Trace, is_row
from vfife.model.mechanism import Mechanism
from vfife.solvers.transient import choose_loop

EXAMPLES = Path(__file__).parents[2] / "examples"


def assembled(mechanism: Mechanism):
    return assemble(mechanism, "auto", duration=1e-3)


def bar(elements: int) -> Mechanism:
    m = Mechanism("bar")
    m.link(
        "bar",
        length=0.01 * elements,
        model="elastic",
        elements=elements,
        section=SQUARE,
        position=(0.0, 0.0),
        velocity=(1.0, 2.0, 3.0),
    )
    return m


CASE_C = assembled(four_bar("BCD")).topology
STEPS = {
    "fast": trace(CASE_C), "full": trace(CASE_C, True), "frames": trace(assembled(bar(5)).topology),
    "ideal": trace(assembled(four_bar("C")).topology, True),
}  # fmt: skip


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_operations_are_few_and_in_an_order_in_which_they_can_be_done(step: Trace):
    known = {"n"}
    for operation in step.operations:
        assert operation.operator in OPERATORS
        assert all(is_row(name) or name in known for name in operation.uses)
        known.add(operation.name)
    assert all(
        not isinstance(value, str) or is_row(value) or value in known for value in step.stores.values()
    )


@pytest.mark.parametrize("order", [schedule.ordered, schedule.streamed])
@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_an_order_has_every_operation_once_and_after_its_operands(step: Trace, order):
    operations = order(step)
    assert sorted(operations) == sorted(step.operations)
    place = {operation.name: k for k, operation in enumerate(operations)}
    assert all(
        place[name] < k for k, operation in enumerate(operations) for name in operation.uses if name in place
    )


def waiting(operations) -> int:
    """Most numbers that wait for their use at one time."""
    last = {name: k for k, operation in enumerate(operations) for name in operation.uses}
    now = most = 0
    for k, operation in enumerate(operations):
        now += operation.name in last
        most = max(most, now)
        now -= sum(last[name] == k for name in set(operation.uses) if name.startswith("t"))
    return most


def test_elements_are_made_one_after_the_other():
    """However many there are: begun all at once, 25 elements had 200 numbers that waited for their use, and
    ten 80.
    """
    few, many = (schedule.steady(trace(assembled(bar(elements)).topology), ())[1] for elements in (10, 25))
    for tested_first in (True, False):
        assert (
            waiting(schedule.ordered(many, tested_first)) <= waiting(schedule.ordered(few, tested_first)) < 90
        )


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_rows_are_read_before_they_are_written_and_nothing_is_written_before_the_test(step: Trace):
    lines = schedule.in_place(step, schedule.ordered(step))
    tests = [k for k, line in enumerate(lines) if isinstance(line, schedule.Test)]
    assert len(tests) == (step.rare is not False)
    written: set[int] = set()
    made: set[str] = set()
    for k, line in enumerate(lines):
        if isinstance(line, schedule.Load):
            assert line.row not in written
            made.add(f"v{line.row}")
        elif isinstance(line, schedule.Store):
            assert not tests or k > tests[0]
            assert not isinstance(line.value, str) or line.value in made
            written.add(line.row)
        elif not isinstance(line, schedule.Test):
            made.add(line.name)
    assert written == set(step.stores)


def test_a_rounding_has_an_operator_of_its_own():
    """Two for the directions of each of three bodies; 1.5 2^52 itself is nowhere."""
    operations = STEPS["fast"].operations
    assert sum(operation.operator == "round" for operation in operations) >= 6
    assert not any(
        isinstance(o, float) and abs(o) > 1e15 for operation in operations for o in operation.operands
    )


def test_only_the_fast_step_has_an_unlikely_condition():
    """A contact that begins writes its speed in the whole step alone."""
    fast, full = STEPS["fast"], STEPS["full"]
    assert fast.rare is not False and full.rare is False
    assert set(fast.stores) < set(full.stores)
    assert STEPS["frames"].rare is False


def test_lines_and_blocks_are_linear_in_the_elements():
    """Compilation takes the square of a block's lines: no block of the fast step is long, however long the
    step.
    """
    small, large = (assembled(bar(n)).topology for n in (20, 80))
    counts = [len(trace(topology).operations) for topology in (small, large)]
    assert counts[1] == pytest.approx(4 * counts[0], rel=0.05)
    text = module(large, 1)
    (lean,) = re.findall(r"define i64 @fast_steps\(.*?\n}", text, re.S)
    assert max(len(block.splitlines()) for block in re.split(r"^\w+:$", lean, flags=re.M)) < 4 * llvm.BLOCK


@pytest.mark.system("traces every example")
@pytest.mark.parametrize(
    "name",
    ["four_bar_case_b", "jansen_leg", "scissor_lift", "lee_frame", "squeezer", "slider_crank_loose_guide"],
)
def test_lines_are_known_beforehand_within_a_half(name):
    topology = assemble(vfife.load_model(EXAMPLES / f"{name}.toml"), "auto", duration=1e-3).topology
    assert estimated_lines(topology) == pytest.approx(len(trace(topology).operations), rel=0.55)


def test_all_but_large_frames_path_units_and_statics_take_the_straight_line():
    assert choose_loop(assembled(four_bar("BCD")), "auto") == "generated"
    assert choose_loop(assembled(bar(300)), "auto") == "generated"
    assert choose_loop(assembled(bar(1000)), "auto") == "data-driven"
    assert choose_loop(assembled(with_settings(bar(5), path_unit=2)), "auto") == "data-driven"
    assert choose_loop(assembled(bar(5)), "data-driven") == "data-driven"
    still = assembled(bar(5))
    still = dataclasses.replace(still, mechanism=with_settings(still.mechanism, analysis="static"))
    assert choose_loop(still, "auto") == "data-driven"
