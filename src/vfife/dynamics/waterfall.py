"""Waterfalls: spectra of series over a parameter of the model, each from the last turns of a run of its own.

Spectra are taken over whole turns and by orders (multiples of the crank's frequency): lines stay in place
while the speed varies, and a motion that repeats every turn has no leakage.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..compiler.runtime.native import stream_lanes
from ..errors import Fault, ModelError
from ..measures.spectral import COSINES, resolution_of, window_of
from ..model.functions import crank_faults, turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..options import with_options
from ..results.run_data import RunData, standing
from ..results.spectra import spectrum
from ..simulation.simulate import prepare
from ..simulation.turn_steps import refuse_large_frame
from ..solvers.arguments import Arguments, RunArguments
from ..solvers.ensemble import placed
from ..solvers.record import Record
from ..solvers.streaming import Lane, stepped
from ..store.studyfile import MapFile
from .maps import Map, MapRun, MapSpec, MapWork, RunOptions, unit_at
from .series import chosen_series
from .start_states import values_between

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 20  # runs of a quick trial
START = 0.07  # s to assemble a run and to transform its series
LAST = 4  # default number of turns that are transformed
PROBED_VALUES = 9  # values whose turns are averaged for the forecast


class SpectrumLane(Lane):
    """A run in a lane that keeps the outputs of its ``spec.last`` last turns, of each of ``spec.series``."""

    def __init__(self, number: int, assembly: Assembly, spec: WaterfallSpec) -> None:
        super().__init__(number, assembly, loop="generated")
        self.spec = spec
        self.last: deque[Array] = deque(maxlen=spec.last)

    @property
    def finished(self) -> bool:
        """Whether the run needs no further turn."""
        return self.doubtful or self.done == self.spec.turns * self.per

    def take(self, rows: Array, broken: int, state: Array) -> None:
        """Receive the outputs of a turn. The last output before it is kept, because some series are
        differences of outputs.
        """
        super().take(rows, broken, state)
        if self.doubtful:
            return
        if self.done > (self.spec.turns - self.spec.last) * self.per:
            outputs = np.concatenate(self.parts)
            steps = np.arange(len(outputs), dtype=np.int64) * self.every
            view = RunData(Record(self.assembly, steps, outputs, self.handed))
            values = [view.series.column(name).values for name in self.spec.series]
            self.last.append(np.array(values, dtype=float)[:, 1:])
        self.parts = [rows[-1:].copy()]

    @property
    def amplitudes(self) -> Array:
        """Amplitudes of each series (SI) by order, shape (series, orders); NaN if the motion diverged."""
        if self.doubtful:
            return np.full((len(self.spec.series), self.spec.orders), math.nan)
        window, values = self.spec.window, np.concatenate(self.last, axis=1)
        return np.array(
            [spectrum(curve, 1.0, window=window).amplitudes[: self.spec.orders] for curve in values]
        )


@dataclass(frozen=True)
class WaterfallSpec(MapSpec):
    """Specification of a waterfall over ``values`` of the parameter at ``path``, with its ``unit``.

    At each value the ``last`` of ``turns`` turns are transformed with a ``window``, for ``series`` with their
    ``units``. A turn has ``outputs`` outputs, orders go up to the ``highest``, and ``step`` (s) is the
    largest step.
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

    @property
    def orders(self) -> int:
        """Number of orders."""
        return round(self.highest * self.last) + 1


