"""Rows are read again rather than kept: a step has a hundred numbers that wait for their next use, and a processor sixteen registers.

A compiler puts aside what it has no register for, and so writes a number that lies in its row anyway. The rows of a state are as near as what is
put aside, so a row, read or written, is read again where it has not been used for a while; what no row holds is left to the compiler.
What does not change from step to step is computed once, before the first. Neither changes a bit.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from .schedule import Line, Load, Store
from .trace import Operand, Operation, Trace, is_row, rows_used

FAR = 20  # lines since a number was used last


class Again(NamedTuple):
    """A row is read once more, as ``name``: what it was before the step, or what was ``written``."""

    name: str
    row: int
    written: bool


def reread(lines: Iterable[Line]) -> list[Line | Again]:
    """The same lines with rows read again. A row is written behind the last use of what it was, or to another copy of the state."""
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
    """Lines that give the same before every step, and a step without them; rows ``changing`` are made anew before each."""
    moving = {f"v{row}" for row in (*step.stores, *changing)}
    found: dict[str, Operation] = {}
    for operation in step.operations:
        if operation.name != step.rare and all(name in found or (is_row(name) and name not in moving) for name in operation.uses):
            found[operation.name] = operation
    lines: list[Line | Again] = [Again(f"s{name[1:]}", int(name[1:]), False) for name in rows_used(found.values())]
    for name, operator, operands in found.values():
        lines.append(Operation(name, operator, tuple(f"s{o[1:]}" if isinstance(o, str) and is_row(o) else o for o in operands)))
    return lines, Trace(tuple(o for o in step.operations if o.name not in found), step.stores, step.rare)


def settled(step: Trace, changing: Collection[int]) -> tuple[dict[int, Operand], Trace]:
    """Rows that are the same number after every step and that none reads, and a step without them."""
    read = {*rows_used(step.operations), *(f"v{row}" for row in changing)} | {value for value in step.stores.values() if is_row(value)}
    found: dict[int, Operand] = {row: value for row, value in step.stores.items() if not isinstance(value, str) and f"v{row}" not in read}
    return found, Trace(step.operations, {row: value for row, value in step.stores.items() if row not in found}, step.rare)
