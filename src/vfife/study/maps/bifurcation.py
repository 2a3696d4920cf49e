"""Bifurcation diagrams: a number swept up and down while the motion goes on, or each value begun anew; looked at once a turn, with the exponent by
which motions part."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...errors import Fault, ModelError
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...results.mapfile import MapFile
from ...solvers.orbits import Orbits, Start
from ...solvers.record import recorded_rows
from ...solvers.sweeping import Sweep, carried_on, side_by_side
from ...solvers.tangents import Neighbours
from ..nearby import nearby
from .beside import SAMPLE, Companion, carried_companions, packed, sampled, started_companions
from .diagram import WHAT, Bifurcation, Legs, Swept
from .looks import chosen_series, kept_in, left_out, models_along, refuse_idle, seed, step_count, stepped, unit_at
from .probe import looked, refuse_large_frame
from .starts import Starts, refuse_contradiction

Array = NDArray[np.float64]
Leg: TypeAlias = tuple[int, Array, Array, Array, list[Companion]]
NEAR = 1e-6  # of the range, by which the difference begins that is watched


def bifurcation(
    mechanism: Mechanism,
    path: str,
    low: float,
    high: float,
    *,
    count: int = 60,
    turns: int = 90,
    dropped: int | None = None,
    series: Sequence[str] = (),
    phase: float = 0.0,
    step: float | None = None,
    starts: Sequence[Mapping[str, float]] = (),
    companions: int = SAMPLE,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Bifurcation:
    """Sweeps the number at ``path`` from ``low`` to ``high`` (SI) and back in ``count`` values, the state carried on from one to the next.

    At each ``turns`` turns, of which ``dropped`` are not looked at, two thirds unless said. ``series``: what is looked at once a turn, by its name
    in ``result.series``; the penetration and the largest force of a contact, or a place or speed, that vary, unless said. ``step`` (s): the finest
    that a run of ten turns finds at both ends and in the middle, unless said; a turn has a whole number of them, the same for all values. With
    ``starts`` each value begins anew from each of them: ``{}`` is the model's own, ``{"start.crank": 1.57, "start.pin.x": 1e-4}`` another
    (:func:`~vfife.basins` says which numbers there are).
    ``companions``: so many values are gone through again, with 1.25 times and half the step. With a ``file`` what is known is kept in it after
    each value, and the same call goes on there. Ctrl-C leaves what is complete. Raises ModelError for a number that cannot be swept so, HeldError
    where another process writes the file.
    """
    asked, every = planned(mechanism, path, np.linspace(low, high, count), turns, left_out(dropped, turns), series, phase, step, starts, companions)
    refuse(asked, every)
    with kept_in(file, {"what": WHAT, "name": mechanism.name, "asked": asked}) as kept:
        known = Legs(asked) if kept is None else Legs.of(asked, kept)
        try:
            for number, points, growth, state, beside in (anew if starts else carried)(asked, every, known, kept):
                if kept is not None:
                    kept.array(f"beside {number}", packed(beside))
                    kept.keep(number, points, growth, state)
                known.add(number, points, growth, beside)
                if progress is not None:
                    progress(len(known.legs), known.count)
        except KeyboardInterrupt:
            if not known.legs:
                raise
    return known.diagram(mechanism.name)


def planned(
    mechanism: Mechanism, path: str, values: Array, turns: int, dropped: int, series: Sequence[str], phase: float, step: float | None,
    starts: Sequence[Mapping[str, float]], companions: int,
) -> tuple[Swept, list[Assembly]]:  # fmt: skip
    """What is asked, and the model at each value, stepped alike."""
    text = dump(mechanism)
    refuse_idle(mechanism, turns, dropped)
    for one in starts:
        refuse_contradiction(mechanism, (path, *one))
    steps = step_count(models_along(mechanism, ((path, float(values[0]), float(values[-1])),)), step, search=True)
    every = assembled(text, path, values.tolist(), steps)
    chosen, units = chosen_series(every[0], series)
    own = tuple(tuple(sorted((name, float(value)) for name, value in one.items())) for one in starts)
    unit = unit_at(mechanism, path)
    return Swept(text, path, tuple(map(float, values)), turns, dropped, chosen, phase, steps, unit, units, own, companions), every


def assembled(text: str, path: str, values: Sequence[float], steps: int) -> list[Assembly]:
    """The model of a text at each value, with so many steps in a turn: side by side, and those that have to be by themselves."""

    def alone(value: float) -> Assembly:
        return stepped(loads(text, set=[(path, value)]), steps)

    first, rest = alone(values[0]), values[1:]
    together = nearby(text, {path: values[0]}, [(path, value) for value in rest], first)
    return [first, *(alone(value) if one is None else one for value, one in zip(rest, together, strict=True))]


def refuse(asked: Swept, every: Sequence[Assembly]) -> None:
    """Raises ModelError where the motion of one value cannot go on at the next, or beside it."""
    for value, one in zip(asked.values, every, strict=True):
        why = side_by_side(every[0], one) if asked.starts else carried_on(every[0], one)
        if why is not None:
            what = f"at {value:g} the mechanism is another than at {asked.values[0]:g}: {why()}"
            remedy = "sweep play, a law, a mass, a load or the speed, or begin each value anew (--start own, starts=[{}])"
            raise ModelError([Fault(asked.path, what, "", "", "use vfife study" if asked.starts else remedy)], one.mechanism.name)
    refuse_large_frame(every[0])


def neighbours(asked: Swept, chain: int) -> Neighbours:
    """The first model of a chain, a little to both sides; inside the range, so that both can be assembled."""
    low, high = asked.values[0], asked.values[-1]
    span = NEAR * (high - low)
    inner = low + span if chain == 0 else high - 2.0 * span
    up, down = (stepped(loads(asked.model, set=[(asked.path, value)]), asked.steps) for value in (inner + span, inner))
    return Neighbours(up, down, span)


def carried(asked: Swept, every: list[Assembly], known: Legs, kept: MapFile | None) -> Iterator[Leg]:
    """The legs that are not known yet, their state carried on from value to value, with companions of some."""
    chains, there = [every, every[::-1]], len(known.legs)
    if there == len(every):
        return
    near, sample = [neighbours(asked, k) for k in range(len(chains))], sampled(len(every), asked.companions)

    def again(number: int, state: Array, done: int, look: Callable[[], None]) -> list[Companion]:
        if number not in sample or number < there:
            return []
        numbers, here = (number, len(every) - 1 - number), [chain[number] for chain in chains]
        return carried_companions(numbers, here, near, state, done, asked.turns, asked.dropped, asked.series, look)

    sweep = Sweep(chains, near, asked.phase, again)
    last = sweep.whole(there) - 1
    resume = None if kept is None or last < 0 else (last, kept.state(last).reshape(sweep.states.shape))
    for leg in sweep.legs(asked.turns, asked.dropped, resume):
        if leg.number >= there:
            here = [chain[leg.number] for chain in chains]
            points = [looked(one, sweep.kept, leg.rows[:, :, k], asked.series, asked.steps) for k, one in enumerate(here)]
            yield leg.number, np.stack(points, axis=2).reshape(len(leg.rows), -1), leg.growth, leg.state, leg.beside


def anew(asked: Swept, every: list[Assembly], known: Legs, kept: MapFile | None) -> Iterator[Leg]:
    """The legs that are not known yet, each from a start of its own; companions of some come before them, so that they are not missing then."""
    near, count = neighbours(asked, 0), len(every)
    if carried_on(every[0], near.up) is not None:  # pins move with the number: a difference by it would open the joints
        near = seed(every[0].mechanism, every[0], asked.steps)

    def made(number: int, steps: int) -> Start:
        numbers, model = dict(asked.starts[number // count]), every[number % count]
        starts = Starts(model.mechanism, steps)
        own = not numbers and steps == asked.steps
        return Start(number, (lambda: model) if own else partial(starts.at, numbers), starts.ahead(numbers, asked.phase))

    length = asked.turns, asked.dropped
    beside: dict[int, list[Companion]] = {number: [] for number in sampled(known.count, asked.companions) if number not in known.legs}
    for own in started_companions(tuple(beside), made, asked.steps, *length, near, asked.series):
        beside[own.number].append(Companion(own.number % count, own.number // count, own.ratio, own.kind))
    for one in Orbits(asked.steps, *length, near).each([made(number, asked.steps) for number in range(known.count)], tuple(known.legs)):
        if one.assembly is None:
            raise ModelError([Fault("starts", one.why)], every[0].mechanism.name)
        points = looked(one.assembly, recorded_rows(one.assembly), one.rows, asked.series, asked.steps)
        yield one.number, points, one.growth, np.zeros(0), beside.get(one.number, [])
