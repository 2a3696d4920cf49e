"""Which quantity of which command differs first between two sets of answers, and by how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Difference:
    """The first quantity of a command that differs, and how many do."""

    command: str
    quantity: str
    first: Any
    other: Any
    count: int

    def __str__(self) -> str:
        more = f" (and {self.count - 1} more)" if self.count > 1 else ""
        return f"{self.command}: {self.quantity} = {self.first!r} here, {self.other!r} there{more}"


def differences(here: Mapping[str, Any], there: Mapping[str, Any]) -> Iterator[Difference]:
    """Of each command that does not answer the same. What no file can lack comes first: exit code, rows, then
    what is printed.
    """
    for command in here:
        if command not in there:
            yield Difference(command, "answer", "present", "absent", 1)
            continue
        found = list(unequal(here[command], there[command]))
        if found:
            yield Difference(command, *found[0], len(found))


def unequal(here: Mapping[str, Any], there: Mapping[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Quantities of one command with both values; numbers are the same only to the bit."""
    for kind in ("exit", "said", "rows", "printed", "table"):
        first, other = here.get(kind), there.get(kind)
        if not isinstance(first, dict) or not isinstance(other, dict):
            if first != other:
                yield kind, first, other
            continue
        for name in [*first, *(name for name in other if name not in first)]:
            if repr(first.get(name)) != repr(other.get(name)):
                yield f"{'row ' if kind == 'rows' else ''}{name}", first.get(name), other.get(name)


def first_row(here: Path, there: Path) -> str:
    """Of two runs of one command, the first output at which rows differ, and the first of these rows; empty
    where there is none to read.
    """
    from matrix.commands import rows

    try:
        first, other = rows(here), rows(there)
    except Exception as error:  # a run that one machine could not make
        return f"not to be read: {error}"
    steps, others = first["step number"], other["step number"]
    if steps.tolist() != others.tolist():
        return f"steps differ: {len(steps)} and {len(others)} outputs, the last {steps[-1]} and {others[-1]}"
    at = {}
    for name, values in first.items():
        if (
            name in other
            and values.ndim == 1
            and values.shape == other[name].shape
            and (apart := unlike(values, other[name])).any()
        ):
            at[name] = int(np.argmax(apart))
    if not at:
        return ""
    name = min(at, key=at.__getitem__)
    k = at[name]
    some = sum(one == k for one in at.values())
    return (
        f"first at output {k}: {name} = {first[name][k]!r} here, {other[name][k]!r} there; {some} rows differ"
        " there"
    )


def unlike(first: Any, other: Any) -> Any:
    """Where numbers differ in a bit."""
    return np.asarray(first, dtype=float).view(np.int64) != np.asarray(other, dtype=float).view(np.int64)
