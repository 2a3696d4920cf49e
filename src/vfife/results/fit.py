"""A fit: values with their confidence, how they depend on each other, what the data cannot tell, curves
beside measured ones; and its file.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from ..files import write_rows, write_text
from ..numerics.scalar import log
from ..store.schemas import FIT, Schema
from ..store.store import Store, warn_of_damage

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
TELLS = (
    0.25  # of the way between its bounds: a confidence wider than that on either side, the data cannot tell
)
PART = 0.3  # of a direction's length from which a parameter is named in it
UNITS = {"time": "s", "angle": "rad", "penetration": "m", "frequency": "Hz", "order": "1"}  # of places
CLOSE = 0.01  # of a parameter's range, within which it lies on a bound


@dataclass(frozen=True)
class Value:
    """A parameter that was looked for: its ``paths``, ``value`` in ``unit`` (SI), standard ``error``,
    confidence from ``low`` to ``high``, bounds.

    ``former``: what it was in the model, None where it was not one number within the bounds. ``known``: False
    where curves at the best point are those of its steps, or of one turn that does not repeat; low and high
    are then no more than the ends of all points that fit as well.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    value: float
    error: float
    low: float
    high: float
    bounds: tuple[float, float]
    former: float | None = None
    logarithmic: bool = False
    known: bool = True

    def share(self, value: float) -> float:
        """Where a value lies between the bounds, 0 to 1; by its logarithm where it was looked for so."""
        low, high = self.bounds
        if self.logarithmic:
            return log(max(value, 1e-3 * low) / low) / log(high / low)
        return (value - low) / (high - low)

    @property
    def told(self) -> bool:
        """Whether the data tell it: its confidence is known, and narrow beside the range that it was looked
        for in.
        """
        return self.known and self.share(self.high) - self.share(self.value) <= TELLS

    @property
    def at_bound(self) -> bool:
        """Whether it lies on a bound."""
        return min(self.share(self.value), 1.0 - self.share(self.value)) <= CLOSE


@dataclass(frozen=True)
class Laid:
    """A measured curve and the model's at ``places`` (s, rad, m; of spectra Hz, or orders: cycles a turn),
    both in ``unit``; factor and level.

    ``over`` says what the places are: "time", "angle", "penetration", "frequency", "order".
    """

    channel: str
    head: str
    unit: str
    over: str
    places: Array
    measured: Array
    model: Array
    factor: float = 1.0
    level: float = 0.0

    @property
    def share(self) -> float:
        """Root mean square of what is left, over the standard deviation of what was measured."""
        spread = float(self.measured.std())
        left = self.model - self.measured
        return float(np.sqrt((left * left).mean())) / spread if spread > 0.0 else float("inf")


