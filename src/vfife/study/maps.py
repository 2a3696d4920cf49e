"""Bifurcation diagrams: a number swept up and down while the motion goes on, looked at once a turn, with the exponent by which motions part."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.chaos import exponent
from ..analysis.verdict import kind
from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, StepError, suggestion
from ..live.sliders import value_at
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..result import Result
from ..results.channels import entities
from ..results.folder import written
from ..results.lock import Lock
from ..results.mapfile import MapFile
from ..results.view import View, standing
from ..simulation import prepare
from ..solvers.arguments import Asked
from ..solvers.record import Record
from ..solvers.sweeping import Sweep, carried_on
from ..solvers.tangents import Neighbours
from ..solvers.transient import choose_loop

Array = NDArray[np.float64]
NEAR = 1e-6  # of the range, by which the difference begins that is watched
CHAINS = ("up", "down")


@dataclass(frozen=True)
class Swept:
    """What is asked: the number's ``path`` and its ``values`` in the order of the way up, ``turns`` at each, the first of them ``dropped``;
    ``series`` are looked at once a turn at ``phase`` (1) of it; ``steps`` in a turn. ``unit`` is that of the number, ``units`` are those of series.
    """

    model: str
    path: str
    values: tuple[float, ...]
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    unit: str = "SI"
    units: tuple[str, ...] = ()


@dataclass(frozen=True)
class Bifurcation:
    """A diagram, its values in the order of the way up and NaN where it is not known yet; the first of two chains is the way up, the other down.

    Of each of ``asked.series`` its ``points`` in SI units, shape (chains, values, turns); the largest Lyapunov ``exponents`` (1/turn), each with
    the lower and the higher of its two halves, shape (chains, values, 3); ``kinds`` of the motion in words, shape (chains, values). So many values
    are ``done`` in each direction.
    """

    name: str
    asked: Swept
    points: Mapping[str, Array]
    exponents: Array
    kinds: tuple[tuple[str, ...], tuple[str, ...]]
    done: int

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for every value, direction and turn that was looked at, with the exponent and the kind of the motion."""
        stream = io.StringIO(newline="")
        table = csv.writer(stream)
        table.writerow([self.asked.path, "way", "turn", *self.asked.series, "exponent", "kind"])
        for k, way in enumerate(CHAINS):
            for place, value in enumerate(self.asked.values):
                if self.kinds[k][place]:
                    said = float(self.exponents[k, place, 0]), self.kinds[k][place]
                    for turn, row in enumerate(np.stack([one[k, place] for one in self.points.values()], axis=1).tolist()):
                        table.writerow([value, way, self.asked.dropped + turn + 1, *row, *said])
        written(Path(path), stream.getvalue(), newline="")


