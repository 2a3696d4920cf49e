"""Waterfalls: spectra of series over a number of the model, of which each case keeps its series over the last
turns only.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..compiler.runtime.native import stream_lanes
from ..errors import Fault, ModelError
from ..files import write_rows
from ..job.cost import ASSEMBLY
from ..job.job import job_of
from ..measures.spectral import COSINES, resolution_of, window_of
from ..model.above import NotebookDocument
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..results.spectra import spectrum
from ..results.view import View, standing
from ..simulation.simulate import prepare
from ..solvers.arguments import RunArguments
from ..solvers.ensemble import placed
from ..solvers.record import Record
from ..solvers.streaming import Lane, stepped
from ..store.mapfile import MapFile
from .section_series import (
    MapWork,
    kept_in,
    law_words,
    refuse_large_frame,
    refuse_unknown,
    tupled,
    unit_at,
    unit_of,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 20  # runs


class SpectrumLane(Lane):
    """A simulation in a lane, of whose ``turns`` the ``last`` are kept, output by output, of each of
    ``series``.
    """

    def __init__(self, number: int, assembly: Assembly, turns: int, last: int, series: Sequence[str]) -> None:
        super().__init__(number, assembly, loop="generated")
        self.turns, self.series = turns, series
        self.last: deque[Array] = deque(maxlen=last)

    @property
    def ended(self) -> bool:
        """Whether it needs no further turn."""
        return self.doubtful or self.done == self.turns * self.per

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Take a turn."""
        super().take(rows, broken, state)
        if self.doubtful:
            return
        if self.done > (self.turns - (self.last.maxlen or 0)) * self.per:
            self.last.append(
                values_of(self.assembly, np.concatenate(self.parts), self.handed, self.series, self.every)[
                    :, 1:
                ]
            )
        self.parts = [rows[-1:].copy()]

    @property
    def values(self) -> Array:
        """The series over the last turns, shape (series, outputs)."""
        return np.concatenate(self.last, axis=1)


def values_of(
    assembly: Assembly, rows: Array, kept: NDArray[np.uint32], series: Sequence[str], every: int
) -> Array:
    """Series of outputs that follow each other, shape (series, outputs)."""
    view = View(Record(assembly, np.arange(len(rows), dtype=np.int64) * every, rows, kept))
    return np.array([view.series.column(name).values for name in series], dtype=float)


WHAT = "waterfall"
LAST = 4  # turns that are transformed unless said
LOOKED_AT = 9  # values whose turns are looked at for a forecast


@dataclass(frozen=True)
class WaterfallSpec:
    """What is asked: the number's ``path``, its ``unit`` and ``values``; at each ``turns`` turns, of which
    the ``last`` are transformed under a ``window``; ``series`` and their ``units``; ``outputs`` in a turn,
    orders up to the ``highest``, and the largest ``step`` (s).
    """

    model: str
    path: str
    unit: str
    values: tuple[float, ...]
    turns: int
    last: int
    window: str
    series: tuple[str, ...]
    units: tuple[str, ...]
    outputs: int
    highest: float
    step: float


