"""Data of a run: channels, a dataset with units, measures, the energy ledger, spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..kernels.topology import Topology
from ..measures import Ledger, Measures, last_turn, ledger, ranged
from ..measures.contacts import Around, Impacts, around, impacts
from ..measures.elastic import element_places
from ..measures.error_ranges import evaluated_turns
from ..measures.motion import PointMotion, crank_rotation, point_motion, times, within_turn
from ..measures.repetition import Turns, part_of
from ..modelfile import dump
from ..results.provenance import sources, versions
from ..solvers.record import Record, recorded_rows
from ..solvers.repeating import LONGEST, outputs_of_a_turn
from .channels import Channel, channels, entities
from .export import data_frame, titled
from .series import REDUCED, REDUCTION, Series, SeriesReader, columns, dataset_of, joined
from .spectra import Envelope, Spectrogram, Spectrum, envelope, sampled, spectrogram, spectrum

if TYPE_CHECKING:
    import pandas
    import xarray

LONGEST_ATTRIBUTE = 60000  # bytes; HDF5 takes no attribute beyond 64 KiB


class RunData:
    """Data of a run, each built when it is first used; only ``data`` loads xarray.

    ``record`` holds the rows, ``reference`` is the view of the ideal mechanism or None. All series come from
    :attr:`channels`:
    :attr:`series` finds one by the name of its measure, ``data`` and ``turns`` are datasets of them,
    :meth:`joint`, :meth:`body`,
    :meth:`spring` and :meth:`to_dataframe` selections.
    """

    def __init__(self, record: Record, reference: RunData | None = None) -> None:
        self.record, self.reference = record, reference
        self.arguments: dict[str, Any] = {}

    def __repr__(self) -> str:
        choice, done = self.record.assembly.choice, int(self.record.steps[-1])
        length = f"{done * choice.step:.4g} s"
        if self.record.static:
            length = f"{done} load factors up to {self.time[-1]:.4g}"
            return (
                f"<Result of {self.name!r}: static, {self.record.status}, {length}; see .data, .measures,"
                " .summary, .plot()>"
            )
        if choice.turn is not None:
            length = f"{done * choice.step / choice.turn:.4g} turns"
        return (
            f"<Result of {self.name!r}: {self.record.status}, {length}, {done} steps of {choice.step:.4g} s, "
            f"{len(self.record.steps)} outputs; see .data, .measures, .summary, .plot()>"
        )

    # ------------------------------------------------------------------------------------------------ numbers

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self.record.assembly.mechanism.name

    @property
    def step(self) -> float | None:
        """Time step (s); None for a static analysis."""
        return None if self.record.static else self.record.assembly.choice.step

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the outputs (s), or load factors of a static analysis, shape (outputs,)."""
        return times(self.record)

    @property
    def crank(self) -> str | None:
        """Name of the driven body, the first of several."""
        return next((body.name for body in self.record.assembly.bodies.values() if body.driven == 0), None)

    @property
    def crank_angle(self) -> NDArray[np.float64] | None:
        """Angle of the crank (degrees, 0 to 360), shape (outputs,); None without a crank."""
        return None if self.crank_rotation is None else within_turn(self.crank_rotation)

    @property
    def crank_rotation(self) -> NDArray[np.float64] | None:
        """The same (degrees) as it goes on from turn to turn, for interpolation and counting."""
        return crank_rotation(self.record)

    @property
    def last_turn(self) -> NDArray[np.bool_]:
        """Outputs of the last full crank turn, shape (outputs,); all outputs without a crank."""
        return last_turn(self.record)

    @cached_property
    def ledger(self) -> Ledger:
        """The energy ledger."""
        return ledger(self.record)

    @cached_property
    def measures(self) -> Measures:
        """Measures by name; see :mod:`vfife.measures.catalogue`.

        Each is a number with its uncertainty, ``low`` to ``high``, and its scatter over turns, ``lowest`` to
        ``highest`` (:class:`~vfife.measures.values.Measured`). :attr:`motion` names the turns that they are
        of.
        """
        return ranged(self.record, None if self.reference is None else self.reference.measures)

    # --------------------------------------------------------------------------------------------------- data

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """Series by name, as arrays with unit and meaning."""
        return channels(self.record, self.ledger)

    def point(self, name: str) -> PointMotion:
        """Return the position, velocity and acceleration of a pin in global axes, or
        ``.along(direction)``.

        name: the pin, ``body.pin``

        Raises ValueError, which lists the pins.
        """
        return point_motion(self.record, name)

    @cached_property
    def impacts(self) -> Impacts:
        """Contacts that began, one by one as far as outputs separate them; see
        :func:`vfife.measures.contacts.impacts`.
        """
        return impacts(self.record)

    def around(self, side: str = "bearing", bins: int = 72, last_turn: bool = False) -> Around:
        """Return the time in contact, impulse and friction over the angle of each bearing or
        journal.

        side: "bearing" or "journal", whose surface the angle runs around
        bins: number of equal parts of the circumference
        last_turn: True for the last turn only, False for all of the run

        See :func:`vfife.measures.contacts.around`.
        """
        return around(self.record, side, bins, self.last_turn if last_turn else None)

    @cached_property
    def data(self) -> xarray.Dataset:
        """Dataset of all channels over time and the names of joints, bodies, elements and particles, with
        units.
        """
        import xarray

        time = (
            {"units": "1", "long_name": "load factor"}
            if self.record.static
            else {"units": "s", "long_name": "time"}
        )
        coords: dict[str, Any] = {"time": ("time", self.time, time)}
        coords |= {entity: (entity, np.array(names)) for entity, names in entities(self.record).items()}
        if self.crank_angle is not None:
            angle = {"units": "deg", "long_name": f"angle of {self.crank}"}
            coords["crank_angle"] = ("time", self.crank_angle, angle)
        if "element" in coords:
            place = {
                "units": "m",
                "long_name": (
                    "middle of the element along its link from the start, or along its member of a frame"
                ),
            }
            coords["element_position"] = ("element", element_places(self.record).mean(axis=1), place)
        variables = {
            name: (channel.dims, channel.values, channel.attributes)
            for name, channel in self.channels.items()
        }
        motion = self.motion
        attributes: dict[str, Any] = {} if motion is None else {"motion": motion.motion}
        data = xarray.Dataset(variables, coords, self.attributes | attributes)
        if "mode" in data:
            data["mode"].attrs |= {
                "flag_values": np.array([0, 1, 2], dtype=np.int8),
                "flag_meanings": "free_flight impact continuous_contact",
            }
        return data

    @cached_property
    def turns(self) -> xarray.Dataset:
        """Dataset of the latest turns over ``turn`` and ``crank_angle``; see
        :func:`vfife.results.run_data.latest_turns`.
        """
        return latest_turns(self)

    @cached_property
    def motion(self) -> Turns | None:
        """Class of the motion, its period, and the turns that measures are of; None without turns."""
        return evaluated_turns(self.record)

    def __getitem__(self, name: str) -> xarray.DataArray:
        """Return the series of this name, as ``result.series[name]`` does: ``result["C.force"]``."""
        return self.series[name]

    @cached_property
    def series(self) -> Series:
        """Series by the names of measures: ``result.series["C.force"]`` over time, of which ``C.force.max``
        is a measure.
        """
        return Series(self)

    def spectrum(
        self,
        name: str,
        *,
        window: str = "hann",
        seconds: float | None = None,
        turns: float | None = None,
        overlap: float = 0.5,
    ) -> Spectrum:
        """Return the amplitudes over frequency and order of a series; see
        :func:`~vfife.dynamics.spectrum`.

        name: the series, such as ``C.force``
        window: shape of the windows, as of :func:`~vfife.dynamics.spectrum`
        seconds: length of the windows (s), or
        turns: length of the windows in turns of the crank; by default that of the run
        overlap: share of a window that the next one repeats, from 0 to below 1

        Raises VfifeError for an unknown series and for windows that do not fit the run.
        """
        series = sampled(self, name)
        length = series.length(seconds, turns)
        return spectrum(
            series.values, series.spacing, window=window, length=length, overlap=overlap, **series.label
        )

    def spectrogram(
        self,
        name: str,
        *,
        window: str = "hann",
        seconds: float | None = None,
        turns: float | None = None,
        overlap: float = 0.75,
    ) -> Spectrogram:
        """Return the amplitudes over time and frequency, or order, of a series; see
        :func:`~vfife.dynamics.spectrogram`.

        name: the series, such as ``C.force``
        window: shape of the windows, as of :func:`~vfife.dynamics.spectrum`
        seconds: length of the windows (s), or
        turns: length of the windows in turns of the crank; by default a sixteenth of the run
        overlap: share of a window that the next one repeats, from 0 to below 1

        Raises VfifeError for an unknown series and for windows that do not fit the run.
        """
        series = sampled(self, name)
        length = series.length(seconds, turns)
        return spectrogram(
            series.values, series.spacing, window=window, length=length, overlap=overlap, **series.label
        )

    def envelope(self, name: str, *, band: tuple[float, float] | None = None) -> Envelope:
        """Return the envelope of a series within a band of frequencies, and its spectrum; see
        :func:`~vfife.dynamics.envelope`.

        name: the series, such as ``C.force``
        band: lowest and highest frequency (Hz), by default all; a band beyond half the output rate ends there
        """
        series = sampled(self, name)
        return envelope(series.values, series.spacing, band=band, **series.label)

    def joint(self, name: str) -> xarray.Dataset:
        """Return the dataset of one joint by quantity: ``result.joint("C").force``. Raises VfifeError for an
        unknown name.
        """
        return dataset_of(self, name, "joint")

    def body(self, name: str) -> xarray.Dataset:
        """Return the dataset of one body by quantity, with its elements and particles. Raises VfifeError for
        an unknown name.
        """
        return dataset_of(self, name, "body")

    def spring(self, name: str) -> xarray.Dataset:
        """Return the dataset of one spring, stop or bushing by quantity. Raises VfifeError for an unknown
        name.
        """
        return dataset_of(self, name, "spring")

    def to_dataframe(self, *names: str, units: bool = True, fine: bool = False) -> pandas.DataFrame:
        """Return the table for pandas: a row an output, the time as index, a column a series, ``C.force
        [N]``, or ``C.force`` without ``units``.

        ``names``: joints, bodies and springs, by default all. ``fine``: elements and particles too. ``attrs``
        has units and meanings by column. Raises VfifeError for an unknown name.
        """
        index, *table = columns(self, names, fine)
        frame = data_frame(table, index, units)
        heads = [titled(column) if units else column.name for column in table]
        for key, attribute in (("units", "units"), ("meanings", "long_name")):
            frame.attrs[key] = {
                head: column.metadata[attribute] for head, column in zip(heads, table, strict=True)
            }
        return frame

    @property
    def attributes(self) -> dict[str, Any]:
        """Provenance of the data: model, step, loop, version, laws with their sources."""
        mechanism = self.record.assembly.mechanism
        attributes: dict[str, Any] = {
            "model": mechanism.name,
            "note": mechanism.note.strip(),
            "step": self.record.assembly.choice.step,
            "loop": self.record.loop,
            "status": self.record.status.value,
            "vfife_version": versions()["vfife"],
        }
        try:
            text = dump(mechanism)
        except (TypeError, ValueError):  # a mechanism that no model file can hold still has data
            return attributes
        attributes["laws"] = "\n".join(f"{name}: {source}" for name, source in sources(mechanism).items())
        if len(text.encode()) < LONGEST_ATTRIBUTE:
            attributes["model_file"] = text
        return attributes