def bifurcation(
    mechanism: Mechanism,
    path: str,
    low: float,
    high: float,
    *,
    count: int = 100,
    turns: int = 150,
    dropped: int = 100,
    series: Sequence[str] = (),
    phase: float = 0.0,
    step: float | None = None,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Bifurcation:
    """Sweeps the number at ``path`` from ``low`` to ``high`` (SI) and back in ``count`` values, the state carried on from one to the next.

    At each ``turns`` turns, of which ``dropped`` are not looked at. ``series``: what is looked at once a turn, by its name in ``result.series``;
    the penetration and the largest force of the first contact unless said. ``step`` (s): the finer automatic one of both ends unless said; a turn
    has a whole number of them, the same for all values. With a ``file`` what is known is kept in it after each value, and the same call goes on
    there. Ctrl-C leaves what is complete. Raises ModelError for a number that cannot be swept so, HeldError where another process writes the file.
    """
    asked, every = planned(mechanism, path, np.linspace(low, high, count), turns, dropped, tuple(series), phase, step)
    refuse(asked, every)
    with nullcontext() if file is None else Lock(Path(file).absolute().parent, f"{Path(file).name}.lock", "this map"):
        return drawn_together(mechanism.name, asked, swept(mechanism, asked, every, file, progress))


def swept(
    mechanism: Mechanism, asked: Swept, every: list[Assembly], file: str | Path | None, progress: Callable[[int, int], None] | None
) -> list[tuple[Array, Array]]:
    """The legs of a map, those that its file has among them. Ctrl-C leaves what is complete."""
    chains = [every, every[::-1]]
    near = [neighbours(mechanism, asked, chain[0], k) for k, chain in enumerate(chains)]
    kept = opened(file, asked, mechanism.name)
    legs = [] if kept is None else kept.legs()
    try:
        sweep = Sweep(chains, near, asked.phase)
        resume = None if kept is None or not legs else (len(legs) - 1, kept.state(len(legs) - 1).reshape(sweep.states.shape))
        for leg in sweep.legs(asked.turns, asked.dropped, resume):
            points = looked(asked, [chain[leg.number] for chain in chains], sweep.kept, leg.rows)
            if kept is not None:
                kept.keep(leg.number, points.reshape(len(points), -1), leg.growth, leg.state)
            legs.append((points.reshape(len(points), -1), leg.growth))
            if progress is not None:
                progress(len(legs), len(every))
    except KeyboardInterrupt:
        if not legs:
            raise
    finally:
        if kept is not None:
            kept.__exit__()
    return legs


def read_map(path: str | Path) -> Bifurcation:
    """The diagram in a map file, as far as it is known. Raises RunFileError for any other file."""
    with MapFile.open(Path(path)) as file:
        said = file.asked
        tuples: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in said["asked"].items()}
        return drawn_together(said["name"], Swept(**tuples), file.legs())


def planned(
    mechanism: Mechanism, path: str, values: Array, turns: int, dropped: int, series: tuple[str, ...], phase: float, step: float | None
) -> tuple[Swept, list[Assembly]]:
    """What is asked, and the model at each value, stepped alike."""
    text = dump(mechanism)
    models = [loads(text, set=[(path, float(value))]) for value in values]
    faults = []
    if turn_of(mechanism) is None:
        faults.append(Fault("driver", "no crank turns at constant speed, so there is no turn to look at once", "", "", "drive a body"))
    if not 0 <= dropped < turns:
        faults.append(Fault("dropped", "no turn is left to look at", str(dropped), f"0 to {turns - 1}", "drop fewer turns"))
    if faults:
        raise ModelError(faults, mechanism.name)
    steps = step_count(models, step)
    every = [assemble(model, (turn_of(model) or 0.0) / steps, turns=1, outputs=1, force_step=True) for model in models]
    chosen = series or default_series(every[0])
    start = standing(every[0])
    known = list(start.series)
    wrong = [
        Fault("series", "the mechanism has none of this name", name, "", suggestion(name, known, "name one that it has"))
        for name in chosen
        if name not in known
    ]
    if wrong:
        raise ModelError(wrong, mechanism.name)
    units = tuple(unit_of(start, name) for name in chosen)
    return Swept(text, path, tuple(map(float, values)), turns, dropped, chosen, phase, steps, unit_at(mechanism, path), units), every


def unit_at(mechanism: Mechanism, path: str) -> str:
    """Unit of a number of the model; none where its place does not say it."""
    with suppress(ValueError):
        return value_at(mechanism, path)[1]
    return "SI"


def unit_of(start: View, series: str) -> str:
    """Unit of a series."""
    return start.channels[start.series.place(series)[0]].unit


def step_count(models: Sequence[Mechanism], step: float | None) -> int:
    """Steps in a turn, enough for both ends. Raises ModelError for a step that is too large for one of them."""
    counts = []
    for model in (models[0], models[-1]):
        if step is not None:
            refuse_large(model, step)
        size = prepare(model, Asked(turns=1.0, companions=0)).assembly.choice.step if step is None else step
        counts.append(math.ceil((turn_of(model) or 0.0) / size * (1.0 - 1e-9)))
    return max(counts)


def refuse_large(model: Mechanism, step: float) -> None:
    """Raises ModelError for a step that the model is not stable with."""
    try:
        assemble(model, step, turns=1.0, outputs=1)
    except StepError as error:
        limit = str(error).partition(": ")[2].partition(";")[0]
        raise ModelError([Fault("step", "this is not taken", f"{step:g} s", limit, "give another")], model.name) from None


