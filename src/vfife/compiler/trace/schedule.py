"""The order of straight-line code: what the next step waits for comes first, rows are read where they are
first used and written at once.

A processor looks a few hundred instructions ahead; a step has more than a thousand. In the order of the
data-driven loop (one joint after the other) it waits for roots and quotients with little else to do; ordered
by the length of what still depends on a line, the same lines take two thirds of the time. The elements of a
frame wait less for themselves than for room in the processor: there the data-driven order, which has fewest
numbers that wait for their use, is left only where its next line would have to wait. Order changes no bit:
each line is one assignment.

What the rare condition waits for comes before all else, and nothing is written before it is known: a step
that must not be taken has changed nothing, so that nothing is ever undone.

Rows are read again rather than kept: a step has a hundred numbers that wait for their next use, and a
processor sixteen registers.

A compiler puts aside what it has no register for, and so writes a number that lies in its row anyway. The
rows of a state are as near as what is put aside, so a row, read or written, is read again where it has not
been used for a while; what no row holds is left to the compiler. What does not change from step to step is
computed once, before the first. Neither changes a bit.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple, TypeAlias

from .tape import Operand, Operation, Trace, is_row, rows_used

FORWARD = 8  # cycles from a store to a load of the same row
WIDTH = 3  # lines begun in a cycle
# lines that are looked at in search of the next, in a step of more than SHORT lines; in a shorter one all of
# them are
WINDOW = 100
# lines, as many as a processor keeps decoded: the code of a longer step is fetched, and its length counts
# more than waiting
SHORT = 1600
STEPS = 3  # over which it is counted what waits for a line
URGENT = (
    400  # cycles, over as many steps, by which what waits for a line is shorter than all steps at the most
)
CYCLES = {"sqrt": 21, "/": 13}  # rough latency, 3 of all others


class Load(NamedTuple):
    """A row is read."""

    row: int


class Store(NamedTuple):
    """A row is written."""

    row: int
    value: Operand


class Test(NamedTuple):
    """Where the rare condition is true, the step ends here."""

    condition: Operand


Line: TypeAlias = "Load | Store | Test | Operation"


def remaining(trace: Trace) -> dict[str, int]:
    """Cycles from the end of each operation to the end of what waits for it, counted over three steps."""
    rows: dict[Operand, list[str]] = {}
    for number, value in trace.stores.items():
        rows.setdefault(value, []).append(f"v{number}")
    after: dict[str, int] = {}
    backwards = [
        (o.name, tuple(set(trace.uses[o.name])), CYCLES.get(o.operator, 3), rows.get(o.name, ()))
        for o in reversed(trace.operations)
    ]
    loads: dict[str, int] = {}
    for _ in range(STEPS):
        later: dict[str, int] = {}
        for name, uses, cycles, stored in backwards:
            most = later.get(name, 0)
            for row in stored:
                most = max(most, FORWARD + loads.get(row, 0))
            after[name] = most
            for used in uses:
                if later.get(used, 0) < most + cycles:
                    later[used] = most + cycles
        loads = {used: most for used, most in later.items() if is_row(used)}
    return after


def ordered(trace: Trace, tested_first: bool = True) -> list[Operation]:
    """List scheduling: of the operations whose operands are there, the most urgent first, then the next of
    the streamed order.

    Urgent is what has so much behind it that the steps would take longer if it waited: longer than what waits
    for one another in them, or than ``WIDTH`` lines a cycle allow. A chain of rigid bodies is ordered by that
    alone. The elements of a frame are made one after the other, and of the next as much as is needed for not
    waiting: by what is behind them, all would be begun at once and be put aside for want of registers, which
    takes half as long again. In a long step only so many operations ahead are looked at, so that fewer are
    put aside.

    Before all this comes what the test waits for. Where results go to another copy of the state, nothing has
    to wait for the test, and it comes when it may (not ``tested_first``).
    """
    operations = streamed(trace, tested_first)
    place = {operation.name: k for k, operation in enumerate(operations)}
    after = remaining(trace)
    most = [after[operation.name] for operation in operations]
    allowed = max(max(most, default=0), STEPS * len(operations) // WIDTH) - URGENT
    for k in _ahead(trace, place) if tested_first else ():
        most[k] += 1 << 30
    missing = [0] * len(operations)
    users: list[list[int]] = [[] for _ in operations]
    takes = [CYCLES.get(operation.operator, 3) for operation in operations]
    for k, operation in enumerate(operations):
        for name in set(trace.uses[operation.name]):
            at = place.get(name)
            if at is not None:
                missing[k] += 1
                users[at].append(k)
    begin = [0] * len(operations)  # cycle at which an operation's operands are there
    waiting = Waiting(most, allowed)
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
            there = cycle + takes[k]
            for user in users[k]:
                missing[user] -= 1
                if begin[user] < there:
                    begin[user] = there
                if not missing[user] and user < high:
                    waiting.put(user, begin[user])
        cycle += 1
    return result


class Waiting:
    """Operations, by number, whose operands are there or will be. ``most`` is behind each; at cycle n it is
    urgent from ``allowed`` - n on.
    """

    def __init__(self, most: list[int], allowed: int) -> None:
        self.most, self.allowed = most, allowed
        self.done = [False] * len(most)
        self.coming: list[tuple[int, int]] = []
        self.streamed: list[int] = []
        self.urgent: list[tuple[int, int]] = []  # the same operations

    def put(self, k: int, begin: int) -> None:
        """Operation k may begin at a cycle."""
        heapq.heappush(self.coming, (begin, k))

    def due(self, cycle: int) -> Iterator[int]:
        """Those that begin in a cycle."""
        while self.coming and self.coming[0][0] <= cycle:
            k = heapq.heappop(self.coming)[1]
            heapq.heappush(self.streamed, k)
            heapq.heappush(self.urgent, (-self.most[k], k))
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


def streamed(trace: Trace, tested_first: bool = True) -> list[Operation]:
    """Each operation just before it is needed: first all that the test waits for, then result after result,
    element by element.
    """
    operations, uses = trace.operations, trace.uses
    place = {operation.name: k for k, operation in enumerate(operations)}
    before = [
        [at for name in reversed(uses[operation.name]) if (at := place.get(name)) is not None]
        for operation in operations
    ]
    used = {k for places in before for k in places}
    ends = [k for k in range(len(operations)) if k not in used]
    done = [False] * len(operations)
    result: list[Operation] = []
    for end in [*(sorted(_ahead(trace, place)) if tested_first else ()), *ends]:
        waiting = [(end, False)]
        while waiting:
            k, complete = waiting.pop()
            if done[k]:
                continue
            if complete:
                done[k] = True
                result.append(operations[k])
            else:
                waiting.append((k, True))
                waiting += [(at, False) for at in before[k] if not done[at]]
    return result


def _ahead(trace: Trace, place: dict[str, int]) -> set[int]:
    """The operations that the rare condition waits for, by their ``place``."""
    result: set[int] = set()
    waiting = [trace.rare]
    while waiting:
        name = waiting.pop()
        k = place.get(name, -1) if isinstance(name, str) else -1
        if k >= 0 and k not in result:
            result.add(k)
            waiting += trace.uses[str(name)]
    return result


class Lines(list[Line]):
    """Lines in the order in which they are written."""

    def __init__(self) -> None:
        super().__init__()
        self.there: set[str] = set()

    def read(self, name: Operand) -> None:
        """A row is read where it is first asked for."""
        if isinstance(name, str):
            self.reads((name,))

    def reads(self, names: tuple[str, ...]) -> None:
        """Those of several names that are rows."""
        for name in names:
            if name[0] == "v" and name not in self.there:
                self.there.add(name)
                self.append(Load(int(name[1:])))


def double_buffered(trace: Trace, operations: list[Operation]) -> list[Line]:
    """Operations with each row read where it is first used; what is written goes to another copy of the state
    as soon as it is known.

    The test is the last line: where it stops the step, the copy that was read is as it was.
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
    """Operations with each row read where it is first used, and written, behind the test, as soon as its old
    value is no longer needed.
    """
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


