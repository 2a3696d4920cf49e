"""A verification case: a model, numbers read from its run, and references that were not made by this
program.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from .tolerances import LARGEST

Rows = Iterator["Row"]


@dataclass(frozen=True)
class Row:
    """A number beside its reference: error = (value - reference)/scale, passed where |error| is at most the
    tolerance.

    The scale is |reference| unless given, as it has to be where the reference is zero. A ``note`` says why
    there is no number. ``counts`` are the numbers behind a share: by what is counted, how many of how many.
    """

    quantity: str
    unit: str
    reference: float
    value: float
    tolerance: float
    scale: float | None = None
    note: str = ""
    counts: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    @property
    def error(self) -> float:
        """Relative to the scale (1)."""
        scale = abs(self.reference) if self.scale is None else self.scale
        return (self.value - self.reference) / scale if scale > 0.0 else math.nan

    @property
    def counted(self) -> str:
        """The counts in words, as ``3 of 4 measures inside; 1 of 1 runs``; empty without any."""
        return "; ".join(f"{part} of {total} {name}" for name, (part, total) in self.counts.items())

    @property
    def passed(self) -> bool:
        """A number that is not finite never passes."""
        return abs(self.error) <= self.tolerance


class Nudge:
    """What is wrong with a model on purpose, by name: a factor, 1 unless it is nudged."""

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self.values = dict(values or {})

    def __call__(self, name: str, otherwise: float = 1.0) -> float:
        """Return the perturbed value with this name, or ``otherwise`` in the unperturbed case."""
        return self.values.get(name, otherwise)


@dataclass(frozen=True)
class Case:
    """A case: ``rows`` builds the model, runs it and gives its numbers one by one.

    ``nudges`` are values of what the model asks its :class:`Nudge` for, each wrong by a little more than the
    tolerances allow: with them every row must fail under one of them at least. A ``quick`` case runs within a
    few seconds.
    """

    name: str
    title: str
    source: str
    family: str
    rows: Callable[[Nudge], Rows]
    nudges: Mapping[str, float]
    quick: bool = True

    def check(self, nudges: Mapping[str, float] | None = None) -> list[Row]:
        """All rows; one that fails with a note where the model could not be run."""
        rows: list[Row] = []
        try:
            largest = LARGEST.get(self.name, math.inf)
            rows.extend(
                replace(row, tolerance=min(row.tolerance, largest)) for row in self.rows(Nudge(nudges))
            )
        except (ArithmeticError, RuntimeError, ValueError, LookupError) as error:
            text = f"{type(error).__name__}: {error}"
            rows.append(Row("the run", "1", 0.0, math.nan, 0.0, note=text))
        return rows


@dataclass
class Register:
    """Cases by name, in the order in which they are written."""

    cases: dict[str, Case] = field(default_factory=dict)

    def __call__(
        self, title: str, source: str, *, nudges: Mapping[str, float], quick: bool = True
    ) -> Callable[[Callable[[Nudge], Rows]], Callable[[Nudge], Rows]]:
        """Register the decorated function as a case under its own name with hyphens."""

        def enter(rows: Callable[[Nudge], Rows]) -> Callable[[Nudge], Rows]:
            name = rows.__name__.replace("_", "-")
            if name in self.cases:
                raise ValueError(f"there is a case {name!r} already")
            family = rows.__module__.rpartition(".")[2]
            self.cases[name] = Case(name, title, source, family, rows, dict(nudges), quick)
            return rows

        return enter


verified = Register()


def entry(case: Case, row: Row) -> dict[str, Any]:
    """Format a row for ``vfife verify --json``."""
    fields: dict[str, Any] = {
        "case": case.name, "quantity": row.quantity, "unit": row.unit, "source": case.source,
        "reference": row.reference, "value": row.value,
        "error": row.error, "tolerance": row.tolerance, "passed": row.passed,
    }  # fmt: skip
    if row.counts:
        counts = row.counts.items()
        fields["counts"] = {name: {"count": part, "of": total} for name, (part, total) in counts}
    return {**fields, "note": row.note} if row.note else fields