@dataclass(frozen=True)
class Waterfall(NotebookDocument):
    """Amplitudes of waves over a number, NaN where it is not known yet, or where the motion diverged.

    ``orders`` (1), shape (places,); ``turn`` (s) at each value, shape (values,); of each of ``asked.series``
    the ``amplitudes`` in SI units, shape (values, places). So many values are ``done``; at the ``diverged``
    ones there is no motion.
    """

    name: str
    asked: WaterfallSpec
    orders: Array
    turn: Array
    amplitudes: Mapping[str, Array]
    done: int
    diverged: tuple[float, ...] = ()

    @property
    def frequencies(self) -> Array:
        """Orders as frequencies (Hz) at each value, shape (values, places)."""
        return np.asarray(self.orders / self.turn[:, None], dtype=float)

    @property
    def words(self) -> str:
        """Window and resolution, in words."""
        asked = self.asked
        name = asked.window if asked.window in ("flat-top", "rectangular") else asked.window.capitalize()
        wide = resolution_of(asked.window, float(asked.last))
        dropped = f", {asked.turns - asked.last} dropped" if asked.turns > asked.last else ""
        return (
            f"{name} window over {asked.last} turns{dropped}; resolution {wide:.3g} orders; {asked.outputs}"
            " outputs a turn"
        )

    @property
    def limits(self) -> str:
        """Step and laws, in words."""
        return f"steps of {1e6 * self.asked.step:.3g} µs at most; {law_words(loads(self.asked.model))}"

    def plot(self, hertz: bool = False) -> Figure:
        """The amplitudes as colour, orders to the right, or frequencies (``hertz``), the number upwards."""
        from ..plots.spectra import over_values

        return over_values(self, hertz)

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for each value and order: the value, order, frequency (Hz) and the amplitude of each
        series. Raises OSError.
        """
        asked = self.asked
        heads = (f"{name} [{unit}]" for name, unit in zip(asked.series, asked.units, strict=True))
        table: list[list[object]] = [[f"{asked.path} [{asked.unit}]", "order [1]", "frequency [Hz]", *heads]]
        every = np.stack([self.amplitudes[name] for name in asked.series], axis=2)
        for value, frequencies, amplitudes in zip(
            asked.values, self.frequencies.tolist(), every, strict=True
        ):
            if np.isfinite(amplitudes).all():
                rows = zip(self.orders.tolist(), frequencies, amplitudes.tolist(), strict=True)
                table += ([value, order, frequency, *row] for order, frequency, row in rows)
        write_rows(path, table)


def waterfall(
    mechanism: Mechanism,
    path: str,
    low: float,
    high: float,
    *,
    count: int = 50,
    turns: int = 12,
    last: int | None = None,
    series: Sequence[str] = (),
    outputs: int = 1440,
    highest: float = 50.0,
    window: str = "hann",
    step: float | None = None,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    confirm: bool = False,
) -> Waterfall:
    """Spectra of ``series`` over the number at ``path``, as ``driver.crank.speed``, from ``low`` to ``high``
    (SI) in ``count`` runs of their own.

    Each makes so many ``turns``, of which the ``last`` are transformed, four unless said: orders are told
    apart by 1/last of a turn, up to the ``highest``. What is faster than half the ``outputs`` of a turn is
    folded back. ``series``: the forces of joints with play, of all joints where there is none, unless said.
    ``step`` (s): the finer automatic one of both ends unless said. With a ``file`` each run is kept when it
    ends, and the same call goes on there. Ctrl-C leaves what is complete. ``confirm``: make it even where it
    takes more than an hour. Raises ModelError for what cannot be, HeldError where another process writes the
    file.
    """
    last = last_of(last, turns)
    job = job_of("waterfall", file, confirm, progress, lambda one: progress(one.done, one.steps))  # type: ignore[misc]
    text = dump(mechanism)
    some = [loads(text, set=[(path, value)]) for value in np.linspace(low, high, LOOKED_AT).tolist()]
    periods = [turn_of(model) or 0.0 for model in some]
    if all(periods) and 1 <= last <= turns:  # planned reports the others
        step = step or automatic(some)
        steps = sum(periods) / len(periods) / step
        lanes, numbers = (
            stream_lanes(len(mechanism.contacts)),
            max(len(series), 1) * (highest * last + 1) / last,
        )
        work = MapWork(
            "run",
            count,
            turns,
            turns - last,
            steps,
            max(lanes, 3),
            numbers,
            growth=False,
            start=ASSEMBLY,
            first_look=(FIRST_LOOK, turns),
        )
        job.begin(work.forecast(placed(mechanism, step, turns, outputs), file))
    values = tuple(map(float, np.linspace(low, high, count)))
    asked = WaterfallSpec(
        text, path, "", values, turns, last, window, tuple(series), (), outputs, highest, step or 0.0
    )
    asked, assemblies = planned(mechanism, asked)
    places = round(asked.highest * asked.last) + 1
    with job, kept_in(file, {"what": WHAT, "name": mechanism.name, "asked": asked}, "this waterfall") as kept:
        found = (
            {} if kept is None else {number: points for number, (points, _) in kept.legs(gaps=True).items()}
        )
        missing = [k for k in range(count) if k not in found]
        try:
            for one in stepped(
                (SpectrumLane(k, assemblies[k], turns, last, asked.series) for k in missing),
                max(1, len(missing)),
            ):
                points = transformed(one, asked, places)
                if kept is not None:
                    kept.write_row("legs", one.number, points, np.zeros((0, 1)), np.zeros((0, 1)))
                found[one.number] = points
                job.count(len(found), count, "runs")
        except KeyboardInterrupt:
            if not found:
                raise
    return laid_out(mechanism.name, asked, found)


def read_waterfall(file: MapFile) -> Waterfall:
    """The waterfall in a file, as far as it is known."""
    said = file.spec
    return laid_out(
        said["name"],
        WaterfallSpec(**tupled(said["asked"])),
        {number: points for number, (points, _) in file.legs(gaps=True).items()},
    )


def transformed(one: SpectrumLane, asked: WaterfallSpec, places: int) -> Array:
    """Amplitudes of each series, shape (series, places); NaN where the motion diverged."""
    if one.doubtful:
        return np.full((len(asked.series), places), math.nan)
    found = [spectrum(values, 1.0, window=asked.window).amplitudes[:places] for values in one.values]
    return np.array(found)


def laid_out(name: str, asked: WaterfallSpec, found: Mapping[int, Array]) -> Waterfall:
    """The waterfall of members by their numbers."""
    places = round(asked.highest * asked.last) + 1
    every = np.full((len(asked.values), len(asked.series), places), math.nan)
    for number, points in found.items():
        every[number] = points
    broken = tuple(
        asked.values[number] for number, points in sorted(found.items()) if not np.isfinite(points).all()
    )
    turn = np.array(
        [turn_of(loads(asked.model, set=[(asked.path, value)])) or math.nan for value in asked.values]
    )
    amplitudes = {series: every[:, j] for j, series in enumerate(asked.series)}
    return Waterfall(name, asked, np.arange(places) / asked.last, turn, amplitudes, len(found), broken)


def planned(mechanism: Mechanism, asked: WaterfallSpec) -> tuple[WaterfallSpec, list[Assembly]]:
    """What is asked, with step, series and units where they are left open, and the model at each value.
    Raises ModelError.
    """
    window_of(asked.window, 8)
    last, turns, outputs, faults = asked.last, asked.turns, asked.outputs, []
    if turn_of(mechanism) is None:
        faults.append(
            Fault(
                "driver", "no crank turns at constant speed, so there are no orders", "", "", "drive a body"
            )
        )
    if not 1 <= last <= turns:
        faults.append(
            Fault(
                "last",
                "so many turns are not made",
                str(last),
                f"1 to {turns}",
                "transform fewer, or make more turns",
            )
        )
    if last < (least := len(COSINES[asked.window])):
        what = f"under the window {asked.window} an order runs into the next"
        faults.append(Fault("last", what, str(last), f"at least {least}", "take more turns"))
    if not 0.0 < asked.highest <= 0.5 * outputs:
        limit = f"up to half the {outputs} outputs of a turn"
        faults.append(Fault("highest", "no such order is seen", f"{asked.highest:g}", limit, "ask for more"))
    if faults:
        raise ModelError(faults, mechanism.name)
    models = [loads(asked.model, set=[(asked.path, value)]) for value in asked.values]
    still = [value for value, model in zip(asked.values, models, strict=True) if turn_of(model) is None]
    if still:
        what = "no crank turns here, so there are no orders"
        raise ModelError(
            [Fault(asked.path, what, f"{still[0]:g}", "", "leave it out of the range")], mechanism.name
        )
    step = asked.step or automatic(models)
    assemblies = [placed(model, step, turns, outputs) for model in models]
    refuse_large_frame(assemblies[0])
    start = standing(assemblies[0])
    series = asked.series or usual(assemblies[0], list(start.series))
    refuse_unknown(
        "series",
        series,
        list(start.series),
        "the mechanism has none of this name",
        "name one that it has",
        mechanism.name,
    )
    if not series:
        raise ModelError(
            [Fault("series", "the mechanism has no joint that carries a force", "", "", "name series")],
            mechanism.name,
        )
    units = tuple(unit_of(start, name) for name in series)
    return (
        replace(asked, unit=unit_at(mechanism, asked.path), series=series, units=units, step=step),
        assemblies,
    )


def last_of(last: int | None, turns: int) -> int:
    """Turns that are transformed, of so many."""
    return min(LAST, turns) if last is None else last


def automatic(models: Sequence[Mechanism]) -> float:
    """The finer automatic step (s) of the first and the last of models."""
    return min(
        prepare(model, RunArguments(turns=1.0, companions=0)).assembly.choice.step
        for model in (models[0], models[-1])
    )


def usual(assembly: Assembly, known: Sequence[str]) -> tuple[str, ...]:
    """Forces of the joints with play, or of all joints."""
    names = [f"{name}.force" for name in dict.fromkeys(assembly.contact_joints) or assembly.mechanism.joints]
    return tuple(name for name in names if name in known)
