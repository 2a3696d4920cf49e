"""Derivatives of the measures of a run with respect to numbers of its model."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..files import DataTable

if TYPE_CHECKING:
    from ..measures.landings import Fall

# "derivative": finite changes agree with it. "change": they do not, and the change for one per cent is known.
# "unknown": neither is.
Kind = Literal["derivative", "change", "unknown"]
# Heads of the rows of a table of derivatives.
HEADS = (
    "measure", "value", "number", "model", "derivative", "elasticity", "from", "to", "meaningless", "kind",
    "change", "change_from", "change_to",
)  # fmt: skip


@dataclass(frozen=True)
class Derivative:
    """By one number, ``path``, whose ``value`` the model has (SI): the derivatives of measures, in their unit
    over its own.

    Those of a mechanism with contact are means over displaced runs. ``ranges`` covers displaced runs, other
    step sizes and finite changes of the number that agree with the derivative. ``changes`` are quotients in
    the same unit: the change of a measure when the number is changed by 1 %, over that change;
    ``change_ranges`` covers both signs of the change and the step sizes. ``kinds`` says which of the two
    holds (:data:`Kind`). ``runs`` is the number of displaced runs.
    """

    path: str
    value: float
    values: Mapping[str, float]
    ranges: Mapping[str, tuple[float, float]]
    changes: Mapping[str, float] = field(default_factory=dict)
    change_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    kinds: Mapping[str, Kind] = field(default_factory=dict)
    runs: int = 1

    @property
    def displaced(self) -> bool:
        """Whether it was taken of several displaced runs."""
        return self.runs > 1


class Effect(NamedTuple):
    """Effect of a number on a measure: per cent of the measure for one per cent of the number, with its
    range.

    Of kind "derivative" the value is an elasticity, of kind "change" the change for one per cent. Of kind
    "unknown" the value is the change that was computed, which is no result: its sign or its order of
    magnitude is not known, or nothing was computed (NaN).
    """

    path: str
    kind: Kind
    value: float
    low: float
    high: float

    @property
    def size(self) -> float:
        """Size of the value or, where it is unknown, of the farther end of its range."""
        return max(abs(self.low), abs(self.high)) if self.kind == "unknown" else abs(self.value)


@dataclass
class Sensitivity(DataTable):
    """Derivatives of ``measures`` (SI) by numbers of a model.

    ``refused`` are numbers without derivatives, and why; ``doubtful`` measures that the run's companions do
    not agree on: what they depend on the steps decide, so that their derivatives mean nothing. ``rounding``:
    measures that are left out, being rounding beside the largest of their unit. ``part``: of the run that the
    measures are of. One that is not ``complete`` was interrupted: derivatives are missing, and none is
    checked by finite changes. ``fall`` is that of the journals at the start, where it makes largest forces.
    """

    mechanism: str
    measures: Mapping[str, float]
    derivatives: list[Derivative] = field(default_factory=list)
    refused: Mapping[str, str] = field(default_factory=dict)
    doubtful: frozenset[str] = frozenset()
    rounding: frozenset[str] = frozenset()
    part: str = "last turn"
    complete: bool = True
    fall: Fall | None = None

    @property
    def progress(self) -> str:
        """How much is computed of an interrupted answer; empty for a complete one."""
        return "" if self.complete else f"{len(self.derivatives)} of the derivatives"

    def __repr__(self) -> str:
        measures = "1 measure" if len(self.measures) == 1 else f"{len(self.measures)} measures"
        content = f"{measures} of {self.mechanism!r} to {len(self.derivatives)} numbers"
        content += ", interrupted" if self.progress else ""
        return (
            f"<Sensitivity of {content}; see .effects(measure), .derivative(measure, path), .to_dataframe()>"
        )

    def derivative(self, measure: str, path: str) -> float:
        """Return the derivative of a measure by a number, in their SI units; warns where it is not known to
        hold, as tables show by another sign or "?". Raises KeyError where there is none.
        """
        slope = self._slope(measure, path)
        if (kind := self.kind(measure, path)) != "derivative":
            known = "only the change for one per cent is known" if kind == "change" else "nothing is known"
            warnings.warn(
                f"the derivative of {measure} by {path} is not known to hold: {known}, see"
                f" effect({measure!r}, {path!r})",
                stacklevel=2,
            )
        return slope

    def elasticity(self, measure: str, path: str) -> float:
        """Change of a measure in per cent for one per cent of a number: (p / m) dm/dp; infinite for a measure
        that is zero. It is what was computed, also where :meth:`known` is false.
        """
        return self._relative(path, measure, self._slope(measure, path))

    def elasticities(self, measure: str) -> dict[str, float]:
        """Return the elasticities of a measure by every number, also those that are not known to hold."""
        return {path: self.elasticity(measure, path) for path in self._paths(measure)}

    def span(self, measure: str, path: str) -> tuple[float, float]:
        """Return the range of an elasticity over displaced runs, step sizes and finite changes that agree
        with it.
        """
        return self._range(path, measure, self._by(path).ranges[measure])

    def change(self, measure: str, path: str) -> float:
        """Change of a measure (%) with a finite change of one per cent. Raises KeyError without one."""
        return self._relative(path, measure, self._by(path).changes[measure])

    def change_span(self, measure: str, path: str) -> tuple[float, float]:
        """Return the range of :meth:`change` over both signs and step sizes. Raises KeyError where there was
        none.
        """
        return self._range(path, measure, self._by(path).change_ranges[measure])

    def kind(self, measure: str, path: str) -> Kind:
        """Return what is known: a derivative, the change for one per cent alone, or neither."""
        number = self._by(path)
        if measure in self.doubtful:
            return "unknown"
        if measure in number.kinds:
            return number.kinds[measure]
        low, high = number.ranges[measure]
        return "derivative" if low * high >= 0.0 else "unknown"

    def known(self, measure: str, path: str) -> bool:
        """Return whether the derivative holds: its sign is known, finite changes agree with it and companions
        with the measure.
        """
        return self.kind(measure, path) == "derivative"

    def effect(self, measure: str, path: str) -> Effect:
        """Return what is known of a measure and a number, as the command shows it."""
        kind, number = self.kind(measure, path), self._by(path)
        if kind == "derivative" or not number.kinds:
            return Effect(path, kind, self.elasticity(measure, path), *self.span(measure, path))
        if measure not in number.changes:
            return Effect(path, kind, math.nan, -math.inf, math.inf)
        return Effect(path, kind, self.change(measure, path), *self.change_span(measure, path))

    def effects(self, measure: str) -> list[Effect]:
        """Return what is known of a measure by every number, the largest value first. Numbers whose effect
        is unknown stand last, that with the largest end of its range first; their value means nothing.
        """
        effects = [self.effect(measure, path) for path in self._paths(measure)]
        return sorted(effects, key=lambda effect: (effect.kind == "unknown", -effect.size))

    def ranked(self, measure: str) -> list[tuple[str, float]]:
        """Numbers and what is known of a measure by them, the largest first: the elasticity or, where finite
        changes do not agree with it, the change for one per cent. Numbers of which neither is known stand
        last, with NaN; :meth:`effects` has their ranges, and :meth:`elasticity` what was computed.
        """
        pairs = [
            (path, math.nan if kind == "unknown" else value)
            for path, kind, value, _, _ in (self.effect(measure, path) for path in self._paths(measure))
        ]
        return sorted(pairs, key=lambda item: math.inf if math.isnan(item[1]) else -abs(item[1]))

    def spread(self, measure: str) -> float:
        """Return the widest range of a derivative of a measure that holds, as a share of the largest."""
        effects = [
            effect
            for effect in self.effects(measure)
            if effect.kind == "derivative" and math.isfinite(effect.value)
        ]
        largest = max((abs(effect.value) for effect in effects), default=0.0)
        widest = max((effect.high - effect.low for effect in effects), default=0.0)
        return widest / largest if widest and largest else 0.0

    def _paths(self, measure: str) -> list[str]:
        """Return the numbers by which a measure has derivatives."""
        return [number.path for number in self.derivatives if measure in number.values]

    def _slope(self, measure: str, path: str) -> float:
        """Return the derivative that was computed, whether it holds or not."""
        return self._by(path).values[measure]

    def _by(self, path: str) -> Derivative:
        return next(number for number in self.derivatives if number.path == path)

    def _relative(self, path: str, measure: str, slope: float) -> float:
        """Return the per cent of the measure for one per cent of the number, from a slope in their units."""
        size = self.measures[measure]
        return (
            self._by(path).value / size * slope if size else math.copysign(math.inf, slope) if slope else 0.0
        )

    def _range(self, path: str, measure: str, slopes: tuple[float, float]) -> tuple[float, float]:
        low, high = sorted(self._relative(path, measure, slope) for slope in slopes)
        return low, high

    def rows(self) -> list[dict[str, str | float | bool | None]]:
        """Return a map for every measure and number, in the order of :meth:`ranked`, for tables. What was not
        computed is None; "meaningless" and "kind" mark what is not known. A measure without any derivative,
        because runs with other time steps disagree on it, has one row without a number.
        """
        rows = []
        for measure, value in self.measures.items():
            rows += [self._row(measure, path) for path, _ in self.ranked(measure)]
            if self.undetermined:
                unknown = {"measure": measure, "value": value, "meaningless": True, "kind": "unknown"}
                rows.append(dict.fromkeys(HEADS) | unknown)
        return rows

    @property
    def undetermined(self) -> bool:
        """Whether no derivative was computed, because runs with other time steps disagree on all measures."""
        return self.complete and not self.derivatives and bool(self.measures.keys() & self.doubtful)

    def _row(self, measure: str, path: str) -> dict[str, str | float | bool | None]:
        low, high = self.span(measure, path)
        changed = measure in self._by(path).changes
        low_change, high_change = self.change_span(measure, path) if changed else (None, None)
        return {
            "measure": measure, "value": self.measures[measure], "number": path,
            "model": self._by(path).value,
            "derivative": self._slope(measure, path), "elasticity": self.elasticity(measure, path),
            "from": low, "to": high,
            "meaningless": not self.known(measure, path), "kind": self.kind(measure, path),
            "change": self.change(measure, path) if changed else None, "change_from": low_change,
            "change_to": high_change,
        }  # fmt: skip

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield :meth:`rows` as heads and rows."""
        yield HEADS
        yield from (list(row.values()) for row in self.rows())
