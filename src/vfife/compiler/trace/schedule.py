"""The order of straight-line code: operations on the critical path first, rows read where they are first used
and written at once.

**Order of operations.** A processor looks a few hundred instructions ahead; a step has more than a thousand.
In the order of the data-driven loop (one joint after the other) it waits for square roots and quotients with
little else to do. Ordered by the length of the dependent chain behind each line (list scheduling), the same
lines take two thirds of the time. In a frame of many elements registers are scarcer than independent work:
there the data-driven order, which has the fewest live numbers, is left only where its next line would wait.
Order changes no bit: each line is one assignment.

**The rare condition.** The operations that it depends on come before everything else, and nothing is written
before it is known. A step that must not be taken has then changed nothing, and needs no undoing.

**Rows are read again rather than kept.** About a hundred numbers are live at a time, and a processor has
sixteen registers. A compiler spills what it has no register for, and so writes numbers to the stack that lie
in their rows anyway. Rows are as near as the stack: a row that has not been used for a while is read again.
Numbers that no row holds are left to the compiler. Operations whose result is the same in every step are
computed once, before the first step. Neither changes a bit.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias, TypeVar

from .tape import Operand, Operation, Trace, is_row, needed, rows_used

# The model of a processor: cycles from a store to a load of the same row, lines begun in a cycle, and the
# latency of operators (cycles; 3 for all others). It need not be accurate: it decides the order, not bits.
FORWARD = 8
WIDTH = 3
CYCLES = {"sqrt": 21, "/": 13}
# Lines that a processor keeps decoded. The code of a longer step has to be fetched, and spilled numbers make
# it longer still: there the next operation is chosen among WINDOW lines, in a shorter step among all.
SHORT = 1600
WINDOW = 100
# Chains are followed through this many steps, because the end of one step is the beginning of the next.
STEPS = 3
# An operation is urgent if delaying it by this number of cycles would prolong these steps.
URGENT = 400


class Load(NamedTuple):
    """Read a row."""

    row: int


class Store(NamedTuple):
    """Write a row."""

    row: int
    value: Operand


class Test(NamedTuple):
    """End the step here if the rare condition is true."""

    condition: Operand


Line: TypeAlias = "Load | Store | Test | Operation"


def remaining(trace: Trace) -> dict[str, int]:
    """Return, for each operation by name, the cycles from its end to the end of the longest chain of
    operations that depend on it, followed through three steps.
    """
    # Each pass goes backwards through one step. A store continues at the loads of its row in the next step,
    # whose chains (``loads``) the pass before has computed.
    rows: dict[Operand, list[str]] = {}
    for number, value in trace.stores.items():
        rows.setdefault(value, []).append(f"v{number}")
    chains: dict[str, int] = {}
    backwards = [
        (o.name, tuple(set(trace.uses[o.name])), CYCLES.get(o.operator, 3), rows.get(o.name, ()))
        for o in reversed(trace.operations)
    ]
    loads: dict[str, int] = {}
    for _ in range(STEPS):
        later: dict[str, int] = {}
        for name, uses, cycles, stored in backwards:
            chain = later.get(name, 0)
            for row in stored:
                chain = max(chain, FORWARD + loads.get(row, 0))
            chains[name] = chain
            for used in uses:
                if later.get(used, 0) < chain + cycles:
                    later[used] = chain + cycles
        loads = {used: chain for used, chain in later.items() if is_row(used)}
    return chains


def ordered(trace: Trace, tested_first: bool = True) -> list[Operation]:
    """Return the operations in a good order, by list scheduling: among those whose operands are computed, the
    most urgent first, otherwise the next of the streamed order.

    An operation is urgent if the chain behind it is so long that the steps would take longer if it waited:
    longer than the longest chain, and than ``WIDTH`` lines a cycle allow. In a chain of rigid bodies this
    rule decides everything. The elements of a frame are computed one after the other, with as much of the
    next as avoids waiting. Ordered by urgency alone, all elements would begin at once and their numbers would
    be spilled, which takes half as long again. In a long step the window limits the number of live numbers.

    Operations that the test depends on come first, if ``tested_first``. If results go to another copy of the
    state, nothing has to wait for the test.
    """
    operations = streamed(trace, tested_first)
    place = {operation.name: k for k, operation in enumerate(operations)}
    chain_of = remaining(trace)
    chains = [chain_of[operation.name] for operation in operations]
    allowed = max(max(chains, default=0), STEPS * len(operations) // WIDTH) - URGENT
    for operation in needed(trace.operations, {trace.rare}) if tested_first else ():
        chains[place[operation.name]] += 1 << 30  # more urgent than any chain
    missing = [0] * len(operations)  # operands of each operation that are not computed yet
    users: list[list[int]] = [[] for _ in operations]
    takes = [CYCLES.get(operation.operator, 3) for operation in operations]
    for k, operation in enumerate(operations):
        for name in set(trace.uses[operation.name]):
            at = place.get(name)
            if at is not None:
                missing[k] += 1
                users[at].append(k)
    begin = [0] * len(operations)  # cycle at which an operation's operands are there
    waiting = Waiting(chains, allowed)
    result: list[Operation] = []
    low = high = cycle = 0
    count = len(operations)
    window = WINDOW if count > SHORT else count
    while len(result) < count:
        while low < count and waiting.done[low]:
            low += 1
        while high < min(low + window, count):
            if not missing[high]:
                waiting.put(high, begin[high])
            high += 1
        for k in waiting.due(cycle):
            result.append(operations[k])
            ready = cycle + takes[k]
            for user in users[k]:
                missing[user] -= 1
                if begin[user] < ready:
                    begin[user] = ready
                if not missing[user] and user < high:
                    waiting.put(user, begin[user])
        cycle += 1
    return result


class Waiting:
    """Operations, by number in the streamed order, whose operands are computed or being computed.

    ``chains`` are the cycles behind each. At cycle n an operation is urgent if these are at least
    ``allowed`` - n: what remains of the allowed time is then used up.
    """

    def __init__(self, chains: list[int], allowed: int) -> None:
        self.chains, self.allowed = chains, allowed
        self.done = [False] * len(chains)
        self.coming: list[tuple[int, int]] = []
        self.streamed: list[int] = []
        self.urgent: list[tuple[int, int]] = []  # the same operations, those with the longest chain first

    def put(self, k: int, begin: int) -> None:
        """Add operation k, whose operands are computed at the cycle ``begin``."""
        heapq.heappush(self.coming, (begin, k))

    def due(self, cycle: int) -> Iterator[int]:
        """Yield up to WIDTH operations to begin in this cycle."""
        while self.coming and self.coming[0][0] <= cycle:
            k = heapq.heappop(self.coming)[1]
            heapq.heappush(self.streamed, k)
            heapq.heappush(self.urgent, (-self.chains[k], k))
        for _ in range(WIDTH):
            while self.urgent and self.done[self.urgent[0][1]]:
                heapq.heappop(self.urgent)
            while self.streamed and self.done[self.streamed[0]]:
                heapq.heappop(self.streamed)
            if not self.streamed:
                return
            pressing = cycle - self.urgent[0][0] >= self.allowed
            k = heapq.heappop(self.urgent)[1] if pressing else heapq.heappop(self.streamed)
            self.done[k] = True
            yield k


Node = TypeVar("Node", bound=Hashable)


def depth_first(roots: Sequence[Node], children: Callable[[Node], Sequence[Node]]) -> list[Node]:
    """Return the nodes that can be reached from ``roots``, each after its children, which are visited in the
    given order.
    """
    # A stack of its own: chains are longer than Python's recursion limit.
    order: dict[Node, None] = {}
    stack = [(root, False) for root in reversed(roots)]
    while stack:
        node, complete = stack.pop()
        if node in order:
            continue
        if complete:
            order[node] = None
        else:
            stack.append((node, True))
            stack += [(child, False) for child in reversed(children(node))]
    return list(order)


def streamed(trace: Trace, tested_first: bool = True) -> list[Operation]:
    """Return the operations in depth-first order, each just before its first use: first those that the test
    depends on, then result after result, element by element. It keeps the fewest numbers live.
    """
    operations = {operation.name: operation for operation in trace.operations}
    operands = {name: [used for used in uses if used in operations] for name, uses in trace.uses.items()}
    used = {operand for names in operands.values() for operand in names}
    tested = [operation.name for operation in needed(trace.operations, {trace.rare})] if tested_first else []
    ends = [name for name in operations if name not in used]
    return [operations[name] for name in depth_first([*tested, *ends], operands.__getitem__)]


class Lines(list[Line]):
    """Lines of code in their order; a row is read once, before its first use."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: set[str] = set()

    def read(self, name: Operand) -> None:
        """Add a load if ``name`` is a row that has not been read."""
        if isinstance(name, str):
            self.reads((name,))

    def reads(self, names: tuple[str, ...]) -> None:
        """Add loads of those ``names`` that are rows and have not been read."""
        for name in names:
            if name[0] == "v" and name not in self.loaded:
                self.loaded.add(name)
                self.append(Load(int(name[1:])))