def standing(assembly: Assembly) -> RunData:
    """Return the view of a mechanism at its start, without a run."""
    recorded = recorded_rows(assembly)
    return RunData(Record(assembly, np.zeros(1, dtype=np.int64), assembly.state[recorded][None, :], recorded))


def latest_turns(view: RunData) -> xarray.Dataset:
    """Return the dataset of the channels of a run over ``turn`` and ``crank_angle``, shape (turns, outputs of
    a turn, ...).

    The turns are those that measures are of, and at least the last eight. Turns count from 1 and begin where
    the run began; in each, outputs are in the order of the crank angle (degrees, 0 to 360). Raises VfifeError
    without a full turn of a crank at constant speed, or where the step does not divide it.
    """
    motion, outputs, angle = view.motion, outputs_of_a_turn(view.record.assembly), view.crank_angle
    if motion is None or outputs is None or angle is None:
        raise VfifeError(
            f"{view.name}: there are no turns to lay over each other: that takes a crank at constant speed, a"
            ' run of a turn at the least, and a step that divides a turn ("auto" does); result.data has all'
            " of the run over time"
        )
    first = min(motion.first, max(1, motion.count - LONGEST + 1))
    numbers, begin = np.arange(first, motion.count + 1), (motion.count - 1) * outputs + 1
    window, shape = slice((first - 1) * outputs + 1, motion.count * outputs + 1), (len(numbers), outputs)
    turn_angle = angle[begin : begin + outputs]
    order = np.argsort(turn_angle, kind="stable")
    data = view.data.isel(time=window).drop_vars(("time", "crank_angle"), errors="ignore")
    dims = ("turn", "crank_angle")
    variables = {
        str(name): (
            (*dims, *series.dims[1:]),
            series.values.reshape(*shape, *series.shape[1:])[:, order],
            series.attrs,
        )
        for name, series in data.variables.items()
        if "time" in series.dims
    }
    dataset = data.drop_dims("time").assign_coords(
        turn=("turn", numbers, {"units": "1", "long_name": "turn of the run, counted from 1"}),
        crank_angle=(
            "crank_angle",
            turn_angle[order],
            {"units": "deg", "long_name": f"angle of {view.crank}"},
        ),
        time=(dims, view.time[window].reshape(shape)[:, order], {"units": "s", "long_name": "time"}),
    )
    return dataset.assign(variables).assign_attrs(
        motion=motion.motion, measures_of=part_of(view.record, motion)
    )


