"""Result of a parameter identification: values with confidence, their correlation, curves; its file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError, former_names
from ..files import DataTable, with_completeness, write_text
from ..numerics.outward import significant_range
from ..numerics.scalar import log
from ..options import with_faults
from ..store.connections import warn_of_damage
from ..store.schemas import FIT, Schema
from ..store.store import Store
from .export import TableColumn, table_rows

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
# A parameter is determined by the data if its confidence interval reaches at most this share of the way
# between its bounds to either side.
DETERMINED_SHARE = 0.25
NOT_DETERMINED = "not determined by these data"
# Two parameters are split poorly from this correlation on, if the interval of one reaches further than this
# share of its value.
SPLIT, SPLIT_WIDTH = 0.8, 0.2
NAMED_COMPONENT = 0.3  # component of a direction from which its parameter is named
UNITS = {"time": "s", "angle": "rad", "penetration": "m", "frequency": "Hz", "order": "1"}  # of abscissae
# Two searches came to one point if their values differ by at most this share of the way between the bounds.
SAME_POINT = 0.01
AT_BOUND = 0.01  # share of the way between the bounds within which a value lies on a bound


@former_names(told="determined")
@dataclass(frozen=True)
class FitValue:
    """An identified parameter: its ``paths``, ``value`` in ``unit`` (SI), standard ``error``, confidence
    ``low`` to ``high``, bounds.

    ``signs``: -1 for a path whose number has the opposite value; empty where all have the value.
    ``former``: its value in the model, None where that was not one number within the bounds. ``known``: False
    if curves at the best point depend on the steps or are of one turn that does not repeat, or if searches
    ended at other values: ``error``, ``low``, ``high`` are NaN, ``ends`` those of all that fit as well.
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
    signs: tuple[float, ...] = ()
    ends: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Leave no limits of an unknown confidence."""
        if not self.known:
            ends, nan = self.ends or (self.low, self.high), math.nan
            tried = np.clip(ends, *self.bounds).tolist() if all(map(math.isfinite, ends)) else []
            vars(self).update(ends=tuple(tried), error=nan, low=nan, high=nan)

    @property
    def numbers(self) -> list[tuple[str, float]]:
        """Paths and the values of their numbers; one whose sign is -1 has the opposite value."""
        signs = self.signs or (1.0,) * len(self.paths)
        return [(path, sign * self.value) for path, sign in zip(self.paths, signs, strict=True)]

    def share(self, value: float) -> float:
        """Return the place of a value between the bounds, 0 to 1; logarithmic if the search was."""
        low, high = self.bounds
        if self.logarithmic:
            return log(max(value, 1e-3 * low) / low) / log(high / low)
        return (value - low) / (high - low)

    def words(self, confidence: float) -> str:
        """Return name, value and limits in words, with the digits that the limits leave."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        sure = "error not estimated" if self.known else "confidence not known"
        if self.ends:
            sure += f"; fits nearly as well from {significant_range(self.ends[0], self.ends[1], 5)}"
        if math.isfinite(self.error):
            sure = f"{100.0 * confidence:g} %: {significant_range(self.low, self.high, 5)}"
        sure = NOT_DETERMINED if self.exceeds_bounds else sure
        return f"{self.name} = {self.value:.5g}{unit} ({sure})"

    @property
    def determined(self) -> bool:
        """Whether the data determine it: its confidence is known, and narrow compared with the bounds."""
        return self.known and self.share(self.high) - self.share(self.value) <= DETERMINED_SHARE

    @property
    def exceeds_bounds(self) -> bool:
        """Whether its confidence interval includes both bounds, so that the data say nothing of it."""
        return self.low <= self.bounds[0] and self.high >= self.bounds[1]

    @property
    def width(self) -> float:
        """Half of its confidence interval over its value (1); infinite of what may be zero."""
        half = 0.5 * float(np.ptp(self.ends or (self.low, self.high)))
        return half / abs(self.value) if self.value else float("inf")

    @property
    def at_bound(self) -> bool:
        """Whether it lies on a bound."""
        return min(self.share(self.value), 1.0 - self.share(self.value)) <= AT_BOUND

    def json(self) -> dict[str, Any]:
        """Return the value as JSON data."""
        return {
            "name": self.name, "paths": list(self.paths), "unit": self.unit, "value": self.value,
            "standard_error": self.error, "low": self.low, "high": self.high, "bounds": list(self.bounds),
            "former": self.former, "known": self.known, "told": self.determined, "at_bound": self.at_bound,
            **({"ends": list(self.ends)} if self.ends else {}),
        }  # fmt: skip


