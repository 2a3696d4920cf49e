"""A run as its readers see it: channels, one dataset with units, measures, the energy ledger."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..measures import Ledger, Measures, last_turn, ledger, ranged
from ..measures.contacts import Around, Impacts, around, impacts
from ..measures.elastic import along
from ..measures.guides import PointMotion, point_motion
from ..measures.motion import times
from ..measures.ranges import counted
from ..measures.turns import Turns, part_of
from ..modelfile import dump
from ..solvers.record import Record, recorded_rows
from ..solvers.repeating import LONGEST, outputs_of_a_turn
from ..store.provenance import sources, versions
from .channels import Channel, channels, entities
from .series import REDUCED, REDUCTION, Series, dataset_of, frame, joined
from .spectra import Envelope, Spectrogram, Spectrum, envelope, length_of, sampled, spectrogram, spectrum

if TYPE_CHECKING:
    import pandas
    import xarray

LONGEST_ATTRIBUTE = 60000  # bytes; HDF5 takes no attribute beyond 64 KiB


class View:
    """What a run gives. All of it is built when it is first asked for, and only ``data`` loads xarray.

    ``record`` holds the rows, ``reference`` is the result of the ideal mechanism or None.
    """

    def __init__(self, record: Record, reference: View | None = None) -> None:
        self.record, self.reference = record, reference

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

    # --------------------------------------------------------------------------------------------------------
    # numbers

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self.record.assembly.mechanism.name

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the outputs (s), or load factors of a static analysis, shape (outputs,)."""
        return times(self.record)

    @property
    def crank(self) -> str | None:
        """The body that is driven, the first one if there are several."""
        return next((body.name for body in self.record.assembly.bodies.values() if body.driven == 0), None)

    @property
    def crank_angle(self) -> NDArray[np.float64] | None:
        """Angle of the crank (degrees, not reduced to one turn), shape (outputs,), or None without a crank."""
        if self.crank is None:
            return None
        p = self.record.assembly.topology.driven[0]
        return np.degrees(self.record.block("particle_theta")[:, p])

    @property
    def last_turn(self) -> NDArray[np.bool_]:
        """Outputs of the last full crank turn, over which maxima are taken; all outputs without a crank."""
        return last_turn(self.record)

    @cached_property
    def ledger(self) -> Ledger:
        """The energy ledger."""
        return ledger(self.record)

    @cached_property
    def measures(self) -> Measures:
        """Flat map of the numbers a run is judged by; see :func:`vfife.measures.catalogue.measures`.

        Of which turns they are says :attr:`motion`. Each is a number with ``low`` and ``high``, its range
        over run and companions, and ``lowest`` and ``highest``, those of its turns:
        :class:`~vfife.measures.measured.Measured`.
        """
        return ranged(self.record, None if self.reference is None else self.reference.measures)

    # ----------------------------------------------------------------------------------------------------------- data

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """Series by name, as plain arrays with unit and meaning."""
        return channels(self.record, self.ledger)

    def point(self, name: str) -> PointMotion:
        """Position, velocity and acceleration of a pin ``body.pin`` at the outputs, global axes;
        ``.along(direction)`` of a direction of space.

        Raises ValueError with the names there are.
        """
        return point_motion(self.record, name)

    @cached_property
    def impacts(self) -> Impacts:
        """The contacts that began, one by one as far as the outputs tell them apart: see
        :func:`vfife.measures.contacts.impacts`.
        """
        return impacts(self.record)

    def around(self, side: str = "bearing", bins: int = 72, last_turn: bool = False) -> Around:
        """Time in contact, impulse and friction over the angle of each bearing, or "journal", in the frame of
        its body, in all or of the last turn: see :func:`vfife.measures.contacts.around`.
        """
        return around(self.record, side, bins, self.last_turn if last_turn else None)

    @cached_property
    def data(self) -> xarray.Dataset:
        """All channels over time and the names of joints, bodies, elements and particles, with units and long
        names.
        """
        import xarray

        told = (
            {"units": "1", "long_name": "load factor"}
            if self.record.static
            else {"units": "s", "long_name": "time"}
        )
        coords: dict[str, Any] = {"time": ("time", self.time, told)}
        coords |= {entity: (entity, np.array(names)) for entity, names in entities(self.record).items()}
        if self.crank_angle is not None:
            said = {"units": "deg", "long_name": f"angle of {self.crank}, not reduced to one turn"}
            coords["crank_angle"] = ("time", self.crank_angle, said)
        if "element" in coords:
            said = {
                "units": "m",
                "long_name": (
                    "middle of the element along its link from the start, or along its member of a frame"
                ),
            }
            coords["element_position"] = ("element", along(self.record).mean(axis=1), said)
        variables = {name: (one.dims, one.values, one.attributes) for name, one in self.channels.items()}
        data = xarray.Dataset(variables, coords, self.attributes)
        if "mode" in data:
            data["mode"].attrs |= {
                "flag_values": np.array([0, 1, 2], dtype=np.int8),
                "flag_meanings": "free_flight impact continuous_contact",
            }
        return data

    @cached_property
    def turns(self) -> xarray.Dataset:
        """The latest turns laid over each other, over ``turn`` and ``crank_angle``: see
        :func:`vfife.results.view.latest_turns`.
        """
        return latest_turns(self)

    @cached_property
    def motion(self) -> Turns | None:
        """Whether the turns of the run repeat, from which one on, with which period, and which of them its
        measures are of; None without turns.
        """
        return counted(self.record)

    @cached_property
    def series(self) -> Series:
        """The channels by the names that measures have: ``result.series["C.force"]`` over time, of which
        ``C.force.max`` is a measure.
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
        """Amplitudes over frequency and order of a series, ``C.force``: see :func:`vfife.spectrum`.

        Windows are so many ``seconds`` or ``turns`` long, or as the run. Raises VfifeError for what cannot
        be.
        """
        one = sampled(self, name)
        given = {"turn": one.turn, "name": name, "unit": one.unit}
        return spectrum(
            one.values,
            one.spacing,
            window=window,
            length=length_of(one, seconds, turns),
            overlap=overlap,
            **given,  # type: ignore[arg-type]
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
        """Amplitudes over time and frequency, or order, of a series, ``C.force``: see
        :func:`vfife.spectrogram`.

        Windows are so many ``seconds`` or ``turns`` long, or a sixteenth of the run. Raises VfifeError for
        what cannot be.
        """
        one = sampled(self, name)
        given = {"turn": one.turn, "name": name, "unit": one.unit, "start": one.start}
        return spectrogram(
            one.values,
            one.spacing,
            window=window,
            length=length_of(one, seconds, turns),
            overlap=overlap,
            **given,  # type: ignore[arg-type]
        )

    def envelope(self, name: str, *, band: tuple[float, float] | None = None) -> Envelope:
        """Size of what vibrates in a series, within a ``band`` of frequencies (Hz), and its spectrum: see
        :func:`vfife.envelope`.
        """
        one = sampled(self, name)
        return envelope(
            one.values, one.spacing, band=band, turn=one.turn, start=one.start, name=name, unit=one.unit
        )

    def joint(self, name: str) -> xarray.Dataset:
        """All about one joint over time, by quantity: ``result.joint("C").force``. Raises VfifeError for a
        name that no joint has.
        """
        return dataset_of(self, name, "joint")

    def body(self, name: str) -> xarray.Dataset:
        """All about one body over time, by quantity, its elements and particles with it. Raises VfifeError
        for a name that no body has.
        """
        return dataset_of(self, name, "body")

    def spring(self, name: str) -> xarray.Dataset:
        """All about one spring, stop or bushing over time, by quantity. Raises VfifeError for a name that
        none has.
        """
        return dataset_of(self, name, "spring")

    def to_dataframe(self, *names: str, units: bool = True, fine: bool = False) -> pandas.DataFrame:
        """One table for pandas: a row an output, the time as its index, a column a series, ``C.force [N]``;
        without ``units``, ``C.force``.

        ``names``: joints, bodies and springs; all of them unless some are named. ``fine``: elements and
        particles too. Units and meanings by column are in ``attrs``. Raises VfifeError for a name that
        nothing has.
        """
        return frame(self, names, units, fine)

    @property
    def attributes(self) -> dict[str, Any]:
        """Where the data come from: model, step, loop, version, laws with their sources."""
        mechanism = self.record.assembly.mechanism
        found: dict[str, Any] = {
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
            return found
        found["laws"] = "\n".join(f"{name}: {source}" for name, source in sources(mechanism).items())
        if len(text.encode()) < LONGEST_ATTRIBUTE:
            found["model_file"] = text
        return found


def standing(assembly: Assembly) -> View:
    """A mechanism as it starts, of which nothing was run."""
    kept = recorded_rows(assembly)
    return View(Record(assembly, np.zeros(1, dtype=np.int64), assembly.state[kept][None, :], kept))


def latest_turns(view: View) -> xarray.Dataset:
    """The channels of a run over ``turn`` and ``crank_angle``, shape (turns, outputs of a turn, ...): the
    turns that its measures are of, and the last eight at least, as far as there are so many.

    A turn is counted from 1 and ends where the next one begins; its angle (degrees) is that from the last
    whole turn of the crank before its begin. Raises VfifeError where there is no whole turn of a crank at
    constant speed, or the step does not divide it.
    """
    said, outputs, angle = view.motion, outputs_of_a_turn(view.record.assembly), view.crank_angle
    if said is None or outputs is None or angle is None:
        raise VfifeError(
            f"{view.name}: there are no turns to lay over each other: that takes a crank at constant speed, a"
            ' run of a turn at the least, and a step that divides a turn ("auto" does); result.data has all'
            " of the run over time"
        )
    first = min(said.first, max(1, said.count - LONGEST + 1))
    numbers = np.arange(first, said.count + 1)
    window = slice((first - 1) * outputs + 1, said.count * outputs + 1)
    begin = angle[(said.count - 1) * outputs]
    over = angle[(said.count - 1) * outputs + 1 : said.count * outputs + 1] - 360.0 * np.floor(
        begin / 360.0 + 1e-6
    )
    data = view.data.isel(time=window).drop_vars(("time", "crank_angle"), errors="ignore")
    time = view.time[window].reshape(len(numbers), outputs)
    shaped = {name: one for name, one in data.variables.items() if "time" in one.dims}
    found = data.drop_dims("time").assign_coords(
        turn=("turn", numbers, {"units": "1", "long_name": "turn of the run, counted from 1"}),
        crank_angle=("crank_angle", over, {"units": "deg", "long_name": f"angle of {view.crank}"}),
        time=(("turn", "crank_angle"), time, {"units": "s", "long_name": "time"}),
    )
    dims = ("turn", "crank_angle")
    found = found.assign({
        str(name): ((*dims, *one.dims[1:]), one.values.reshape(len(numbers), outputs, *one.shape[1:]), one.attrs) for name, one in shaped.items()
    })  # fmt: skip
    return found.assign_attrs(motion=said.motion, measures_of=part_of(view.record, said))


class Reductions:
    """Those of some names that are reductions: what each takes of which channel."""

    def __init__(self, names: Sequence[str]) -> None:
        self.asked = {name: (found[1], found[2]) for name in names if (found := REDUCTION.fullmatch(name))}

    def over(self, turns: Sequence[Record]) -> dict[str, float]:
        """Each over all the turns together, records of which the next begins with the last output of the one
        before.

        Of a record that is longer than a turn its last turn counts. What happens between two outputs is not
        seen. A channel that a mechanism does not have is left out, and so is what is not finite.
        """
        parts = [View(one) for one in turns]
        own = [turn_of(one) for one in turns]
        time = joined([times(one)[at:] for one, at in zip(turns, own, strict=True)])
        found: dict[str, float] = {}
        for name, (how, channel) in self.asked.items():
            if channel in parts[0].series and len(time) > 1:
                values = [
                    np.asarray(one.series.column(channel).values[at:], dtype=float)
                    for one, at in zip(parts, own, strict=True)
                ]
                found[name] = REDUCED[how](time, joined(values))
        return {name: value for name, value in found.items() if math.isfinite(value)}


def turn_of(record: Record) -> int:
    """The output with which the last turn of a record begins."""
    return max(int(np.argmax(last_turn(record))) - 1, 0)
