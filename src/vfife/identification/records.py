"""Measured records of a fit, one or several: each with its own offset, start and numbers, and its faults."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

from ..errors import Fault, ModelError
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..modelfile.parameter import Parameter, with_values
from .curves import units_of
from .measurements import Measured, columns_of, measured
from .parameters import FitParameter, Parameters
from .residuals import Comparison, Misfit
from .run_length import Offset, RunLength, envelope_width, models_of, offset_of, run_length_of, step_of
from .starts import starts_of

Start = Literal["model", "data"]


@dataclass(frozen=True)
class Record:
    """A measured record of several that a fit compares at once, and what it has of its own.

    ``data``: a CSV file, or curves. ``offset``: where its first sample lies, as :func:`fit` takes it.
    ``start``: "data" looks for angle and speed of each body whose angle was measured near its first samples,
    "model" begins as the model does. ``own``: bounds of numbers by path, its own value of each is looked for.
    ``set``: numbers by path that are known of it. ``name``: of the record in results and
    messages. What is None is as the fit has it for all records.
    """

    data: str | Path | Measured
    offset: Any = None
    start: Start | None = None
    own: Mapping[str, Any] | Sequence[str] | None = None
    set: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""


Data = str | Path | Measured | Record


class RecordSettings(Protocol):
    """Settings of a fit that its records need."""

    @property
    def columns(self) -> Any:
        """Return the column names of the data by series, or None."""

    @property
    def weights(self) -> Mapping[str, float] | None:
        """Return the weights of the curves by series; None for equal weights."""

    @property
    def offset(self) -> Any:
        """Return the offset of the first sample, its bounds, or "free"."""

    @property
    def skip(self) -> float:
        """Return the number of turns before the data may begin, with a free offset."""

    @property
    def compare(self) -> Comparison:
        """Return the kind of comparison between simulation and data."""

    @property
    def width(self) -> Any:
        """Return the window of an envelope."""

    @property
    def step(self) -> Any:
        """Return the time step of every run (s), or "auto"."""

    @property
    def start(self) -> Start:
        """Return the origin of the start state: the model or the data."""

    @property
    def own(self) -> Any:
        """Return the bounds of parameters of which each record has its own value, by path."""

    @property
    def every(self) -> int:
        """Return the number of samples of which one is compared."""


@dataclass(frozen=True)
class RecordTask:
    """A record that is understood: the mechanism with its numbers, its data, the places of its parameters
    among all, and how runs are compared with it.
    """

    name: str
    mechanism: Mechanism
    data: Measured
    which: tuple[int, ...]
    parameters: tuple[FitParameter, ...]
    misfit: Misfit
    length: RunLength

    @property
    def question(self) -> dict[str, Any]:
        """What decides how well every point fits it."""
        data, offset, length = self.data, self.misfit.offset, self.length
        numbers = hashlib.sha256(data.places.tobytes())
        for one in data.curves:
            numbers.update(
                repr((one.channel, one.head, one.proportional, one.weight)).encode() + one.values.tobytes()
            )
        own = [[one.name, list(one.paths), one.low, one.high] for one in self.parameters if one.record]
        return {
            "data": data.name, "numbers": numbers.hexdigest(), "over": data.over,
            "offset": [offset.low, offset.high, offset.free], "skip": self.misfit.skip,
            "compare": self.misfit.how, "window": self.misfit.window,
            "step": length.step, "outputs": length.outputs, "every": length.every,
            "duration": length.duration,
            **({"own": own, "model": dump(self.mechanism)} if own else {}),
        }  # fmt: skip


@dataclass
class RecordReader:
    """Reads the records and parameters of a fit; reports the faults of all of them at once."""

    mechanism: Mechanism
    settings: RecordSettings
    errors: list[ModelError] = field(default_factory=list)

    def read(
        self, data: Data | Sequence[Data], parameters: Mapping[Any, Any] | Sequence[str]
    ) -> tuple[list[RecordTask], list[FitParameter]]:
        """Read the records and the parameters of all, those in common first. Raises ModelError."""
        several: Sequence[Any] = data if isinstance(data, list | tuple) else [data]
        records = [one if isinstance(one, Record) else Record(one) for one in several]
        if not records:
            what, remedy = "there is no record", "name a file of measured curves"
            raise ModelError([Fault("data", what, remedy=remedy)], "fit")
        names = names_of(records)
        mechanisms = [self.attempt(names[k], self.numbered, one) for k, one in enumerate(records)]
        curves = [self.attempt(names[k], self.curves, one) for k, one in enumerate(records)]
        faults: list[Fault] = []
        reader = Parameters(self.mechanism, faults)
        common = reader.read(parameters)
        own = [
            self.own_parameters(reader, record, data, name)
            for record, data, name in zip(records, curves, names, strict=True)
        ]
        if not (faults or common or any(own)):
            remedy = 'name one with its bounds, as in "joint.C.clearance=0.1..1 mm"'
            faults.append(Fault("parameters", "there is no parameter to identify", remedy=remedy))
        self.errors += [ModelError(faults, "fit")] if faults else []
        self.check()
        every = [*common, *(one for some in own for one in some)]
        tasks = self.tasks(names, records, mechanisms, curves, every)
        return tasks, every

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
        own = self.settings.own if record.own is None else record.own
        parameters = reader.read(own, name) if own else []
        if data is not None and self.start(record) == "data":
            bounds = starts_of(data)
            if not bounds:
                what = "no column is the angle of a body over time, so the start cannot be seen in the data"
                remedy = "measure the angle, or give bounds of the start, as in start.rod.angle=1..2"
                reader.faults.append(Fault(f"{name}, start", what, remedy=remedy))
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
        which = [tuple(k for k, one in enumerate(parameters) if one.record in ("", name)) for name in names]
        models: dict[str, list[Mechanism]] = {}
        texts = [dump(one) for one in mechanisms]
        for text, mechanism, places in zip(texts, mechanisms, which, strict=True):
            if text not in models:  # numbers of their own differ little in what they do to a step
                models[text] = models_of(mechanism, text, [parameters[k] for k in places])
        parts = zip(names, records, curves, mechanisms, strict=True)
        offsets = [self.attempt(name, self.offset, *part) for name, *part in parts]
        self.check()
        step = step_of(settings.step, [one for some in models.values() for one in some])
        for k, name in enumerate(names):
            data, offset = curves[k].subsample(settings.every), offsets[k]
            length = run_length_of(models[texts[k]], data, offset, settings.skip, step)
            width = envelope_width(settings.width, data)
            misfit = Misfit(data, offset, settings.skip, settings.compare, width)
            own = tuple(parameters[at] for at in which[k])
            tasks.append(RecordTask(name, mechanisms[k], data, which[k], own, misfit, length))
        return tasks

    def offset(self, record: Record, data: Measured, mechanism: Mechanism) -> Offset:
        """Where the first sample of a record may lie: at the start of the run where that is looked for."""
        value = self.settings.offset if record.offset is None else record.offset
        if value is None and self.start(record) == "data":
            value = -float(data.places[0])
        return offset_of(value, data, mechanism)


def names_of(records: Sequence[Record]) -> list[str]:
    """Names of records: as given, or those of their files, with a number where several have one name."""
    names = list[str]()
    for one in records:
        name = one.name or (one.data.name if isinstance(one.data, Measured) else Path(one.data).stem)
        count = sum(name == other.partition(" (")[0] for other in names)
        names.append(f"{name} ({count + 1})" if count else name)
    return names