def default_series(assembly: Assembly) -> tuple[str, ...]:
    """Where journals are in their bearings, and the largest force of a turn; without contacts the first link's speed."""
    joints = list(dict.fromkeys(assembly.contact_joints))
    if joints:
        return tuple(f"{joints[0]}.{what}" for what in ("penetration", "force_max"))
    return (f"{list(assembly.bodies)[-1]}.angular_velocity",)


def refuse(asked: Swept, every: Sequence[Assembly]) -> None:
    """Raises ModelError where the motion of one value cannot go on at the next."""
    for value, one in zip(asked.values, every, strict=True):
        why = carried_on(every[0], one)
        if why is not None:
            what = f"at {value:g} the mechanism is another than at {asked.values[0]:g}: {why()}"
            raise ModelError(
                [Fault(asked.path, what, "", "", "sweep play, a law, a mass, a load or the speed, or use vfife study")], one.mechanism.name
            )
    if choose_loop(every[0], "auto") != "generated":
        raise ModelError([Fault("body", "a frame of so many elements is not swept", "", "", "use fewer elements")], every[0].mechanism.name)


def neighbours(mechanism: Mechanism, asked: Swept, first: Assembly, chain: int) -> Neighbours:
    """The first model of a chain, a little to both sides; inside the range, so that both can be assembled."""
    low, high = asked.values[0], asked.values[-1]
    span = NEAR * (high - low)
    inner = asked.values[0] + span if chain == 0 else asked.values[-1] - 2.0 * span
    both = []
    for value in (inner + span, inner):
        model = loads(asked.model, set=[(asked.path, value)])
        both.append(assemble(model, (turn_of(model) or 0.0) / asked.steps, turns=1, outputs=1, force_step=True))
    return Neighbours(both[0], both[1], span)


def looked(asked: Swept, assemblies: Sequence[Assembly], kept: Any, rows: Array) -> Array:
    """What the series are once a turn, shape (turns, series, chains)."""
    found = np.zeros((len(rows), len(asked.series), len(assemblies)))
    for k, assembly in enumerate(assemblies):
        steps = np.arange(1, len(rows) + 1, dtype=np.int64) * asked.steps
        result = Result(Record(assembly, steps, rows[:, :, k], kept))
        for j, name in enumerate(asked.series):
            variable, entity, label = result.series.place(name)
            values = result.channels[variable].values
            place = entities(result.record)[entity].index(str(label)) if entity is not None else 0
            found[:, j, k] = values[:, place] if entity is not None else values
    return found


def drawn_together(name: str, asked: Swept, legs: Sequence[tuple[Array, Array]]) -> Bifurcation:
    """The diagram of legs; the chain that goes down has its values in the order of the way up."""
    count, looked_at = len(asked.values), asked.turns - asked.dropped
    points = {series: np.full((2, count, looked_at), np.nan) for series in asked.series}
    exponents, kinds = np.full((2, count, 3), np.nan), [[""] * count, [""] * count]
    for number, (values, growth) in enumerate(legs):
        shaped = values.reshape(looked_at, len(asked.series), 2)
        for k, place in enumerate((number, count - 1 - number)):
            for j, series in enumerate(asked.series):
                points[series][k, place] = shaped[:, j, k]
            found = exponent(growth[:, k])
            exponents[k, place] = found.value, found.low, found.high
            kinds[k][place] = kind(shaped[:, :, k], found)
    return Bifurcation(name, asked, points, exponents, (tuple(kinds[0]), tuple(kinds[1])), len(legs))


def opened(file: str | Path | None, asked: Swept, name: str) -> MapFile | None:
    """The file of a map: a new one, or one that asks the same. Raises VfifeError for one that asks something else."""
    if file is None:
        return None
    said = {"name": name, "asked": {key: list(value) if isinstance(value, tuple) else value for key, value in vars(asked).items()}}
    return MapFile.going_on(Path(file), said)
