"""How the measures of a run depend on the numbers of its model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .csvtable import write_named


@dataclass(frozen=True)
class Derivative:
    """By one number, ``path``, whose ``value`` the model has (SI): the derivatives of measures, in their unit over its own.

    Those of a mechanism with contact are means over displaced runs; ``ranges`` says from the least to the largest of them.
    """

    path: str
    value: float
    values: Mapping[str, float]
    ranges: Mapping[str, tuple[float, float]]

    @property
    def displaced(self) -> bool:
        """Whether it was taken of several runs."""
        return any(low < high for low, high in self.ranges.values())


@dataclass
class Sensitivity:
    """Derivatives of ``measures`` (SI) by numbers of a model.

    ``refused`` are numbers without derivatives, and why; ``doubtful`` measures that the run's companions do not agree on: what they depend on the
    steps decide, so that their derivatives mean nothing. ``rounding``: measures that are left out, being rounding beside the largest of their unit.
    ``part``: of the run that the measures are of.
    """

    mechanism: str
    measures: Mapping[str, float]
    derivatives: list[Derivative] = field(default_factory=list)
    refused: Mapping[str, str] = field(default_factory=dict)
    doubtful: frozenset[str] = frozenset()
    rounding: frozenset[str] = frozenset()
    part: str = "last turn"

    def __repr__(self) -> str:
        what = f"{len(self.measures)} measures of {self.mechanism!r} to {len(self.derivatives)} numbers"
        return f"<Sensitivity of {what}; see .ranked(measure), .derivative(measure, path), .write_csv()>"

    def derivative(self, measure: str, path: str) -> float:
        """Derivative of a measure by a number, in their SI units. Raises KeyError where there is none."""
        return self._by(path).values[measure]

    def elasticity(self, measure: str, path: str) -> float:
        """By how many per cent a measure changes with one per cent of a number: (p / m) dm/dp; infinite of a measure that is zero."""
        return self._elastic(self._by(path), measure)

    def ranked(self, measure: str) -> list[tuple[str, float]]:
        """Numbers and elasticities of a measure, the largest first."""
        found = [(one.path, self._elastic(one, measure)) for one in self.derivatives if measure in one.values]
        return sorted(found, key=lambda item: -abs(item[1]))

    def span(self, measure: str, path: str) -> tuple[float, float]:
        """The least and the largest elasticity over displaced runs."""
        one = self._by(path)
        low, high = sorted(self._relative(one, measure, slope) for slope in one.ranges[measure])
        return low, high

    def spread(self, measure: str) -> float:
        """How far displaced runs lie apart in the elasticities of a measure, as a share of the largest: what its derivatives are known within."""
        spans = [self.span(measure, path) for path, _ in self.ranked(measure)]
        largest = max((abs(elastic) for _, elastic in self.ranked(measure)), default=0.0)
        widest = max((high - low for low, high in spans), default=0.0)
        return widest / largest if widest and math.isfinite(largest) else 0.0

    def known(self, measure: str, path: str) -> bool:
        """Whether all displaced runs agree on its sign, and the run's companions on the measure."""
        low, high = self._by(path).ranges[measure]
        return measure not in self.doubtful and low * high >= 0.0

    def _by(self, path: str) -> Derivative:
        return next(one for one in self.derivatives if one.path == path)

    def _elastic(self, one: Derivative, measure: str) -> float:
        return self._relative(one, measure, one.values[measure])

    def _relative(self, one: Derivative, measure: str, slope: float) -> float:
        size = self.measures[measure]
        return one.value / size * slope if size else math.copysign(math.inf, slope) if slope else 0.0

    def rows(self) -> list[dict[str, str | float | bool]]:
        """A map for every measure and number, for tables."""
        return [
            {
                "measure": measure, "value": self.measures[measure], "number": path, "model": self._by(path).value,
                "derivative": self.derivative(measure, path), "elasticity": elastic,
                "from": self.span(measure, path)[0], "to": self.span(measure, path)[1], "meaningless": not self.known(measure, path),
            }
            for measure in self.measures for path, elastic in self.ranked(measure)
        ]  # fmt: skip

    def write_csv(self, path: str | Path) -> None:
        """Writes :meth:`rows` as a table of commas."""
        write_named(path, ["measure", "value", "number", "model", "derivative", "elasticity", "from", "to", "meaningless"], self.rows())