@dataclass(frozen=True)
class FitCurve:
    """A measured curve and the model's at ``places`` (s, rad, m; of spectra Hz, or orders: cycles a turn),
    both in ``unit``.

    ``over`` names the abscissa: "time", "angle", "penetration", "frequency", "order". ``factor`` and
    ``level`` of a channel that is only proportional to the measurement. ``record``: name of one of several.
    """

    channel: str
    head: str
    unit: str
    over: str
    places: Array = field(repr=False)
    measured: Array = field(repr=False)
    model: Array = field(repr=False)
    factor: float = 1.0
    level: float = 0.0
    record: str = ""

    @property
    def share(self) -> float:
        """Root mean square of the residual over the standard deviation of the measurement (1)."""
        spread = float(self.measured.std())
        left = self.model - self.measured
        return float(np.sqrt((left * left).mean())) / spread if spread > 0.0 else float("inf")


@dataclass(frozen=True)
class FitRecordValues:
    """What one record of several has of its own: its ``offset`` (s or rad), the ``residual`` over the
    deviation of its curves (1), and ``values`` of its start and other numbers.
    """

    name: str
    offset: float
    offset_error: float
    residual: float
    values: list[FitValue]

    @property
    def set(self) -> list[tuple[str, float]]:
        """Paths and values of its own numbers."""
        return [pair for value in self.values for pair in value.numbers]

    def json(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {**vars(self), "values": [value.json() for value in self.values]}


@dataclass
class Fit(DataTable):
    """Identified ``values`` and their ``correlation``; the ``offset`` (s or rad) of the first sample with its
    error; ``curves``.

    ``directions`` are combinations of parameters in units of their ranges, the least determined first, with
    the standard deviation of each. ``starts``: cost and values of each local search. ``derivatives`` names
    how they were computed. ``autocorrelation`` of the residuals from one sample to the next widens the
    errors. ``status``: "complete", or "interrupted" with the best point so far, without errors. ``records``:
    what each of several has of its own; offset and its error are those of the first.
    """

    mechanism: str
    data: str
    status: str
    values: list[FitValue]
    correlation: Array
    directions: list[tuple[float, Array]]
    offset: float
    offset_error: float
    over: str
    curves: list[FitCurve]
    starts: list[tuple[float, tuple[float, ...]]]
    evaluations: int
    failed: int
    derivatives: str
    autocorrelation: float
    confidence: float
    seconds: float
    compared: str = "curve"
    notes: list[str] = field(default_factory=list)
    records: list[FitRecordValues] = field(default_factory=list)

    @property
    def progress(self) -> str:
        """How much is computed of an interrupted fit; empty for a complete one."""
        return f"{self.evaluations:,} runs of the search" if self.status == "interrupted" else ""

    def __repr__(self) -> str:
        values = ", ".join(value.words(self.confidence) for value in self.values)
        doubts = len(self.undetermined) + len(self.splits) + len(self.notes)
        notes = f"; {doubts} note{'s' * (doubts > 1)}: print it" if doubts else ""
        part = "interrupted, " if self.progress else ""
        return (
            f"<Fit of {self.mechanism!r} to {self.data!r}: {part}{values}{notes}; see .to_dataframe(),"
            " .undetermined, .plot()>"
        )

    def __getitem__(self, name: str) -> FitValue:
        """Return a parameter by its name or one of its paths. Raises KeyError."""
        for value in self.values:
            if name == value.name or name in value.paths:
                return value
        raise KeyError(
            f"{name!r} was not identified; these were: {', '.join(value.name for value in self.values)}"
        )

    @property
    def set(self) -> list[tuple[str, float]]:
        """Paths and values, as ``load_model(path, set=...)`` accepts them."""
        return [pair for value in self.values for pair in value.numbers]

    @property
    def share(self) -> float:
        """Root mean square of all residuals over the deviations of the measured curves."""
        return float(np.sqrt(np.mean([curve.share * curve.share for curve in self.curves])))

    @property
    def undetermined(self) -> list[str]:
        """Sentences on parameters and combinations that the data do not determine."""
        sentences = []
        for deviation, direction in self.directions:
            if not deviation > DETERMINED_SHARE:
                continue
            ranking = np.argsort(-np.abs(direction), kind="stable")
            order = [k for k in ranking if abs(direction[k]) >= NAMED_COMPONENT]
            *leading, last = (self.values[k].name for k in order)
            if not leading:
                sentences.append(
                    f"{last}: within its bounds it changes the curves by less than their residual"
                )
                continue
            ways = (
                f"{self.values[k].name} {'up' if direction[k] * direction[order[0]] > 0.0 else 'down'}"
                for k in order
            )
            change = f"{' with '.join(ways)} changes the curves by less than their residual"
            sentences.append(f"{', '.join(leading)} and {last} one by one: {change}")
        return sentences

    @property
    def splits(self) -> list[str]:
        """Sentences on pairs of parameters of which the data know the sum of their effects much better than
        the share of each, as of viscous and dry friction in a swing that dies away.
        """
        sentences = []
        for k, value in enumerate(self.values):
            for j in range(k):
                partner, correlation = self.values[j], float(self.correlation[k, j])
                # A fit that was interrupted may have no correlation (NaN), and then says nothing.
                if not abs(correlation) >= SPLIT or max(value.width, partner.width) < SPLIT_WIDTH:
                    continue
                better = 1.0 / np.sqrt(max(1.0 - correlation * correlation, 1e-12))
                sentences.append(
                    f"the split between {partner.name} and {value.name} is poorly determined (correlation"
                    f" {correlation:+.2f}): if one of them were known, the other would be known {better:.2g}"
                    " times as well"
                )
        return sentences

    @property
    def remarks(self) -> list[str]:
        """Sentences on how the point was found."""
        sentences = []
        if self.offset_error > 0.0 or self.offset != 0.0:
            factor, unit = (1e3, "ms") if self.over == "time" else (57.29577951308232, "deg")
            known = math.isfinite(self.offset_error)
            error = f" ± {factor * self.offset_error:.2g}" if known else ""
            sentences.append(
                f"The first sample of the data was taken {factor * self.offset:.5g}{error} {unit} after the"
                f" start of a turn, or after its time in the file{'' if known else '; confidence not known'}."
            )
        near = sum(cost <= 1.1 * self.starts[0][0] and self._is_here(end) for cost, end in self.starts)
        if self.starts and self.evaluations:
            sentences.append(
                f"{near} of {len(self.starts)} searches reached this point, by {self.derivatives};"
                f" {self.evaluations} runs."
            )
        if self.autocorrelation > 0.1:
            sentences.append(
                f"The residuals are autocorrelated (correlation {self.autocorrelation:.2f}), so they contain"
                " more than noise; the errors are widened."
            )
        if bound := [value.name for value in self.values if value.at_bound]:
            sentences.append(f"At a bound, so perhaps beyond it: {', '.join(bound)}.")
        return sentences

    def _is_here(self, values: Sequence[float]) -> bool:
        """Return whether a search ended at the values found, as far as all records have them in common."""
        pairs = zip(self.values, values, strict=False)
        return all(abs(value.share(end) - value.share(value.value)) <= SAME_POINT for value, end in pairs)

    def json(self) -> dict[str, Any]:
        """Return all data except the curves, as JSON data."""
        return {
            "model": self.mechanism, "data": self.data, "status": self.status, "compared": self.compared,
            "confidence": self.confidence,
            "parameters": [value.json() for value in self.values], "correlation": self.correlation.tolist(),
            "undetermined": self.undetermined,
            **({"poorly_determined": self.splits} if self.splits else {}),
            "offset": {"value": self.offset, "error": self.offset_error, "unit": UNITS[self.over]},
            "curves": [{"channel": c.channel, "column": c.head, "unit": c.unit, "residual": c.share,
                        "factor": c.factor, "level": c.level}
                       for c in self.curves],
            "residual": self.share, "autocorrelation": self.autocorrelation, "derivatives": self.derivatives,
            "starts": [{"cost": cost, "values": list(values)} for cost, values in self.starts],
            "evaluations": self.evaluations, "failed": self.failed, "seconds": self.seconds,
            "notes": self.notes,
            **({"records": [record.json() for record in self.records]} if self.records else {}),
        }  # fmt: skip

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the parameters for pandas, by name: value, unit, standard error, confidence, bounds, and
        whether the data determine each. Standard errors and limits that are not known are NaN.
        """
        import pandas

        rows = pandas.DataFrame([value.json() for value in self.values])
        return with_completeness(rows.set_index("name"), self.progress)

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield the curves: place (of a spectrum frequency or order), measured and model's values of each;
        those of several records one after the other, with the record's name.
        """
        records = list(dict.fromkeys(curve.record for curve in self.curves))
        channels = list(dict.fromkeys((curve.channel, curve.unit) for curve in self.curves))
        curves_by_record = [[curve for curve in self.curves if curve.record == name] for name in records]
        lengths = [len(curves[0].places) for curves in curves_by_record]
        by_channel = [{(c.channel, c.unit): c for c in reversed(curves)} for curves in curves_by_record]
        columns = []
        if len(records) > 1:
            names = np.repeat(np.array(records, dtype=object), lengths)
            columns.append(TableColumn("record", names))
        places = np.concatenate([curves[0].places for curves in curves_by_record])
        columns.append(TableColumn(f"{self.curves[0].over} [{UNITS[self.curves[0].over]}]", places))
        for channel in channels:
            for source in ("measured", "model"):
                values = [
                    getattr(curves[channel], source) if channel in curves else np.full(length, np.nan)
                    for curves, length in zip(by_channel, lengths, strict=True)
                ]
                head = f"{channel[0]} {source} [{channel[1]}]"
                columns.append(TableColumn(head, np.concatenate(values)))
        return table_rows(columns)

    def write_json(self, path: str | Path) -> None:
        """Write :meth:`json` to a file, numbers that are not known as null. Raises OSError."""
        data = json.loads(json.dumps(self.json(), default=float), parse_constant=lambda _: None)
        write_text(Path(path), json.dumps(data, indent=1, allow_nan=False) + "\n")

    if TYPE_CHECKING:  # attached by vfife.methods

        def plot(self) -> Figure:
            """See :func:`vfife.methods.plot_fit`."""

        def _repr_html_(self) -> str: ...


Evaluation = tuple[str, dict[str, Any], Array | None]  # key of the point, its data, its curves
CURVES = ("places", "measured", "model")
TUPLES = ("paths", "bounds", "signs", "ends")


class FitFile(Store):
    """A fit file. Points are identified by the hash of what was evaluated, so that a continued fit, one with
    more points and an uninterrupted one agree.
    """

    schema: ClassVar[Schema] = FIT

    def add_points(self, points: Sequence[Evaluation], best: Sequence[Any] | None = None) -> None:
        """Write points that were evaluated together, and cost, shares, offsets of a new best, all or none."""
        with self.transaction():
            for point in points:
                self.insert("looks", *point)
            if best is not None:
                self.insert("found", "best", {"point": best}, None)

    def point(self, key: str) -> tuple[dict[str, Any], Array | None] | None:
        """Return an evaluated point; None if it is missing or damaged."""
        row = self.row("looks", key)
        return None if row is None else (row["told"], row["data"])

    def conclude(self, fit: Fit, method: Mapping[str, Any]) -> None:
        """Write a fit and its method, replacing earlier ones."""
        columns = [getattr(curve, column) for curve in fit.curves for column in CURVES]
        alike = len({len(column) for column in columns}) == 1
        numbers = np.stack(columns, axis=1) if alike else np.concatenate(columns)
        self.write_row("found", "fit", {"how": method, "fit": to_json(fit)}, numbers)

    def fit(self, method: Mapping[str, Any] | None = None) -> Fit | None:
        """Return the fit if it was made by this method; None if there is none, or if it is damaged."""
        row = self.row("found", "fit")
        if row is None or (method is not None and row["told"]["how"] != json.loads(json.dumps(method))):
            return None
        return from_json(row["told"]["fit"], row["data"])


def to_json(fit: Fit) -> dict[str, Any]:
    """Return a fit as JSON data, without the numbers of its curves."""
    curves = [
        {name: value for name, value in vars(curve).items() if name not in CURVES} for curve in fit.curves
    ]
    directions = [[size, direction.tolist()] for size, direction in fit.directions]
    records = [{**vars(record), "values": [vars(value) for value in record.values]} for record in fit.records]
    return {
        **vars(fit),
        "values": [vars(value) for value in fit.values],
        "correlation": fit.correlation.tolist(),
        "directions": directions,
        "curves": curves,
        "records": records,
        "samples": [len(curve.places) for curve in fit.curves],
    }


def from_json(data: Mapping[str, Any], numbers: Array) -> Fit:
    """Return the fit of JSON data; ``numbers`` has the columns ``CURVES`` of each curve: one after the other
    or, if all have the same length (files of version 0.2), side by side.
    """
    fields = dict(data)
    samples = fields.pop("samples", None)
    if numbers.ndim == 1:
        ends = np.cumsum(np.repeat(samples, len(CURVES)))[:-1]
        columns = iter(np.split(numbers, ends))
    else:
        columns = iter(numbers.T)
    parts: dict[str, Any] = {
        "values": values_of(data["values"]),
        "curves": [
            FitCurve(**{**curve, **{column: next(columns) for column in CURVES}}) for curve in data["curves"]
        ],
        "correlation": np.array(data["correlation"]),
        "directions": [(size, np.array(direction)) for size, direction in data["directions"]],
        "starts": [(cost, tuple(place)) for cost, place in data["starts"]],
        "records": [
            FitRecordValues(**{**record, "values": values_of(record["values"])})
            for record in data.get("records", ())
        ],
    }
    return Fit(**{**fields, **parts})


def values_of(data: Sequence[Mapping[str, Any]]) -> list[FitValue]:
    """Return the identified parameters from JSON."""
    return [FitValue(**{**entry, **{name: tuple(entry.get(name, ())) for name in TUPLES}}) for entry in data]


@with_faults()
def load_fit(path: str | Path) -> Fit:
    """Return the fit of a fit file.

    path: the fit file

    Raises RunFileError for any other file, and for an unfinished fit.
    """
    with FitFile.open(path) as file:
        fit = file.fit()
        if fit is None:
            points = f"{len(file.keys('looks')):,} points are kept in it"
            if file.damage:
                raise RunFileError(file.damaged("; ".join(file.damage)))
            raise RunFileError(
                f"{file.path}: this fit is not complete, and {points}; repeat the command that started it"
            )
        continues = file.get("meta", FIT.kind, "json") is not None
    remedy = (
        "Repeat the command that made it: it computes the missing points."
        if continues
        else "Its specification is lost, so it cannot be continued: make the fit again in another file."
    )
    warn_of_damage(Path(path), "fit", file.damage, remedy)
    return fit