def double_buffered(trace: Trace, operations: list[Operation]) -> list[Line]:
    """Return lines that read each row at its first use and write results to another copy of the state as soon
    as they are known.

    The test is the last line: if it rejects the step, the copy that was read is unchanged.
    """
    rows: dict[Operand, list[int]] = {}
    for row, value in trace.stores.items():
        rows.setdefault(value, []).append(row)
    out = Lines()

    for operation in operations:
        out.reads(trace.uses[operation.name])
        out.append(operation)
        out += [Store(row, operation.name) for row in rows.pop(operation.name, ())]
    for value, left in rows.items():  # numbers, and rows that take the place of others
        out.read(value)
        out += [Store(row, value) for row in left]
    return [*out, Test(trace.rare)] if isinstance(trace.rare, str) else out


def in_place(trace: Trace, operations: list[Operation]) -> list[Line]:
    """Return lines that read each row at its first use and write it, after the test, as soon as its old value
    is no longer needed.
    """
    # A row is written after the test, after its own value is computed and after the last use of its old
    # value. Rows whose old value is stored into another row, and constants, are written at the end.
    last = {
        name: k
        for k, operation in enumerate(operations)
        for name in trace.uses[operation.name]
        if name[0] == "v"
    }
    place = {operation.name: k for k, operation in enumerate(operations)}
    test = place[trace.rare] if isinstance(trace.rare, str) else -1
    due: dict[int, list[int]] = {}
    at_end: list[int] = []
    sources = set(trace.stores.values())
    for row, value in trace.stores.items():
        if f"v{row}" in sources or not isinstance(value, str) or is_row(value) or value not in place:
            at_end.append(row)
        else:
            due.setdefault(max(test, last.get(f"v{row}", -1), place[value]), []).append(row)
    out = Lines()

    for k, operation in enumerate(operations):
        out.reads(trace.uses[operation.name])
        out.append(operation)
        if k == test:
            out.append(Test(trace.rare))
        out += [Store(row, trace.stores[row]) for row in due.get(k, ())]
    for row in at_end:
        out.read(trace.stores[row])
    return out + [Store(row, trace.stores[row]) for row in at_end]


