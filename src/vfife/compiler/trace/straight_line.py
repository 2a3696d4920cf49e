"""The straight-line steps of one topology, traced from the data-driven one.

The **fast step** leaves unlikely branches out (a contact that begins, the start). If one would be needed, it
reports that and changes nothing. The **full step** contains them as selects and is valid everywhere. All else
has the same bits in both. With a single step, all steps would pay for branches that few of them take.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from ...kernels import step as loop
from ...kernels.arrays import PARTICLE, Layout
from ...kernels.data_driven import change_step
from ...kernels.topology import AIMED, FREE, TIME, Topology
from .graph import derive
from .jumps import give_jumps
from .source import choices
from .tables import tables
from .tape import STEP_NUMBER, Operand, Operation, Rows, Symbol, Tape, Trace, Unlikely, logical_or, operand_of
from .traceable import WRITING, Traceable

STEP = ("step_x", "step_y", "step_turn", "step_sine", "step_versine")


def constant_rows(topology: Topology, layout: Layout) -> dict[int, float]:
    """Return the rows whose value follows from the topology: velocities of what never moves, arms of bodies
    without arms, loads of a weightless mechanism. The tape drops operations with them.
    """
    values: dict[int, float] = {}
    free, driven, armed, bound = map(set, (topology.free, topology.driven, topology.trig, topology.bound))
    for i in range(topology.particles):
        fixed: dict[str, float] = {}
        if i in bound:
            fixed |= dict.fromkeys(("vu", "vv", "vw", "s", *STEP), 0.0) | {"c": 1.0}
        if topology.weightless:
            fixed |= dict.fromkeys(("load_x", "load_y", "load_m"), 0.0)
        if i not in free:
            fixed |= dict.fromkeys(("inverse_mass", "inverse_inertia", "u", "v", "ax", "ay"), 0.0)
        if i not in free | driven:
            fixed |= dict.fromkeys(("x", "y", "theta", "w", "aw"), 0.0)
        base = layout.record("particle", i)
        values |= {base + getattr(PARTICLE, name): value for name, value in fixed.items()}
    if topology.weightless:
        values |= {
            layout.row(f"driven_weight_{axis}", k): 0.0 for k in range(len(topology.driven)) for axis in "xy"
        }
    # A lever of zero length removes every product with it from the step.
    values |= _on_particles(topology, layout, armed)
    return values


def _on_particles(topology: Topology, layout: Layout, armed: set[int]) -> dict[int, float]:
    """Return the arms of joints and springs that are zero because the particle itself is the pin, and the
    offsets of joints that have none.
    """
    values: dict[int, float] = {}
    pairs = (
        ("contact", "bearing"),
        ("contact", "journal"),
        ("joint", "bearing"),
        ("joint", "journal"),
        ("spring", "first"),
        ("spring", "second"),
    )
    for kind, side in pairs:
        for joint, body in enumerate(getattr(topology, f"{kind}_{side}")):
            if body not in armed and body != 0:
                values |= {layout.row(f"{kind}_{side}_{axis}", joint): 0.0 for axis in "xy"}
    for joint, (place, turn) in enumerate(topology.held):
        if place not in AIMED and turn == FREE:
            values[layout.row("joint_offset", joint)] = 0.0
    return values


class _Laws:
    """Collect the functions of laws that a choice between laws calls."""

    def __init__(self) -> None:
        self.functions: dict[str, Callable[..., Any]] = {}

    def add(self, function: Callable[..., Any], name: str | None = None) -> str:
        """Add a function; return its name."""
        self.functions[name or function.__name__] = function
        return name or function.__name__


def give_laws(traceable: Traceable, topology: Topology) -> None:
    """Put the choice between a topology's laws in the place of the kernels' names for it."""
    give_laws_of(traceable, topology.contact_laws, topology.friction_laws)


def give_laws_of(
    traceable: Traceable, contact_laws: tuple[type, ...], friction_laws: tuple[type, ...]
) -> None:
    """Put the choice between these laws in the place of the kernels' names for it."""
    laws = _Laws()
    for name, text in choices(contact_laws, friction_laws, laws).items():
        traceable.given[name] = traceable.written(text, laws.functions)