FAR = 20  # lines since a number was used last


class Again(NamedTuple):
    """A row is read once more, as ``name``: what it was before the step, or what was ``written``."""

    name: str
    row: int
    written: bool


def reread(lines: Iterable[Line]) -> list[Line | Again]:
    """The same lines with rows read again.

    A row is written behind the last use of what it was, or to another copy of the state.
    """
    rows: dict[Operand, tuple[int, bool]] = {}
    names: dict[Operand, Operand] = {}  # under which a number was read last
    used: dict[Operand, int] = {}
    out: list[Line | Again] = []
    for place, line in enumerate(lines):
        if type(line) is Operation:
            name, operator, operands = line
            for operand in operands:
                if type(operand) is str:
                    if operand in rows and place - used[operand] > FAR:
                        names[operand] = f"r{len(out)}"
                        out.append(Again(f"r{len(out)}", *rows[operand]))
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


def steady(step: Trace, changing: Collection[int]) -> tuple[list[Line | Again], Trace]:
    """Lines that give the same before every step, and a step without them; rows ``changing`` are made anew
    before each.
    """
    moving = {f"v{row}" for row in (*step.stores, *changing)}
    result: dict[str, Operation] = {}
    for operation in step.operations:
        if operation.name != step.rare and all(
            name in result or (is_row(name) and name not in moving) for name in operation.uses
        ):
            result[operation.name] = operation
    lines: list[Line | Again] = [
        Again(f"s{name[1:]}", int(name[1:]), False) for name in rows_used(result.values())
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
    """Rows that are the same number after every step and that none reads, and a step without them."""
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