DISTANT_LINES = 20  # lines since its last use after which a row is read again


class Reload(NamedTuple):
    """Read a row once more, as ``name``: its value before the step, or the one ``written`` in this step."""

    name: str
    row: int
    written: bool


def reread(lines: Iterable[Line]) -> list[Line | Reload]:
    """Return the same lines with rows read again that have not been used for DISTANT_LINES lines.

    This is correct because a row is written only after the last use of its old value, or to another copy of
    the state.
    """
    rows: dict[Operand, tuple[int, bool]] = {}
    names: dict[Operand, Operand] = {}  # under which a number was read last
    used: dict[Operand, int] = {}
    out: list[Line | Reload] = []
    for place, line in enumerate(lines):
        if type(line) is Operation:
            name, operator, operands = line
            for operand in operands:
                if type(operand) is str:
                    if operand in rows and place - used[operand] > DISTANT_LINES:
                        names[operand] = f"r{len(out)}"
                        out.append(Reload(f"r{len(out)}", *rows[operand]))
                    used[operand] = place
            line = Operation(name, operator, tuple([names.get(o, o) for o in operands]))
            used[name] = place
        elif isinstance(line, Load):
            rows[f"v{line.row}"], used[f"v{line.row}"] = (line.row, False), place
        elif isinstance(line, Store):
            value, line = line.value, Store(line.row, names.get(line.value, line.value))
            if value in used:
                rows.setdefault(value, (line.row, True))
        out.append(line)
    return out


def steady(step: Trace, changing: Collection[int]) -> tuple[list[Line | Reload], Trace]:
    """Return the operations whose result is the same in every step, as lines to execute once, and the step
    without them. Rows ``changing`` are written before each step by others.
    """
    moving = {f"v{row}" for row in (*step.stores, *changing)}
    result: dict[str, Operation] = {}
    for operation in step.operations:
        if operation.name != step.rare and all(
            name in result or (is_row(name) and name not in moving) for name in operation.uses
        ):
            result[operation.name] = operation
    lines: list[Line | Reload] = [
        Reload(f"s{name[1:]}", int(name[1:]), False) for name in rows_used(result.values())
    ]
    for name, operator, operands in result.values():
        lines.append(
            Operation(
                name,
                operator,
                tuple(f"s{o[1:]}" if isinstance(o, str) and is_row(o) else o for o in operands),
            )
        )
    return lines, Trace(tuple(o for o in step.operations if o.name not in result), step.stores, step.rare)


def settled(step: Trace, changing: Collection[int]) -> tuple[dict[int, Operand], Trace]:
    """Return the rows that get the same constant in every step and that no operation reads, and the step
    without them: they are written once.
    """
    read = {*rows_used(step.operations), *(f"v{row}" for row in changing)} | {
        value for value in step.stores.values() if is_row(value)
    }
    result: dict[int, Operand] = {
        row: value
        for row, value in step.stores.items()
        if not isinstance(value, str) and f"v{row}" not in read
    }
    return result, Trace(
        step.operations, {row: value for row, value in step.stores.items() if row not in result}, step.rare
    )