def trace(
    topology: Topology, full: bool = False, extra_rows: Iterable[int] = (), jumps: bool = False
) -> Trace:
    """Trace one step of a topology, fast or full; it stores the scratch rows ``extra_rows`` in addition to
    those that the next step needs. With ``jumps``, its derivatives contain the jumps of forces
    (:mod:`~vfife.compiler.trace.jumps`).

    Raises :class:`~vfife.compiler.trace.tape.Branch` for a law that branches, ValueError for path units of
    several steps.
    """
    if topology.path_unit != 1:
        raise ValueError("path units of several steps use the data-driven loop")
    integers, layout, _ = tables(topology)
    tape = Tape()
    # Only rows that the next step or an output needs are stored. All others live in registers.
    rows = Rows(
        tape, constant_rows(topology, layout), {*layout.of("state", "memory", "extreme"), *extra_rows}
    )
    traceable = Traceable(tape, Unlikely(tape, rows, full))
    with WRITING:
        give_laws(traceable, topology)
        if jumps:
            give_jumps(traceable, tape, full)
        step = traceable(loop.step)
    n = Symbol(tape, STEP_NUMBER)
    # The topology enters as plain integers, not as symbols: loops over records unroll, and branches on the
    # topology are decided here instead of in each step.
    step(rows, integers.tolist(), n, n == 0.0 if full else False)
    # The fast step is invalid if any of the branches that it leaves out would be taken: one condition for
    # all, tested once before anything is stored.
    rare: Any = False
    for condition in tape.rare:
        rare = logical_or(rare, condition)
    return tape.trace_of(rows.stores(), rare)


def resizing(topology: Topology) -> Trace:
    """Trace the change of the step size; the symbols ``size``, ``shift`` and ``repeated`` are its
    arguments.
    """
    integers, layout, _ = tables(topology)
    tape = Tape()
    rows = Rows(
        tape,
        constant_rows(topology, layout),
        {*layout.of("state", "memory", "extreme"), *(layout.row(name) for name in ("step", "shift"))},
    )
    with WRITING:
        resize = Traceable(tape)(change_step)
    resize(rows, integers.tolist(), *(Symbol(tape, name) for name in ("size", "shift", "repeated")))
    return tape.trace_of(rows.stores())


def estimated_lines(topology: Topology) -> int:
    """Estimate the number of lines of a step without tracing it; for a thousand lines it is within a half.

    Constraints that share a body couple, so their lines grow with the square of the profile's width.
    """
    graph = derive(topology)
    bands = [row - first for row, first in enumerate(graph.first)]
    bound = len(set(topology.bound) & set(topology.free))
    local = (
        50 * len(topology.frame_nodes)
        + 15 * (len(topology.free) + bound)
        + 60 * len(topology.trig)
        + 50 * len(bands)
    )
    coupled = (
        150 * len(topology.contact_bearing)
        + 40 * len(topology.spring_first)
        + sum(band * band + 8 * band for band in bands)
    )
    return (
        local
        + coupled
        + sum(graph.constrained) * (sum(5 * band + 55 for band in bands) + 15 * len(graph.jointed))
    )


@dataclass(frozen=True)
class Function:
    """A function of time or motion that is evaluated before a step: the start of its ``table``, and the
    ``rows`` of its value, two derivatives, kinks, and value one step later.

    ``argument`` is the operand on which it depends, and ``operations`` compute it. They use rows before the
    step, ``time``, and ``ahead``, the step that leads to t_n.
    """

    table: int
    rows: tuple[int, int, int, int, int]
    of_time: bool
    operations: tuple[Operation, ...]
    argument: Operand


def functions(topology: Topology) -> list[Function]:
    """Return the functions of a topology. Their tables are searched by bisection, which is no straight-line
    code, so that only their arguments are traced.
    """
    layout, result = Layout(topology), []
    for f, start in enumerate(topology.function_start):
        kind, *bodies = topology.function_argument[f] if topology.function_argument else (TIME, 0, 0)
        tape = Tape()
        rows = Rows(tape, constant_rows(topology, layout), set())
        first, second = (layout.record("particle", p) for p in bodies)
        record = layout.record("function", f)
        with WRITING:
            argument = Traceable(tape)(loop.argument)
        x = argument(rows, kind, first, second, record, Symbol(tape, "time"), Symbol(tape, "ahead"))
        value, rate, acceleration, kinks, following = (
            layout.row(f"function_{name}", f) for name in ("value", "rate", "acceleration", "kinks", "next")
        )
        result.append(
            Function(
                start,
                (value, rate, acceleration, kinks, following),
                kind == TIME,
                tape.needed([x]),
                operand_of(x),
            )
        )
    return result


class Steps(NamedTuple):
    """The parts of a topology's loop: functions of time, fast and full step, and the change of the step
    size.
    """

    functions: list[Function]
    fast: Trace
    full: Trace
    resize: Trace


@lru_cache(maxsize=2)  # a mechanism and its ideal one, each in several widths or with derivatives beside it
def steps_of(topology: Topology, extra_rows: tuple[int, ...] = ()) -> Steps:
    """Return the steps of a topology, which also store the scratch rows ``extra_rows``."""
    full = trace(topology, full=True, extra_rows=extra_rows)
    return Steps(functions(topology), trace(topology, extra_rows=extra_rows), full, resizing(topology))