class Reductions:
    """The reductions among some names, as in ``max(C.force)``: each is a statistic of a channel."""

    def __init__(self, names: Sequence[str]) -> None:
        self.requested = {
            name: (match[1], match[2]) for name in names if (match := REDUCTION.fullmatch(name))
        }
        # Where the channels stand among those of a mechanism, by its topology.
        self.readers: dict[Topology, SeriesReader] = {}

    def compute(self, turns: Sequence[Record]) -> dict[str, float]:
        """Compute each over all turns, records of which the next begins with the last output of the one
        before.

        Of a record that is longer than a turn the last turn counts. Extremes between two outputs are not
        seen. A channel that a mechanism does not have is left out, and so are values that are not finite.
        """
        topology = turns[0].assembly.topology
        if topology not in self.readers:
            names = dict.fromkeys(channel for _, channel in self.requested.values())
            self.readers[topology] = SeriesReader(RunData(turns[0]), names)
        starts, parts = (
            [turn_of(turn) for turn in turns],
            [self.readers[topology].read(turn) for turn in turns],
        )
        time = joined([times(turn)[start:] for turn, start in zip(turns, starts, strict=True)])
        values_by_name: dict[str, float] = {}
        for name, (reduction, channel) in self.requested.items():
            if channel in parts[0] and len(time) > 1:
                values = joined(
                    [series[channel][start:] for series, start in zip(parts, starts, strict=True)]
                )
                values_by_name[name] = REDUCED[reduction](time, values)
        return {name: value for name, value in values_by_name.items() if math.isfinite(value)}


def turn_of(record: Record) -> int:
    """Return the number of the output with which the last turn of a record begins."""
    return max(int(np.argmax(last_turn(record))) - 1, 0)