@dataclass(frozen=True, repr=False)
class Waterfall(Map):
    """Amplitudes of orders over a parameter; NaN where they are not computed yet or the motion diverged.

    ``orders`` (1), shape (orders,); ``turn``: duration of a turn (s) at each value, shape (values,);
    ``amplitudes`` by series, in SI units, shape (values, orders). ``done`` is the number of computed values;
    ``diverged`` are the values without a motion.
    """

    file_kind: ClassVar[str] = "waterfall"
    noun: ClassVar[str] = "runs"
    orders: Array
    turn: Array
    amplitudes: Mapping[str, Array]
    done: int
    diverged: tuple[float, ...] = ()

    @classmethod
    def of(cls, name: str, spec: WaterfallSpec, legs: Mapping[int, Array]) -> Waterfall:
        """Return the waterfall with the amplitudes ``legs``, by number of the value."""
        table = np.full((len(spec.values), len(spec.series), spec.orders), math.nan)
        for number, amplitudes in legs.items():
            table[number] = amplitudes
        diverged = tuple(
            spec.values[number]
            for number, amplitudes in sorted(legs.items())
            if not np.isfinite(amplitudes).all()
        )
        turn = np.array(
            [turn_of(loads(spec.model, set=[(spec.path, value)])) or math.nan for value in spec.values]
        )
        amplitudes_of = {series: table[:, j] for j, series in enumerate(spec.series)}
        return cls(name, spec, np.arange(spec.orders) / spec.last, turn, amplitudes_of, len(legs), diverged)

    @classmethod
    def read(cls, file: MapFile) -> Waterfall:
        """Return the waterfall in a map file, as far as it is computed."""
        legs = file.legs(gaps=True)
        return cls.of(
            file.spec["name"],
            WaterfallSpec.of(file.spec["asked"]),
            {number: amplitudes for number, (amplitudes, _) in legs.items()},
        )

    @property
    def frequencies(self) -> Array:
        """Orders as frequencies (Hz) at each value, shape (values, orders)."""
        return np.asarray(self.orders / self.turn[:, None], dtype=float)

    @property
    def words(self) -> str:
        """Window and resolution as text."""
        spec = self.spec
        name = spec.window if spec.window in ("flat-top", "rectangular") else spec.window.capitalize()
        wide = resolution_of(spec.window, float(spec.last))
        dropped = f", {spec.turns - spec.last} dropped" if spec.turns > spec.last else ""
        return (
            f"{name} window over {spec.last} turns{dropped}; resolution {wide:.3g} orders; {spec.outputs}"
            " outputs a turn"
        )

    @property
    def limits(self) -> str:
        """Step and laws as text."""
        return f"steps of {1e6 * self.spec.step:.3g} µs at most; {self.laws}"

    def plot(self, hertz: bool = False) -> Figure:
        """Return a figure with amplitudes as colours, the parameter upwards, and orders, or with ``hertz``
        frequencies, to the right.
        """
        from ..plots.spectra import over_values

        return over_values(self, hertz)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for each value and order: value, order, frequency (Hz) and the amplitude
        of each series.
        """
        spec = self.spec
        heads = (f"{name} [{unit}]" for name, unit in zip(spec.series, spec.units, strict=True))
        yield [f"{spec.path} [{spec.unit}]", "order [1]", "frequency [Hz]", *heads]
        values = np.stack([self.amplitudes[name] for name in spec.series], axis=2)
        for value, frequencies, amplitudes in zip(
            spec.values, self.frequencies.tolist(), values, strict=True
        ):
            if np.isfinite(amplitudes).all():
                rows = zip(self.orders.tolist(), frequencies, amplitudes.tolist(), strict=True)
                yield from ([value, order, frequency, *row] for order, frequency, row in rows)


class SpectrumOptions(RunOptions, total=False):
    """Keywords of a waterfall."""

    outputs: int
    highest: float
    window: str


@dataclass
class SpectrumRun(MapRun):
    """The computation of a waterfall with ``outputs`` in a turn, orders up to the ``highest``, and the
    ``window`` of the spectra.
    """

    outputs: int = 1440
    highest: float = 50.0
    window: str = "hann"

    def read(self, arguments: Arguments) -> None:
        """Read outputs, the highest order and the window."""
        arguments.count("outputs", self.outputs, optional=False)
        self.highest = arguments.quantity("highest", self.highest, "1", zero=True) or 0.0
        arguments.kind("window", self.window, (str,), "the name of a window")

    def check(self, mechanism: Mechanism, last: int) -> None:
        """Raise ModelError for turns, outputs and orders that define no spectrum."""
        window_of(self.window, 8)
        faults = crank_faults(mechanism, "there are no orders")
        if not 1 <= last <= self.turns:
            remedy = "transform fewer, or make more turns"
            faults.append(Fault("last", "the run has fewer turns", str(last), f"1 to {self.turns}", remedy))
        if last < (minimum := len(COSINES[self.window])):
            message = f"under the window {self.window} neighbouring orders overlap"
            faults.append(Fault("last", message, str(last), f"at least {minimum}", "take more turns"))
        if not 0.0 < self.highest <= 0.5 * self.outputs:
            limit = f"up to half the {self.outputs} outputs of a turn"
            faults.append(
                Fault("highest", "the outputs do not resolve it", f"{self.highest:g}", limit, "ask for more")
            )
        if faults:
            raise ModelError(faults, mechanism.name)


@with_options(SpectrumOptions, turns=12, series=(), outputs=1440, highest=50.0, window="hann", confirm=False)
def waterfall(
    mechanism: Mechanism,
    path: str,
    low: float | str,
    high: float | str,
    *,
    count: int = 50,
    last: int | None = None,
    **options: Unpack[SpectrumOptions],
) -> Waterfall:
    """Compute spectra of ``series`` over the parameter at ``path``, for example ``driver.crank.speed``, from
    ``low`` to ``high`` in ``count`` runs.

    >>> waterfall(mechanism, "driver.crank.speed", "500 rpm", "3000 rpm").plot()  # doctest: +SKIP

    Each run has ``turns`` (12), of which the ``last``, four unless given, are transformed with a ``window``
    ("hann"): orders up to the ``highest`` (50) in intervals of 1/last. Orders above half the ``outputs``
    (1440) of a turn are aliased. ``series``: by default the forces of joints with clearance, or of all joints
    if no joint has clearance. ``step`` (s): by default the finer automatic step of both ends of the range.

    ``file`` stores each run when it ends, and the same call continues it; ``progress(done, total)`` is called
    at the same time. Ctrl-C ends the computation and returns what is complete. While the step is searched
    for, it raises KeyboardInterrupt. ``confirm`` permits work of more than an hour. Raises ModelError for
    arguments that define no spectrum, HeldError if another process writes the file.
    """
    run = SpectrumRun("waterfall", **options)
    arguments = Arguments("waterfall")
    arguments.count("last", last)
    arguments.check()
    values = values_between("waterfall", mechanism, path, (low, high), count)
    last, text = min(LAST, run.turns) if last is None else last, dump(mechanism)
    run.check(mechanism, last)
    probed = [
        loads(text, set=[(path, value)])
        for value in np.linspace(values[0], values[-1], PROBED_VALUES).tolist()
    ]
    periods = [turn_of(model) or 0.0 for model in probed]
    step = run.step
    if all(periods):  # a value at rest is reported below
        step = step or automatic_step(probed)
        run.begin(
            work_of(run, mechanism, count, last, sum(periods) / len(periods) / step),
            placed(mechanism, step, run.turns, run.outputs),
        )
    models = [loads(text, set=[(path, value)]) for value in values]
    if resting := [value for value, model in zip(values, models, strict=True) if turn_of(model) is None]:
        message = "no crank turns here, so there are no orders"
        raise ModelError(
            [Fault(path, message, f"{resting[0]:g}", "", "leave it out of the range")], mechanism.name
        )
    step = step or automatic_step(models)
    assemblies = [placed(model, step, run.turns, run.outputs) for model in models]
    refuse_large_frame(assemblies[0])
    series, units = chosen_series(assemblies[0], run.series, joint_forces)
    if not series:
        raise ModelError(
            [Fault("series", "the mechanism has no joint that carries a force", "", "", "name series")],
            mechanism.name,
        )
    spec = WaterfallSpec(
        text, path, unit_at(mechanism, path), values, run.turns, last, run.window, series, units,
        run.outputs, run.highest, step
    )  # fmt: skip
    with run.rows(Waterfall, mechanism.name, spec, "this waterfall") as rows:
        rows.done |= {number: points for number, (points, _) in rows.legs(gaps=True).items()}
        missing = [k for k in range(count) if k not in rows.done]
        for lane in stepped((SpectrumLane(k, assemblies[k], spec) for k in missing), max(1, len(missing))):
            rows.done[lane.number] = lane.amplitudes
            rows.write("legs", lane.number, lane.amplitudes, np.zeros((0, 1)), np.zeros((0, 1)))
            run.job.count(len(rows.done), count, "runs")
    return Waterfall.of(mechanism.name, spec, rows.done)


def work_of(run: SpectrumRun, mechanism: Mechanism, count: int, last: int, steps: float) -> MapWork:
    """Return the work of ``count`` runs with ``steps`` steps in a turn on average, of which the ``last``
    turns are transformed.
    """
    lanes = max(stream_lanes(len(mechanism.contacts)), 3)
    numbers = max(len(run.series), 1) * (run.highest * last + 1) / last
    return MapWork(
        "run", count, run.turns, run.turns - last, steps, lanes, numbers, growth=False, start=START,
        first_look=(FIRST_LOOK, run.turns)
    )  # fmt: skip


def automatic_step(models: Sequence[Mechanism]) -> float:
    """Return the finer of the automatic steps (s) of the first and the last model."""
    return min(
        prepare(model, RunArguments(turns=1.0, companions=0)).assembly.choice.step
        for model in (models[0], models[-1])
    )


def joint_forces(assembly: Assembly) -> tuple[str, ...]:
    """Return the names of the force series of the joints with clearance, or of all joints if no joint has
    clearance.
    """
    names = [f"{name}.force" for name in dict.fromkeys(assembly.contact_joints) or assembly.mechanism.joints]
    series = standing(assembly).series
    return tuple(name for name in names if name in series)
