"""Simulate the wear of joints over many turns: blocks of simulated turns, jumps between them, the wear file,
and the effect of the step on the rates.

Wear of a turn is far smaller than the clearance, so a block of turns is simulated with constant profiles and
gives a rate; :mod:`~vfife.tribology.jumps` integrates the rate over thousands of turns. A block begins in the
state in which the last one ended, and its first turns are not counted, because the motion adapts to the new
profiles first.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterator, Sequence
from numbers import Real
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..errors import Fault, ModelError, RunFileError
from ..job.cost import Forecast, timed
from ..job.job import Job, job_of
from ..job.progress import span
from ..laws.materials import EXAMPLE_COEFFICIENT
from ..measures.catalogue import largest_loads
from ..measures.wear import PLACES
from ..model.functions import crank_faults, turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..options import with_faults, with_options
from ..simulation.turn_steps import step_count
from ..solvers.arguments import Arguments
from ..solvers.interrupts import Interrupts
from ..solvers.record import Record
from ..solvers.status import Progress
from ..solvers.transient import choose_loop
from ..solvers.turn_runner import WearRunner, restepped
from ..store.connections import warn_of_damage
from ..store.studyfile import WearFile, WearPoint, locked_file
from .jumps import GROW, SHORTEST_JUMP, Standing, depth_within, jumps
from .wear_state import (
    Surface,
    WearSpec,
    Worn,
    clearances,
    harmonics_of,
    largest_change,
    life_end,
    rates,
    shaped,
    sharpness,
    surfaces_of,
    wear_result,
    with_wear,
)

Array = NDArray[np.float64]
FINER = 2  # ratio of the steps in a turn, for the effect of the step
MOST_BLOCKS = 10**7  # of a forecast: it stops counting there
REVISED = 1.5  # ratio of two forecasts from which on the second one is announced too
# Largest change of a depth in a jump, and that in the first jump, as shares of the smallest clearance.
REACH = 0.04
FIRST = 0.01


class WearOptions(TypedDict, total=False):
    """Keywords of a wear simulation: the fields of :class:`WearSpec` that have defaults."""

    block: int
    settle: int
    tolerance: float
    harmonics: int
    clearance: float | None
    force: float | None


@with_options(
    WearOptions,
    **{
        field.name: field.default
        for field in dataclasses.fields(WearSpec)
        if field.name in WearOptions.__annotations__
    },
)
def wear(
    mechanism: Mechanism, turns: float, *, step: float | None = None, file: str | Path | None = None,
    progress: Callable[[float, float, int], None] | Job | None = None, confirm: bool = False,
    wear: float | str | None = None, **options: Unpack[WearOptions],
) -> Worn:  # fmt: skip
    """Simulate the wear of the joints that have a table ``wear`` over many turns of the crank, or until a
    limit ends their life.

    mechanism: the mechanism
    turns: of the crank
    step: time step (s), automatic by default
    file: stores every jump; the same call continues it
    progress: ``progress(turns, all, simulated)`` is called after each jump
    confirm: True permits work for which the first turns forecast more than an hour
    wear: coefficient (1/Pa) or pair of materials for joints without a table ``wear``
    options: the keywords below

    block: number of turns over which the rate of wear is averaged (4)
    settle: number of turns before each block that are not counted (4)
    tolerance: error of a jump, at most, as a share of the smallest clearance (0.01)
    harmonics: of the worn profiles that the contact geometry follows (8; 1: their mean only; 0: none)
    clearance: limit of a joint's clearance (m), measured at the deepest places of its smoothed profiles
    force: limit of the largest force in a joint (N)

    The effect of the step on the rates is found by repeating the last block with half the step. Returns the
    wear; after Ctrl-C as far as it is complete. Raises ModelError for a mechanism whose wear cannot be
    simulated, HeldError if another process writes the file.
    """
    arguments = Arguments("wear")
    arguments.mechanism(mechanism)
    arguments.kind("turns", turns, (Real,), "a number above 0")
    arguments.check()
    mechanism = with_wear(mechanism, wear, "wear()")
    spec = WearSpec(dump(mechanism), float(turns), **options)
    surfaces = wearing_surfaces(mechanism, spec)
    spec = dataclasses.replace(spec, steps=-(-step_count([mechanism], step) // PLACES) * PLACES)
    began, points, difference = time.monotonic(), list[WearPoint](), tuple[float, ...]()
    new = file is not None and not Path(file).exists()
    report: Any = progress
    job = job_of(
        "wear",
        file,
        confirm,
        progress,
        lambda state: report(state.done, spec.turns, round(simulation.blocks.turns)),
    )
    document = {"name": mechanism.name, "asked": vars(spec)}
    try:
        with job, locked_file(WearFile, file, document, "this wear") as store, Interrupts() as interrupts:
            if store is not None:
                points, difference = store.points(), store.companion_difference
            simulation = WearSimulation(mechanism, spec, surfaces, interrupts)
            announced = simulation.forecast(points[-1] if points else simulation.pilot(), file)
            job.begin(announced)
            for point in simulation.points(
                points, None if store is None or not points else store.state(len(points) - 1)
            ):
                if not points and differs(forecast := simulation.forecast(point, file), announced):
                    job.begin(forecast)
                if store is not None:
                    store.write_row(
                        "points", len(points), point.numbers, point.depth, point.rate, simulation.blocks.state
                    )
                points.append(point)
                job(simulation.progress(point, time.monotonic() - began))
            if not difference:
                difference = step_difference(spec, surfaces, simulation.blocks, points[-1].rate, interrupts)
                if store is not None:
                    store.write_row("meta", "beside", list(difference))
    except KeyboardInterrupt:
        if not points:
            raise
        job.interrupted()
    finally:
        if new and not points:
            Path(str(file)).unlink(missing_ok=True)
    return wear_result(mechanism.name, spec, points, difference)


def wear_forecast(mechanism: Mechanism, turns: float, clearance: float) -> Forecast:
    """Return the forecast of :func:`wear` up to a ``clearance`` (m), from two turns of the new mechanism.
    Raises ModelError for a mechanism whose wear cannot be simulated.
    """
    spec = WearSpec(dump(mechanism), float(turns), clearance=clearance)
    surfaces = wearing_surfaces(mechanism, spec)
    spec = dataclasses.replace(spec, steps=-(-step_count([mechanism], None) // PLACES) * PLACES)
    with Interrupts() as interrupts:
        simulation = WearSimulation(mechanism, spec, surfaces, interrupts)
        return simulation.forecast(simulation.pilot(), None)


def step_difference(
    spec: WearSpec, surfaces: Sequence[Surface], blocks: WearRunner, rate: Array, interrupts: Interrupts
) -> tuple[float, float]:
    """Return the relative differences (1) between ``rate`` and the rate with half the step: of the volume of
    all surfaces, and of the deepest place.

    The repetition begins in the state of ``blocks``, after the block that gave ``rate``: the scatter between
    blocks is part of the difference.
    """
    assembly = blocks.assembly
    fine = assemble(
        assembly.mechanism,
        (assembly.choice.turn or 0.0) / (FINER * spec.steps),
        turns=1,
        outputs=PLACES,
        force_step=True,
    )
    repetition, state = WearRunner(fine, PLACES, interrupts), blocks.state
    repetition.restore(*restepped(state[:-1], int(state[-1]), fine))
    repetition.shape(*(state[rows] for rows in blocks.harmonics))
    fine_rate, _ = rates(repetition.block(spec.settle, spec.block), surfaces, spec.block)
    volume, deepest = float(rate.sum()), largest_change(rate, spec.harmonics)
    return (
        abs(float(fine_rate.sum()) / volume - 1.0) if volume > 0.0 else 0.0,
        largest_change(fine_rate - rate, spec.harmonics) / deepest if deepest > 0.0 else 0.0,
    )


@with_faults()
def load_wear(path: str | Path) -> Worn:
    """Return the wear of a wear file, as far as it is computed.

    path: the wear file

    Raises RunFileError for any other file.
    """
    with WearFile.open(path) as file:
        stored, points, difference = file.spec, file.points(), file.companion_difference
    remedy = "Repeat the command that made it: it computes the missing points."
    if not points:
        reason = (
            f"this wear file is damaged: {'; '.join(file.damage)}"
            if file.damage
            else "no point of this wear is complete so far"
        )
        raise RunFileError(f"{path}: {reason}. {remedy}")
    warn_of_damage(Path(path), "wear", file.damage, remedy)
    return wear_result(stored["name"], WearSpec(**stored["asked"]), points, difference)


def wearing_surfaces(mechanism: Mechanism, spec: WearSpec) -> list[Surface]:
    """Return the surfaces that wear. Raises ModelError with all faults of the mechanism and the
    specification.
    """
    surfaces, faults = surfaces_of(mechanism), crank_faults(mechanism, "there are no turns to count")
    if not surfaces:
        message = "no joint has a wear coefficient above zero, so nothing wears"
        table = f'wear = {{ bearing = "{EXAMPLE_COEFFICIENT}" }}'
        faults.append(
            Fault(
                "joint",
                message,
                "",
                "",
                f"give a joint with clearance a table wear, as in {table}, or all of them a coefficient, as"
                f' in --wear "{EXAMPLE_COEFFICIENT}" (wear=... in Python)',
            )
        )
    for name, low in (("turns", 1.0), ("block", 1), ("settle", 1), ("harmonics", 0)):
        if not (value := getattr(spec, name)) >= low:
            faults.append(Fault(name, "too small", f"{value:g}", f"at least {low:g}", "give more"))
    if not 0.0 < spec.tolerance <= 1.0:
        faults.append(
            Fault(
                "tolerance",
                "out of range",
                f"{spec.tolerance:g}",
                "a share above 0 and up to 1",
                "for example 0.01",
            )
        )
    largest = max((surface.clearance for surface in surfaces), default=0.0)
    if not faults and spec.clearance is not None and spec.clearance <= largest:
        message = "a joint has as much clearance at the start"
        faults.append(
            Fault(
                "clearance", message, f"{spec.clearance:g} m", f"above {largest:g} m", "give a larger limit"
            )
        )
    if faults:
        raise ModelError(faults, mechanism.name)
    return surfaces


class WearSimulation:
    """A wear simulation: blocks of turns, which give rates, and jumps between them.

    ``block_numbers`` are the scatter of the rate and the largest forces in the last simulated block.
    """

    def __init__(
        self, mechanism: Mechanism, spec: WearSpec, surfaces: list[Surface], interrupts: Interrupts
    ) -> None:
        self.mechanism, self.spec, self.surfaces, self.interrupts = mechanism, spec, surfaces, interrupts
        model = shaped(mechanism, surfaces, spec.harmonics)
        turn = turn_of(model) or 0.0
        assembly = assemble(model, turn / spec.steps, turns=1, outputs=PLACES, force_step=True)
        if choose_loop(assembly, "auto") != "generated":
            raise ModelError(
                [
                    Fault(
                        "body",
                        "wear is not simulated for frames of so many elements",
                        "",
                        "",
                        "use fewer elements",
                    )
                ],
                model.name,
            )
        self.blocks = WearRunner(assembly, PLACES, interrupts)
        self.turn_seconds = 0.0  # processor time of a turn, once it is timed
        self.block_numbers: dict[str, Any] = {}
        self.pace_start: tuple[float, float] | None = None  # simulated turns, time (s) of the first progress
        self.clearance = min(surface.clearance for surface in surfaces)

    def measure(self, change: Array) -> float:
        """Return the size (m) of a change of depths."""
        return largest_change(change, self.spec.harmonics)

    def rate(self, depth: Array) -> Array:
        """Simulate a block with surfaces of this ``depth`` (m); return the depth (m) lost in a turn at each
        place, shape (surfaces, places).
        """
        if self.spec.harmonics:
            self.blocks.shape(*harmonics_of(self.surfaces, depth, self.spec.harmonics, self.blocks.assembly))
        record = self.blocks.block(self.spec.settle, self.spec.block)
        rate, spread = rates(record, self.surfaces, self.spec.block)
        self.block_numbers = {"spread": spread, "force": largest_forces(record, self.surfaces)}
        return rate

    @property
    def unworn(self) -> Array:
        """Depths of zero (m) at all places, shape (surfaces, places)."""
        return np.zeros((len(self.surfaces), PLACES))

    def start(self, rate: Array) -> Standing:
        """Return the point without wear, whose first jump follows from its ``rate``."""
        change = self.measure(rate)
        return Standing(
            0.0, self.unworn, rate, FIRST * self.clearance / change if change > 0.0 else self.spec.turns
        )

    def pilot(self) -> WearPoint:
        """Return the point without wear with the rate of the second turn, for a forecast before the first
        block; time turns with the wear of the first jump, because worn surfaces take up to 1.5 times as long.
        These turns have a runner of their own, so that the bits of the blocks do not depend on them.
        """
        pilot = WearSimulation(self.mechanism, self.spec, self.surfaces, self.interrupts)
        pilot.spec = dataclasses.replace(self.spec, settle=1, block=1)
        start = pilot.start(pilot.rate(self.unworn))
        self.turn_seconds = timed(lambda: pilot.rate(start.rate * start.next)) / 2.0
        return WearPoint(start.depth, start.rate, {"turns": 0.0, "next": start.next, "ended": {}})

    def points(self, former: list[WearPoint], state: Array | None) -> Iterator[WearPoint]:
        """Yield the points after the ``former`` ones, up to the last turn or the end of a life; ``state`` is
        that of the last former point, shape (rows + 1,), with its number of steps at the end.
        """
        spec, joints = self.spec, list(dict.fromkeys(surface.joint for surface in self.surfaces))
        if former and state is not None:
            self.blocks.restore(state[:-1], int(state[-1]))
            numbers = former[-1].numbers
            if numbers["ended"]:
                return
            start = Standing(numbers["turns"], former[-1].depth, former[-1].rate, numbers["next"])
            last = numbers
        else:
            start = self.start(self.rate(self.unworn))
            last = self.row(start, joints)
            last["ended"] = life_end(spec, last, None)
            yield WearPoint(start.depth, start.rate, last)
        tolerance = spec.tolerance * self.clearance
        if last["ended"]:
            return
        for end in jumps(self.rate, start, spec.turns, tolerance, self.measure, self.reach):
            end = self.limited(start, end)
            numbers = self.row(end, joints)
            numbers["ended"] = life_end(spec, numbers, last)
            yield WearPoint(end.depth, end.rate, numbers)
            if numbers["ended"]:
                return
            start, last = end, numbers

    def forecast(self, point: WearPoint, file: str | Path | None) -> Forecast:
        """Return the forecast of what remains after a point, if wear continues at its rate, which reaches a
        limit of the clearance where there is one. With a limit, the time lies between that of the fastest
        wear that jumps permit and that of all turns.
        """
        spec, numbers, turns = self.spec, point.numbers, self.spec.settle + self.spec.block
        if not (self.turn_seconds or numbers["ended"]):
            self.pilot()
        end = self.expected_end(point)
        blocks, all_blocks = self.blocks_to(point, end), self.blocks_to(point, spec.turns)
        fewest = min(FINER + 2 * self.fewest_jumps(point), blocks)
        block = self.turn_seconds * turns  # s
        is_limited = spec.clearance is not None or spec.force is not None
        limited = ", less where a limit is reached" if is_limited else ""
        if blocks < all_blocks:
            limited = f", up to {span(block * all_blocks)} if it slows down and no limit is reached"
        return Forecast(
            "block", 0 if numbers["ended"] else blocks, turns * spec.steps, block * blocks,
            disk=16.0 * point.depth.size * blocks, remedy="ask for fewer turns or smaller blocks",
            note=f", if wear goes on as in its first turns{limited}",
            ends=(block * fewest, block * all_blocks) if is_limited else None,
        )  # fmt: skip

    def blocks_to(self, point: WearPoint, end: float) -> int:
        """Return the blocks that remain after a point until ``end`` (turns) at its rate: jumps that grow as
        fast as the control permits, each with one block for Euler's step and one at its end, and one block
        with finer steps.
        """
        numbers = point.numbers
        blocks, size, left = FINER, float(numbers["next"]), end - numbers["turns"]
        reach = self.reach / max(self.measure(point.rate), 1e-300)
        while left > 0.0 and not numbers["ended"] and blocks < MOST_BLOCKS:
            size = min(max(size, SHORTEST_JUMP), reach)
            left, size, blocks = left - size, GROW * size, blocks + 2
        return blocks

    @property
    def reach(self) -> float:
        """Largest change of a depth in a jump (m)."""
        return REACH * self.clearance if self.spec.harmonics else math.inf

    def fewest_jumps(self, point: WearPoint) -> int:
        """Return the fewest jumps to a limit: both surfaces of a joint change by :attr:`reach` at most. A
        force may reach its limit in one.
        """
        spec = self.spec
        if spec.clearance is None or spec.force is not None:
            return 1
        largest = max(clearances(self.surfaces, point.depth, spec.harmonics))
        return max(1, math.ceil((spec.clearance - largest) / (2.0 * self.reach)))

    def expected_end(self, point: WearPoint) -> float:
        """Return the turns, at most all, at which a clearance reaches its limit at the rate of a point."""
        spec, turns = self.spec, float(point.numbers["turns"])
        left = spec.turns - turns
        if spec.clearance is None or left <= 0.0 or not self.is_beyond(point.depth + left * point.rate):
            return spec.turns
        return turns + left * self.limit_share(lambda share: point.depth + share * left * point.rate)

    def is_beyond(self, depth: Array) -> bool:
        """Return whether surfaces of this ``depth`` (m) have the limit of the clearance or more."""
        limit = self.spec.clearance
        return limit is not None and max(clearances(self.surfaces, depth, self.spec.harmonics)) >= limit

    def limit_share(self, depth: Callable[[float], Array]) -> float:
        """Return the share (1) of a way at whose ``depth`` (m) a joint reaches the limit of its clearance, by
        bisection. Fifty halvings leave nothing but rounding.
        """
        low, high = 0.0, 1.0
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.is_beyond(depth(middle)) else (middle, high)
        return high

    def progress(self, point: WearPoint, seconds: float) -> Progress:
        """Return the progress at a ``point`` after ``seconds`` (s), with the time that is left by the blocks
        that remain and the time of those since the first call.
        """
        spec, turns, simulated = self.spec, point.numbers["turns"], self.blocks.turns
        end, left = turns if point.numbers["ended"] else self.expected_end(point), ""
        if self.pace_start is None:
            self.pace_start = simulated, seconds
        turns_before, seconds_before = self.pace_start
        if simulated > turns_before and turns < end:
            pace = (seconds - seconds_before) / (simulated - turns_before)
            time_left = span(pace * (spec.settle + spec.block) * self.blocks_to(point, end))
            may_end = spec.force is not None or (spec.clearance is not None and end >= spec.turns)
            left = f", {'at most ' if may_end else ''}about {time_left} left"
        text = f"{turns:,.0f} of {spec.turns:,.0f} turns, {simulated:,.0f} simulated{left}"
        return Progress(turns, end or spec.turns, seconds, text)  # type: ignore[arg-type]

    def limited(self, start: Standing, end: Standing) -> Standing:
        """Return the jump from ``start`` to ``end``, shortened to the turn at which a joint reaches the limit
        of its clearance.
        """
        end_rate = end.end_rate
        if end_rate is None or not self.is_beyond(end.depth):
            return end
        share = self.limit_share(lambda part: depth_within(start, part, end.size, end_rate))
        depth, size = depth_within(start, share, end.size, end_rate), share * end.size
        return dataclasses.replace(
            end, turns=start.turns + size, depth=depth, rate=self.rate(depth), size=size
        )

    def row(self, point: Standing, joints: list[str]) -> dict[str, Any]:
        """Return the numbers of a point, other than depths and rates, as they are stored."""
        clearance = clearances(self.surfaces, point.depth, self.spec.harmonics)
        return self.block_numbers | {
            "turns": point.turns, "next": point.next, "size": point.size, "error": point.error,
            "refused": point.refused, "joints": joints, "play": clearance,
            "sharp": sharpness(self.surfaces, point.depth, self.spec.harmonics),
            "simulated": self.blocks.turns,
        }  # fmt: skip


def differs(forecast: Forecast, former: Forecast) -> bool:
    """Return whether a forecast is so far from a former one that it is worth another line."""
    low, high = sorted((forecast.count, former.count))
    return high > REVISED * low


def largest_forces(record: Record, surfaces: list[Surface]) -> list[float]:
    """Return the largest force (N) in a record for each joint that wears."""
    window = np.arange(len(record.steps)) > 0
    largest = largest_loads(record, window)
    return [largest[f"{name}.force.max"] for name in dict.fromkeys(surface.joint for surface in surfaces)]
