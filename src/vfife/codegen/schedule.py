"""The order of straight-line code: what the next step waits for comes first, rows are read where they are first used and written at once.

A processor looks a few hundred instructions ahead; a step has more than a thousand. In the order of the data-driven loop (one joint after the
other) it waits for roots and quotients with little else to do; ordered by the length of what still depends on a line, the same lines take
two thirds of the time. Order changes no bit: every line is a single assignment.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

FORWARD = 8  # cycles from a store to a load of the same row
WIDTH = 3  # lines begun in a cycle


@dataclass(frozen=True)
class Line:
    """One assignment: the name it makes, its right-hand side and the names that it uses."""

    name: str
    text: str
    uses: tuple[str, ...]

    @property
    def cycles(self) -> int:
        """Rough latency."""
        if "sqrt" in self.text:
            return 21
        return 13 if " / " in self.text else 3


def remaining(lines: list[Line], stores: dict[int, str]) -> dict[str, int]:
    """Cycles from the end of each line to the end of what waits for it, counted over three steps."""
    after = {line.name: 0 for line in lines}
    rows: dict[str, list[int]] = {}
    for row, name in stores.items():
        rows.setdefault(name, []).append(row)
    loads: dict[str, int] = {}
    for _ in range(3):
        later: dict[str, int] = {}
        for line in reversed(lines):
            waits = [FORWARD + loads.get(f"v{row}", 0) for row in rows.get(line.name, ())]
            after[line.name] = max([later.get(line.name, 0), *waits])
            for name in line.uses:
                later[name] = max(later.get(name, 0), after[line.name] + line.cycles)
        loads = {name: cycles for name, cycles in later.items() if name.startswith("v")}
    return after


def ordered(lines: list[Line], stores: dict[int, str]) -> list[Line]:
    """List scheduling: of the lines whose operands are there, the one with most behind it first."""
    rank = {line.name: k for k, line in enumerate(lines)}
    after = remaining(lines, stores)
    missing = {line.name: sum(name in rank for name in set(line.uses)) for line in lines}
    users: dict[str, list[Line]] = {}
    for line in lines:
        for name in set(line.uses):
            users.setdefault(name, []).append(line)
    ready = [(-after[line.name], rank[line.name]) for line in lines if not missing[line.name]]
    heapq.heapify(ready)
    coming: list[tuple[int, int]] = []
    result: list[Line] = []
    cycle = 0
    while len(result) < len(lines):
        while coming and coming[0][0] <= cycle:
            index = heapq.heappop(coming)[1]
            heapq.heappush(ready, (-after[lines[index].name], index))
        for _ in range(min(WIDTH, len(ready))):
            line = lines[heapq.heappop(ready)[1]]
            result.append(line)
            for user in users.get(line.name, ()):
                missing[user.name] -= 1
                if not missing[user.name]:
                    heapq.heappush(coming, (cycle + line.cycles, rank[user.name]))
        cycle += 1
    return result


def woven(lines: list[Line], stores: dict[int, str], lanes: int) -> list[str]:
    """The ordered lines with each row read where it is first used and written as soon as its old value is no longer needed."""
    lines = ordered(lines, stores)
    last = {name: k for k, line in enumerate(lines) for name in line.uses if name.startswith("v")}
    out: list[str] = []
    there: set[str] = set()

    def read(name: str) -> None:
        if name.startswith("v") and name not in there:
            there.add(name)
            out.append(f"{name} = S[{int(name[1:]) * lanes} + w]")

    sources = set(stores.values())
    made: set[str] = set()
    done: set[int] = set()
    waiting: dict[int, list[int]] = {}
    for row, value in stores.items():
        if f"v{row}" not in sources and not value.startswith("v"):
            waiting.setdefault(last.get(f"v{row}", -1), []).append(row)
    ready: dict[str, list[int]] = {}
    for k, line in enumerate(lines):
        for name in line.uses:
            read(name)
        out.append(f"{line.name} = {line.text}")
        made.add(line.name)
        free = ready.pop(line.name, [])
        for row in waiting.get(k, []) + (waiting.get(-1, []) if k == 0 else []):
            free.append(row) if stores[row] in made else ready.setdefault(stores[row], []).append(row)
        for row in free:
            out.append(f"S[{row * lanes} + w] = {stores[row]}")
            done.add(row)
    rest = {row: value for row, value in stores.items() if row not in done}
    for value in rest.values():
        read(value)
    return out + [f"S[{row * lanes} + w] = {value}" for row, value in rest.items()]