@dataclass
class Fit:
    """``values`` and their ``correlation``; the ``offset`` (s or rad) of the first sample with its standard
    error; ``curves``.

    ``directions`` are combinations of parameters in units of their ranges, the least determined first, with
    the standard deviation of each. ``starts``: cost and values of each local search. ``derivatives`` says
    what they were taken by, ``autocorrelation`` of the residuals from one sample to the next, by which errors
    are widened. ``status``: "complete", or "interrupted" with the best so far, without errors.
    """

    mechanism: str
    data: str
    status: str
    values: list[Value]
    correlation: Array
    directions: list[tuple[float, Array]]
    offset: float
    offset_error: float
    over: str
    curves: list[Laid]
    starts: list[tuple[float, tuple[float, ...]]]
    evaluations: int
    failed: int
    derivatives: str
    autocorrelation: float
    confidence: float
    seconds: float
    compared: str = "curve"
    notes: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        found = ", ".join(
            f"{one.name} = {one.value:.5g} {'' if one.unit == '1' else one.unit}".rstrip()
            for one in self.values
        )
        return (
            f"<Fit of {self.mechanism!r} to {self.data!r}: {found}; see .to_dataframe(), .undetermined,"
            " .plot()>"
        )

    def __getitem__(self, name: str) -> Value:
        """A parameter by its name or one of its paths. Raises KeyError."""
        for one in self.values:
            if name == one.name or name in one.paths:
                return one
        raise KeyError(
            f"{name!r} was not looked for; these were: {', '.join(one.name for one in self.values)}"
        )

    @property
    def set(self) -> list[tuple[str, float]]:
        """Paths and values, as ``load_model(path, set=...)`` takes them."""
        return [(path, one.value) for one in self.values for path in one.paths]

    @property
    def share(self) -> float:
        """Root mean square of all residuals over the deviations of the measured curves."""
        return float(np.sqrt(np.mean([one.share * one.share for one in self.curves])))

    @property
    def undetermined(self) -> list[str]:
        """What the data cannot tell, in sentences."""
        found = []
        for deviation, direction in self.directions:
            if not deviation > TELLS:
                continue
            order = [k for k in np.argsort(-np.abs(direction), kind="stable") if abs(direction[k]) >= PART]
            names = [self.values[k].name for k in order]
            if len(names) == 1:
                found.append(
                    f"{names[0]}: within its bounds it changes the curves by less than what they miss the"
                    " data by"
                )
                continue
            ways = [
                f"{self.values[k].name} {'up' if direction[k] * direction[order[0]] > 0.0 else 'down'}"
                for k in order
            ]
            found.append(
                f"{', '.join(names[:-1])} and {names[-1]} one by one: {' with '.join(ways)} changes the"
                " curves by less than they miss the data"
            )
        return found

    @property
    def remarks(self) -> list[str]:
        """How it was found, in sentences."""
        found = []
        if self.offset_error > 0.0 or self.offset != 0.0:
            factor, unit = (1e3, "ms") if self.over == "time" else (57.29577951308232, "deg")
            error = f" ± {factor * self.offset_error:.2g}" if np.isfinite(self.offset_error) else ""
            found.append(
                f"The first sample lies {factor * self.offset:.5g}{error} {unit} into a turn or after its"
                " time in the file."
            )
        near = [cost for cost, _ in self.starts if cost <= 1.1 * self.starts[0][0]]
        if self.starts and self.evaluations:
            found.append(
                f"{len(near)} of {len(self.starts)} searches came to this point, by {self.derivatives};"
                f" {self.evaluations} runs."
            )
        if self.autocorrelation > 0.1:
            found.append(
                f"Residuals follow one another (correlation {self.autocorrelation:.2f}): more than noise is"
                " left, and errors are widened."
            )
        bound = [one.name for one in self.values if one.at_bound]
        if bound:
            found.append(f"At a bound, so perhaps beyond it: {', '.join(bound)}.")
        return found

    def json(self) -> dict[str, Any]:
        """All of it but the curves, as JSON has it."""
        return {
            "model": self.mechanism, "data": self.data, "status": self.status, "compared": self.compared, "confidence": self.confidence,
            "parameters": [vars_of(one) for one in self.values], "correlation": self.correlation.tolist(),
            "undetermined": self.undetermined, "offset": {"value": self.offset, "error": self.offset_error, "unit": UNITS[self.over]},
            "curves": [{"channel": c.channel, "column": c.head, "unit": c.unit, "residual": c.share, "factor": c.factor, "level": c.level}
                       for c in self.curves],
            "residual": self.share, "autocorrelation": self.autocorrelation, "derivatives": self.derivatives,
            "starts": [{"cost": cost, "values": list(values)} for cost, values in self.starts],
            "evaluations": self.evaluations, "failed": self.failed, "seconds": self.seconds, "notes": self.notes,
        }  # fmt: skip

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the parameters for pandas, by name: value, unit, standard error, confidence, bounds, and
        whether the data determine each.
        """
        import pandas

        return pandas.DataFrame([dict(vars_of(one)) for one in self.values]).set_index("name")

    def write_csv(self, path: str | Path) -> None:
        """The curves: place (of a spectrum frequency or order), and of each measured and model's values.
        Raises OSError.
        """
        rows: list[Any] = []
        for one in self.curves[:1]:
            place = f"{one.over} [{UNITS[one.over]}]"
            rows.append(
                [
                    place,
                    *(
                        f"{c.channel} {what} [{c.unit}]"
                        for c in self.curves
                        for what in ("measured", "model")
                    ),
                ]
            )
            rows += zip(
                one.places.tolist(),
                *(v.tolist() for c in self.curves for v in (c.measured, c.model)),
                strict=True,
            )
        write_rows(path, rows)

    def write_json(self, path: str | Path) -> None:
        """What :meth:`json` has. Raises OSError."""
        write_text(Path(path), json.dumps(self.json(), indent=1, default=float) + "\n")

    if TYPE_CHECKING:  # attached by vfife.methods

        def plot(self) -> Figure: ...
        def _repr_html_(self) -> str: ...


def vars_of(one: Value) -> Mapping[str, Any]:
    """A parameter as JSON has it."""
    return {
        "name": one.name, "paths": list(one.paths), "unit": one.unit, "value": one.value, "standard_error": one.error, "low": one.low,
        "high": one.high, "bounds": list(one.bounds), "former": one.former, "known": one.known, "told": one.told, "at_bound": one.at_bound,
    }  # fmt: skip


Evaluation = tuple[
    str, dict[str, Any], Array | None
]  # key of what was evaluated, what is known of it, numbers
CURVES = ("places", "measured", "model")


class FitFile(Store):
    """A fit file. Points are known by the hash of what was evaluated, so a fit that goes on, one with further
    points and one that was not interrupted are the same.
    """

    schema: ClassVar[Schema] = FIT

    def add_points(self, points: Sequence[Evaluation]) -> None:
        """Write points that were evaluated at once, all or none of them."""
        with self.transaction():
            for point in points:
                self.insert("looks", *point)

    def point(self, key: str) -> tuple[dict[str, Any], Array | None] | None:
        """A point that was evaluated; None for one that is missing or damaged."""
        row = self.row("looks", key)
        return None if row is None else (row["told"], row["data"])

    def conclude(self, found: Fit, method: Mapping[str, Any]) -> None:
        """Write what was found and by which method, in the place of what was found before."""
        numbers = np.stack([getattr(one, part) for one in found.curves for part in CURVES], axis=1)
        self.write_row("found", "fit", {"how": method, "fit": plain(found)}, numbers)

    def fit(self, method: Mapping[str, Any] | None = None) -> Fit | None:
        """What was found, if by this method; None where it was not, or that is damaged."""
        row = self.row("found", "fit")
        said = {} if row is None else row["told"]
        if row is None or (method is not None and said["how"] != json.loads(json.dumps(method))):
            return None
        return whole(said["fit"], row["data"])


def plain(found: Fit) -> dict[str, Any]:
    """A fit as JSON has it, but the numbers of its curves."""
    said: dict[str, Any] = {one.name: getattr(found, one.name) for one in dataclasses.fields(found)}
    names = [one.name for one in dataclasses.fields(Laid) if one.name not in CURVES]
    return said | {
        "values": [dataclasses.asdict(one) for one in found.values],
        "correlation": found.correlation.tolist(),
        "directions": [[size, way.tolist()] for size, way in found.directions],
        "curves": [{name: getattr(one, name) for name in names} for one in found.curves],
    }


def whole(said: Mapping[str, Any], numbers: Array) -> Fit:
    """A fit from its parts; ``numbers`` has the columns of ``CURVES`` for each curve."""
    columns = iter(numbers.T)
    parts: dict[str, Any] = {
        "values": [
            Value(**{**one, "paths": tuple(one["paths"]), "bounds": tuple(one["bounds"])})
            for one in said["values"]
        ],
        "curves": [Laid(**one, **{part: next(columns) for part in CURVES}) for one in said["curves"]],
        "correlation": np.array(said["correlation"]),
        "directions": [(size, np.array(way)) for size, way in said["directions"]],
        "starts": [(cost, tuple(place)) for cost, place in said["starts"]],
    }
    return Fit(**{**said, **parts})


def load_fit(path: str | Path) -> Fit:
    """The fit in a fit file. Raises RunFileError for any other file, and for a fit that was interrupted
    before its end.
    """
    with FitFile.open(path) as file:
        found = file.fit()
        if found is None:
            kept = f"{len(file.keys('looks')):,} points are kept in it"
            if file.damage:
                raise RunFileError(file.damaged("; ".join(file.damage)))
            raise RunFileError(
                f"{file.path}: this fit has not come to its end, and {kept}; give the command that began it"
                " again"
            )
    warn_of_damage(
        Path(path), "fit", file.damage, "Give the command that made it again: it computes what is gone."
    )
    return found
