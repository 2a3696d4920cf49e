"""Measured records of a fit, one or several: each with its own offset, start and numbers, and its faults."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from ..errors import Fault, ModelError, kind_of, shown
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..modelfile.parameter import Parameter, with_values
from ..schema import Choice, Integer, Measure, Names, Text, Value, described, described_fields, value_of
from ..schema.values import is_list
from ..solvers.arguments import LARGEST_COUNT, Arguments
from ..studies.spec.plan import Amount
from .curves import units_of
from .descents import MOST_RESTARTS, Derivatives
from .measurements import FRAME, Measured, columns_of, measured
from .parameters import FitParameter, Parameters
from .residuals import Comparison, Misfit
from .run_length import Offset, RunLength, envelope_width, models_of, offset_of, run_length_of, step_of
from .starts import starts_of

if TYPE_CHECKING:
    import pandas

Start = Literal["model", "data"]


@dataclass(frozen=True)
class Record:
    """A measured record of several that a fit compares at once, and what it has of its own.

    ``data``: a CSV file, a data frame with the same columns, or curves. ``offset``: where its first sample
    lies, as :func:`fit` takes it.
    ``start``: "data" looks for angle and speed of each body whose angle was measured near its first samples,
    "model" begins as the model does. ``own``: bounds by path of numbers of which it has its own values.
    ``set``: numbers by path that are known of it. ``name``: of the record in results and
    messages. What is None is as the fit has it for all records.
    """

    data: str | Path | Measured | pandas.DataFrame
    offset: Any = None
    start: Start | None = None
    own: Mapping[str, Any] | Sequence[str] | None = None
    set: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""


Data = Any  # a file, a pandas.DataFrame, Measured or Record


@dataclass(frozen=True)
class Bounds(Value):
    """Two bounds: a text as in "0.1..1 mm", or a list of two."""

    def take(self, value: Any, written: bool) -> Any:
        """Return the bounds unread; the path that they are of decides on their dimension."""
        if isinstance(value, str) or (is_list(value) and len(value) == 2):
            return value
        remedy = 'write them as in "0.1..1 mm" or ["0.1 mm", "1 mm"]'
        raise Fault("", f"this is {kind_of(value)}", shown(value), "two bounds", remedy)

    def json(self) -> dict[str, Any]:
        """Return the JSON Schema of bounds: a text, or a list of two."""
        return {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 2, "maxItems": 2}]}


BOUNDS = Names(Bounds())
COUNT = Integer(1, LARGEST_COUNT)
START = Choice(get_args(Start)), "data: angles and speeds are identified near the first samples"


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """Keywords of :func:`fit` with their defaults. Those with a description are also keys of a fit plan."""

    own: Any = described(BOUNDS, "bounds of numbers of which each record has a value of its own", None)
    columns: Any = described(Names(Text()), "channels by names of columns", None)
    weights: Mapping[str, float] | None = described(
        Names(Measure("1", above=0.0)), "weights by names of columns", None
    )
    start: Start = described(*START, "model")
    offset: Any = described(Amount(), "where first samples lie: free, a number or two bounds", None)
    skip: float = described(
        Measure("1", low=0.0, high=100_000), "turns before data may begin, where the offset is free", 3.0
    )
    compare: Comparison = described(Choice(get_args(Comparison)), "what of the curves is compared", "curve")
    width: Any = described(Amount(), "window of an envelope", None)
    step: Any = described(Measure("s", above=0.0, words=("auto",)), "time step of every run", "auto")
    every: int = described(COUNT, "one out of this number of samples of each record is compared", 1)
    screened: int = described(COUNT, "points that are tried first", 64)
    starts: int = described(COUNT, "the best of them, from which searches begin", 4)
    restarts: int = described(Integer(0, 1000), "times that searches begin again", MOST_RESTARTS)
    derivatives: Derivatives = described(Choice(get_args(Derivatives)), "where derivatives come from", "auto")
    seed: int = described(Integer(0, 2**63 - 1), "seed of the points", 0)
    confidence: float = 0.95
    workers: int | None = None

    def check(self, arguments: Arguments) -> None:
        """Add the faults of the settings to ``arguments``. Raises ModelError with all faults."""
        for setting in described_fields(FitSettings):
            value = value_of(setting)
            if isinstance(value, Choice | Integer) or setting.name == "skip":
                value.read(getattr(self, setting.name), (setting.name,), arguments)
        arguments.count("workers", self.workers)
        if not 0.0 < self.confidence < 1.0:
            limit, remedy = "above 0 and below 1", "write 0.95 for 95 per cent"
            arguments.fault("confidence", "this is no share", self.confidence, limit, remedy)
        arguments.check()


@dataclass(frozen=True)
class RecordTask:
    """A checked record: the mechanism with its numbers, its data, the places of its parameters
    among all, and how runs are compared with it.
    """

    name: str
    mechanism: Mechanism
    data: Measured
    indices: tuple[int, ...]
    parameters: tuple[FitParameter, ...]
    misfit: Misfit
    length: RunLength

    @property
    def question(self) -> dict[str, Any]:
        """What decides how well every point fits it."""
        data, offset, length = self.data, self.misfit.offset, self.length
        numbers = hashlib.sha256(data.places.tobytes())
        for curve in data.curves:
            numbers.update(
                repr((curve.channel, curve.head, curve.proportional, curve.weight)).encode()
                + curve.values.tobytes()
            )
        record_parameters = [
            [parameter.name, list(parameter.paths), parameter.low, parameter.high]
            for parameter in self.parameters
            if parameter.record
        ]
        return {
            "data": data.name, "numbers": numbers.hexdigest(), "over": data.over,
            "offset": [offset.low, offset.high, offset.free], "skip": self.misfit.skip,
            "compare": self.misfit.comparison, "window": self.misfit.window,
            "step": length.step, "outputs": length.outputs, "every": length.steps_per_output,
            "duration": length.duration,
            **({"own": record_parameters, "model": dump(self.mechanism)} if record_parameters else {}),
        }  # fmt: skip


@dataclass
class RecordReader:
    """Reads the records and parameters of a fit; reports the faults of all of them at once."""

    mechanism: Mechanism
    settings: FitSettings
    errors: list[ModelError] = field(default_factory=list)

    def read(
        self, data: Data | Sequence[Data], parameters: Mapping[Any, Any] | Sequence[str]
    ) -> tuple[list[RecordTask], list[FitParameter]]:
        """Read the records and the parameters of all, those in common first. Raises ModelError."""
        entries: Sequence[Any] = data if isinstance(data, list | tuple) else [data]
        records = [entry if isinstance(entry, Record) else Record(entry) for entry in entries]
        if not records:
            message, remedy = "there is no record", "name a file of measured curves"
            raise ModelError([Fault("data", message, remedy=remedy)], "fit")
        names = names_of(records)
        mechanisms = [self.attempt(names[k], self.numbered, record) for k, record in enumerate(records)]
        curves = [self.attempt(names[k], self.curves, record) for k, record in enumerate(records)]
        faults: list[Fault] = []
        reader = Parameters(self.mechanism, faults)
        common = reader.read(parameters)
        own_parameters = [
            self.own_parameters(reader, record, data, name)
            for record, data, name in zip(records, curves, names, strict=True)
        ]
        if not (faults or common or any(own_parameters)):
            remedy = 'name one with its bounds, as in "joint.C.clearance=0.1..1 mm"'
            faults.append(Fault("parameters", "there is no parameter to identify", remedy=remedy))
        self.errors += [ModelError(faults, "fit")] if faults else []
        self.check()
        all_parameters = [*common, *(parameter for group in own_parameters for parameter in group)]
        tasks = self.tasks(names, records, mechanisms, curves, all_parameters)
        return tasks, all_parameters

    def attempt(self, name: str, function: Any, *arguments: Any) -> Any:
        """Call a function that reads a record; return None and collect the faults where it fails."""
        try:
            return function(*arguments)
        except ModelError as error:
            self.errors.append(error)
        except Fault as fault:
            self.errors.append(ModelError([fault], name))
        return None

    def check(self) -> None:
        """Raise the faults that were found, those of several records with their names."""
        if len(self.errors) == 1:
            raise self.errors[0]
        if self.errors:
            faults = [
                fault if error.file == "fit" else fault.at(f"{error.file}, {fault.where}")
                for error in self.errors
                for fault in error.faults
            ]
            raise ModelError(faults, "fit")

    def numbered(self, record: Record) -> Mechanism:
        """Return the mechanism with the values that are known for a record."""
        faults = list[Fault]()
        for path in record.set:
            try:
                Parameter(self.mechanism, path)
            except Fault as fault:
                faults.append(fault.at(f"set {path}"))
        if faults:
            raise ModelError(faults, str(record.name or record.data))
        return with_values(self.mechanism, record.set) if record.set else self.mechanism

    def curves(self, record: Record) -> Measured:
        """Return the curves of a record."""
        data, settings = record.data, self.settings
        if isinstance(data, Measured):
            return data
        return measured(data, units_of(self.mechanism), columns_of(settings.columns), settings.weights)

    def own_parameters(
        self, reader: Parameters, record: Record, data: Measured | None, name: str
    ) -> list[FitParameter]:
        """Parameters of which a record has a value of its own; without data none of its start."""
        own_bounds = self.settings.own if record.own is None else record.own
        parameters = reader.read(own_bounds, name) if own_bounds else []
        if data is not None and self.start(record) == "data":
            bounds = starts_of(data)
            if not bounds:
                message = (
                    "no column is the angle of a body over time, so the start cannot be seen in the data"
                )
                remedy = "measure the angle, or give bounds of the start, as in start.rod.angle=1..2"
                reader.faults.append(Fault(f"{name}, start", message, remedy=remedy))
            parameters += reader.read(bounds, name)
        return parameters

    def start(self, record: Record) -> Start:
        """Where a record begins."""
        return self.settings.start if record.start is None else record.start

    def tasks(
        self, names: Sequence[str], records: Sequence[Record], mechanisms: Sequence[Mechanism],
        curves: Sequence[Measured], parameters: Sequence[FitParameter],
    ) -> list[RecordTask]:  # fmt: skip
        """Return the records with their residuals and the length of their runs."""
        settings, tasks = self.settings, list[RecordTask]()
        indices = [
            tuple(k for k, parameter in enumerate(parameters) if parameter.record in ("", name))
            for name in names
        ]
        models: dict[str, list[Mechanism]] = {}
        texts = [dump(mechanism) for mechanism in mechanisms]
        for text, mechanism, places in zip(texts, mechanisms, indices, strict=True):
            if text not in models:  # numbers of their own differ little in what they do to a step
                models[text] = models_of(mechanism, text, [parameters[k] for k in places])
        parts = zip(names, records, curves, mechanisms, strict=True)
        offsets = [self.attempt(name, self.offset, *part) for name, *part in parts]
        self.check()
        step = step_of(settings.step, [model for group in models.values() for model in group])
        for k, name in enumerate(names):
            data, offset = curves[k].subsample(settings.every), offsets[k]
            length = run_length_of(models[texts[k]], data, offset, settings.skip, step)
            width = envelope_width(settings.width, data)
            misfit = Misfit(data, offset, settings.skip, settings.compare, width)
            record_parameters = tuple(parameters[at] for at in indices[k])
            tasks.append(RecordTask(name, mechanisms[k], data, indices[k], record_parameters, misfit, length))
        return tasks

    def offset(self, record: Record, data: Measured, mechanism: Mechanism) -> Offset:
        """Return where the first sample of a record may lie: at the start of the run if the start is
        identified."""
        value = self.settings.offset if record.offset is None else record.offset
        if value is None and self.start(record) == "data":
            value = -float(data.places[0])
        return offset_of(value, data, mechanism)


def names_of(records: Sequence[Record]) -> list[str]:
    """Names of records: as given, or those of their files, with a number where several have one name."""
    names = list[str]()
    for record in records:
        data = record.data
        if isinstance(data, str | os.PathLike):
            name = record.name or Path(data).stem
        else:
            name = record.name or (data.name if isinstance(data, Measured) else FRAME)
        count = sum(name == former_name.partition(" (")[0] for former_name in names)
        names.append(f"{name} ({count + 1})" if count else name)
    return names
