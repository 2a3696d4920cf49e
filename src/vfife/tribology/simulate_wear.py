"""Simulate the wear of joints over many turns: blocks of turns, jumps between them, the wear file, and the
error of the step in the rates.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..dynamics.section_series import kept_as, step_count
from ..errors import Fault, ModelError, RunFileError
from ..job.amounts import span
from ..job.cost import Forecast, timed_step
from ..job.job import Job, job_of
from ..measures.catalogue import largest_loads
from ..measures.wear import PLACES
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..solvers.interrupts import Interrupts
from ..solvers.record import Record
from ..solvers.status import Progress
from ..solvers.transient import choose_loop
from ..solvers.turn_runner import WearRunner, restepped
from ..store.mapfile import WearFile, WearPoint
from ..store.store import warn_of_damage
from .jumps import GROW, LEAST, Standing, between, jumps
from .wear_state import (
    Surface,
    WearSpec,
    Worn,
    plays,
    rates,
    shaped,
    sharpness,
    smooth,
    surfaces_of,
    swing,
    worn_of,
)

Array = NDArray[np.float64]
FINER = 2  # times as many steps in a turn


def beside(
    asked: WearSpec, surfaces: Sequence[Surface], blocks: WearRunner, rate: Array, halt: Interrupts
) -> tuple[float, float]:
    """How far rates of wear are apart from ``rate`` with half the step: of the volume of all surfaces, and of
    the deepest place of any, as shares.

    Both begin with the state that ``blocks`` are in; what their turns leave open by themselves is in it.
    """
    model, turn = blocks.assembly.mechanism, blocks.assembly.choice.turn or 0.0
    other = assemble(model, turn / (FINER * asked.steps), turns=1, outputs=PLACES, force_step=True)
    again = WearRunner(other, PLACES, halt)
    state = blocks.state
    again.restore(*restepped(state[:-1], int(state[-1]), other))
    again.shape(*(state[rows] for rows in blocks.harmonics))
    found, _ = rates(again.block(asked.settle, asked.block), surfaces, asked.block)
    whole, largest = float(rate.sum()), float(np.abs(around(asked, rate)).max())
    apart = abs(float(found.sum()) / whole - 1.0) if whole > 0.0 else 0.0
    return apart, float(np.abs(around(asked, found - rate)).max()) / largest if largest > 0.0 else 0.0


def around(asked: WearSpec, rate: Array) -> Array:
    """Rates as the geometry follows them."""
    return smooth(rate, max(asked.harmonics, 1))


MOST_BLOCKS = 10**7
REACH = 0.04  # of the clearance, by which no jump goes further
FIRST = 0.01  # of the clearance, by which the first goes


def wear(
    mechanism: Mechanism,
    turns: float,
    *,
    block: int = 4,
    settle: int = 4,
    tolerance: float = 0.01,
    harmonics: int = 8,
    clearance: float | None = None,
    force: float | None = None,
    step: float | None = None,
    file: str | Path | None = None,
    progress: Callable[[float, float, int], None] | Job | None = None,
    confirm: bool = False,
) -> Worn:
    """Wears the joints that have a table ``wear`` for so many ``turns`` of the crank, or until a limit.

    The rate of wear is that of ``block`` turns, after ``settle`` turns that nobody looks at. A jump errs by
    ``tolerance`` of the smallest clearance at the most; what the step does to the rates is told by the last
    block again with half of it. The clearance follows the worn profiles by so many ``harmonics`` (1: their
    mean; 0: not at all). ``clearance`` (m) and ``force`` (N) are limits that end a life: play of a joint, by
    the deepest places of its surfaces, and the largest force of one. ``step`` (s): the automatic one unless
    said. With a ``file`` every jump is kept in it, and the same call goes on there. Ctrl-C leaves what is
    complete. ``confirm``: go on even where the first block shows that it takes more than an hour. Raises
    ModelError for a mechanism that does not wear so, HeldError where another process writes the file.
    """
    asked = WearSpec(dump(mechanism), float(turns), block, settle, tolerance, harmonics, clearance, force)
    surfaces = wearing_surfaces(mechanism, asked)
    asked = dataclasses.replace(asked, steps=-(-step_count([mechanism], step) // PLACES) * PLACES)
    began, points, apart = time.monotonic(), list[WearPoint](), tuple[float, ...]()
    new = file is not None and not Path(file).exists()
    report: Any = progress
    job = job_of(
        "wear", file, confirm, progress, lambda one: report(one.done, one.steps, round(wearing.blocks.turns))
    )
    try:
        with (
            job,
            kept_as(WearFile, file, {"name": mechanism.name, "asked": asked}, "this wear") as kept,
            Interrupts() as halt,
        ):
            points, apart = ([], ()) if kept is None else (kept.points(), kept.companion_difference)
            wearing = WearSimulation(mechanism, asked, surfaces, halt)
            known = points[-1].told["turns"] if points else 0.0
            if points:
                job.begin(wearing.forecast(points[-1], file))
            for point in wearing.points(
                points, None if kept is None or not points else kept.state(len(points) - 1)
            ):
                if not points:
                    job.begin(wearing.forecast(point, file))
                if kept is not None:
                    kept.write_row(
                        "points", len(points), point.told, point.depth, point.rate, wearing.blocks.state
                    )
                points.append(point)
                job(wearing.progress(point.told["turns"], known, time.monotonic() - began))
            if not apart:
                apart = beside(asked, surfaces, wearing.blocks, points[-1].rate, halt)
                if kept is not None:
                    kept.write_row("meta", "beside", list(apart))
    except KeyboardInterrupt:
        if not points:
            raise
    finally:
        if new and not points:
            Path(str(file)).unlink(missing_ok=True)
    return worn_of(mechanism.name, asked, points, apart)


def load_wear(path: str | Path) -> Worn:
    """The wear in a wear file, as far as it is known. Raises RunFileError for any other file."""
    with WearFile.open(Path(path)) as file:
        said, points, apart = file.spec, file.points(), file.companion_difference
    again = "Give the command that made it again: it computes what is gone."
    if not points:
        why = (
            f"this wear file is damaged: {'; '.join(file.damage)}"
            if file.damage
            else "no point of this wear is known so far"
        )
        raise RunFileError(f"{path}: {why}. {again}")
    warn_of_damage(Path(path), "wear", file.damage, again)
    return worn_of(said["name"], WearSpec(**said["asked"]), points, apart)


def wearing_surfaces(mechanism: Mechanism, asked: WearSpec) -> list[Surface]:
    """The surfaces that wear. Raises ModelError with all that is wrong with them or with what is asked."""
    surfaces, faults = surfaces_of(mechanism), []
    if turn_of(mechanism) is None:
        faults.append(
            Fault(
                "driver",
                "no crank turns at constant speed, so there are no turns to count",
                "",
                "",
                "drive a body",
            )
        )
    if not surfaces:
        what = "no journal in a bearing wears: there is no coefficient above zero"
        faults.append(
            Fault(
                "joint",
                what,
                "",
                "",
                'give a joint with clearance a table wear, as in wear = { bearing = "1e-15 1/Pa" }',
            )
        )
    for name, low in (("turns", 1.0), ("block", 1), ("settle", 1), ("harmonics", 0)):
        if not (value := getattr(asked, name)) >= low:
            faults.append(Fault(name, "too small", f"{value:g}", f"at least {low:g}", "give more"))
    if not 0.0 < asked.tolerance <= 1.0:
        faults.append(
            Fault(
                "tolerance",
                "out of range",
                f"{asked.tolerance:g}",
                "a share above 0 and up to 1",
                "for example 0.01",
            )
        )
    largest = max((surface.clearance for surface in surfaces), default=0.0)
    if not faults and asked.clearance is not None and asked.clearance <= largest:
        what = "a joint has as much play from the start"
        faults.append(
            Fault("clearance", what, f"{asked.clearance:g} m", f"above {largest:g} m", "give a larger limit")
        )
    if faults:
        raise ModelError(faults, mechanism.name)
    return surfaces


class WearSimulation:
    """Wear under way: the blocks, and what becomes of the depths that they tell."""

    def __init__(
        self, mechanism: Mechanism, asked: WearSpec, surfaces: list[Surface], halt: Interrupts
    ) -> None:
        self.asked, self.surfaces = asked, surfaces
        model = shaped(mechanism, surfaces, asked.harmonics)
        turn = turn_of(model) or 0.0
        assembly = assemble(model, turn / asked.steps, turns=1, outputs=PLACES, force_step=True)
        if choose_loop(assembly, "auto") != "generated":
            raise ModelError(
                [
                    Fault(
                        "body",
                        "a frame of so many elements is not followed so far",
                        "",
                        "",
                        "use fewer elements",
                    )
                ],
                model.name,
            )
        self.blocks = WearRunner(assembly, PLACES, halt)
        self.told: dict[str, Any] = {}
        self.clearance = min(surface.clearance for surface in surfaces)

    def measure(self, change: Array) -> float:
        """How large a change of depths is: that of the deepest place, as the geometry follows it."""
        return float(np.abs(smooth(change, max(self.asked.harmonics, 1))).max())

    def rate(self, depth: Array) -> Array:
        """Depth (m) that a turn takes at each place of all surfaces, once they are so deep."""
        if self.asked.harmonics:
            self.blocks.shape(*swing(self.surfaces, depth, self.asked.harmonics, self.blocks.assembly))
        record = self.blocks.block(self.asked.settle, self.asked.block)
        found, spread = rates(record, self.surfaces, self.asked.block)
        self.told = {"spread": spread, "force": loads(record, self.surfaces)}
        return found

    def points(self, known: list[WearPoint], state: Array | None) -> Iterator[WearPoint]:
        """Points after those that are known, up to the end of the turns or of a life."""
        asked, joints = self.asked, list(dict.fromkeys(surface.joint for surface in self.surfaces))
        if known and state is not None:
            self.blocks.restore(state[:-1], int(state[-1]))
            told = known[-1].told
            if told["ended"]:
                return
            here, last = Standing(told["turns"], known[-1].depth, known[-1].rate, told["next"]), told
        else:
            depth = np.zeros((len(self.surfaces), PLACES))
            rate = self.rate(depth)
            change = self.measure(rate)
            here = Standing(
                0.0, depth, rate, FIRST * self.clearance / change if change > 0.0 else asked.turns
            )
            last = self.say(here, joints)
            last["ended"] = over(asked, last, None)
            yield WearPoint(here.depth, here.rate, last)
        tolerance, reach = (
            share * self.clearance for share in (asked.tolerance, REACH if asked.harmonics else np.inf)
        )
        if last["ended"]:
            return
        for there in jumps(self.rate, here, asked.turns, tolerance, self.measure, reach):
            there = self.cut(here, there)
            told = self.say(there, joints)
            told["ended"] = over(asked, told, last)
            yield WearPoint(there.depth, there.rate, told)
            if told["ended"]:
                return
            here, last = there, told

    def forecast(self, point: WearPoint, file: str | Path | None) -> Forecast:
        """The forecast of what is left after a point: jumps at its rate, each with a block in the middle and
        one at its end.
        """
        asked, told = self.asked, point.told
        blocks, size, left = 2 * FINER, float(told["next"]), asked.turns - told["turns"]
        reach = (
            REACH * self.clearance / max(self.measure(point.rate), 1e-300) if asked.harmonics else math.inf
        )
        while left > 0.0 and not told["ended"] and blocks < MOST_BLOCKS:
            size = min(max(size, LEAST), reach)
            left, size, blocks = left - size, GROW * size, blocks + 2
        steps = (asked.settle + asked.block) * asked.steps
        seconds = timed_step(self.blocks.assembly) * steps * blocks
        count = 0 if told["ended"] else blocks
        limited = "" if asked.clearance is None and asked.force is None else ", less where a limit is reached"
        return Forecast("block", count, steps, seconds, disk=16.0 * point.depth.size * blocks, less="ask for fewer turns or smaller blocks",
                        note=f", if wear goes on as in its first block{limited}")  # fmt: skip

    def progress(self, turns: float, known: float, seconds: float) -> Progress:
        """Where the wear stands: ``turns`` of which ``known`` ones were in the file."""
        asked, gone = self.asked, turns - known
        most = "" if asked.clearance is None and asked.force is None else "at most "
        left = (
            f", {most}{span(seconds * (asked.turns - turns) / gone)} left"
            if gone > 0.0 and turns < asked.turns
            else ""
        )
        text = f"{turns:,.0f} of {asked.turns:,.0f} turns, {self.blocks.turns:,.0f} simulated{left}"
        return Progress(turns, asked.turns, seconds, text)  # type: ignore[arg-type]

    def cut(self, here: Standing, there: Standing) -> Standing:
        """The jump, ended where a joint reaches the limit of play in it."""
        limit = self.asked.clearance
        if (
            limit is None
            or there.after is None
            or max(plays(self.surfaces, there.depth, self.asked.harmonics)) < limit
        ):
            return there
        low, high = 0.0, 1.0
        for _ in range(50):
            middle = 0.5 * (low + high)
            reached = (
                max(
                    plays(self.surfaces, between(here, middle, there.size, there.after), self.asked.harmonics)
                )
                >= limit
            )
            low, high = (low, middle) if reached else (middle, high)
        depth = between(here, high, there.size, there.after)
        return dataclasses.replace(
            there,
            turns=here.turns + high * there.size,
            depth=depth,
            rate=self.rate(depth),
            size=high * there.size,
        )

    def say(self, one: Standing, joints: list[str]) -> dict[str, Any]:
        """What a point tells beside its depths."""
        play = plays(self.surfaces, one.depth, self.asked.harmonics)
        return self.told | {
            "turns": one.turns, "next": one.next, "size": one.size, "error": one.error, "refused": one.refused, "joints": joints, "play": play,
            "sharp": sharpness(self.surfaces, one.depth, self.asked.harmonics), "simulated": self.blocks.turns,
        }  # fmt: skip


def over(asked: WearSpec, told: dict[str, Any], last: dict[str, Any] | None) -> dict[str, Any]:
    """Why a life ends here, after how many turns; nothing where it does not. Between two points a force
    changes evenly.
    """
    for joint, play, force in zip(told["joints"], told["play"], told["force"], strict=True):
        if asked.clearance is not None and play >= asked.clearance * (1.0 - 1e-9):
            return {"turns": told["turns"], "joint": joint, "by": "clearance"}
        if asked.force is not None and force >= asked.force:
            before = 0.0 if last is None else last["force"][told["joints"].index(joint)]
            share = 1.0 if last is None else (asked.force - before) / (force - before)
            begin = told["turns"] if last is None else last["turns"]
            return {"turns": begin + share * (told["turns"] - begin), "joint": joint, "by": "force"}
    return {}


def loads(record: Record, surfaces: list[Surface]) -> list[float]:
    """Largest force (N) of each joint that wears, over a record."""
    window = np.arange(len(record.steps)) > 0
    found = largest_loads(record, window)
    return [found[f"{name}.force.max"] for name in dict.fromkeys(surface.joint for surface in surfaces)]
