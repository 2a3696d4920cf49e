"""Basins: to which motion each start comes, over a grid of two numbers of the start or of the model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError
from ..files import write_rows
from ..job.job import job_of
from ..measures.chaos import ALIKE_POINTS as ALIKE
from ..measures.chaos import Attractor, Verdict, attractors, exponent, verdict
from ..model.above import NotebookDocument
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..solvers.turn_runner import Start
from ..store.mapfile import MapFile
from .section_series import (
    START,
    TURNED_START,
    MapWork,
    chosen_series,
    kept_in,
    law_words,
    left_out,
    models_along,
    refuse_idle,
    refuse_large_frame,
    seed,
    step_count,
    tupled,
)
from .starts import Starts, refuse_contradiction, unit_of_start
from .step_check import (
    SAMPLE,
    Companion,
    alike,
    observed,
    packed,
    sampled,
    started_companions,
    told,
    unpacked,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 100, 30  # starts, turns of each
Range: TypeAlias = tuple[str, float, float]
WHAT, BESIDE = "basins", "beside"
OF_START = {"position", "angle", "velocity"}  # of a body: with what it begins


@dataclass(frozen=True)
class BasinSpec:
    """What is asked: two numbers by their ``paths``, with their ``units`` and values ``x`` and ``y``;
    ``turns``, the first of them ``dropped``; ``series`` at a ``phase`` (1) of the turn, of which there are so
    many ``steps``; ``exponents``: whether a small difference is watched; so many members have ``companions``.
    """

    model: str
    paths: tuple[str, str]
    units: tuple[str, str]
    x: tuple[float, ...]
    y: tuple[float, ...]
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    exponents: bool
    companions: int

    @property
    def count(self) -> int:
        """Members."""
        return len(self.x) * len(self.y)

    @property
    def varied(self) -> tuple[str, ...]:
        """The numbers that are of the model, not of a start: points of one motion move with them."""
        return tuple(
            path
            for path in self.paths
            if not path.startswith("start.") and OF_START.isdisjoint(path.split("."))
        )

    def numbers(self, member: int) -> dict[str, float]:
        """What a member begins with; members go along x first."""
        return {self.paths[0]: self.x[member % len(self.x)], self.paths[1]: self.y[member // len(self.x)]}


@dataclass(frozen=True)
class Basins(NotebookDocument):
    """What is known of each member by number: ``points`` once a turn, shape (turns, series), and ``growth``;
    no points where it has no start.
    """

    name: str
    asked: BasinSpec
    points: Mapping[int, Array]
    growth: Mapping[int, Array]
    companions: tuple[Companion, ...] = field(default=())

    @property
    def done(self) -> int:
        """Members that are known."""
        return len(self.points)

    @cached_property
    def verdicts(self) -> dict[int, Verdict]:
        """What the motions are, with their evidence; members without a start have none."""
        grown = {k: exponent(one) if len(one) > 1 else None for k, one in self.growth.items()}
        return {k: verdict(one, grown[k]) for k, one in sorted(self.points.items()) if len(one)}

    @cached_property
    def attractors(self) -> list[Attractor]:
        """The motions to which members come, that of most members first; over a number of the model those
        that are called the same.
        """
        members, alike = range(self.asked.count), math.inf if self.asked.varied else ALIKE
        return attractors(
            [self.points[k] if k in self.verdicts else None for k in members],
            [self.verdicts.get(k) for k in members],
            alike,
        )

    @property
    def labels(self) -> Array:
        """Which of the attractors each member comes to, shape (y, x); NaN where it has no start or is not
        known yet.
        """
        found = np.full(self.asked.count, np.nan)
        for k, one in enumerate(self.attractors):
            found[list(one.members)] = k
        return found.reshape(len(self.asked.y), len(self.asked.x))

    @property
    def laws(self) -> str:
        """Contact and friction laws, in words."""
        return law_words(loads(self.asked.model))

    @property
    def alike(self) -> str:
        """How many companions are told to be the same, in a few words."""
        return alike(self._known, lambda one: self.verdicts[one.number].kind)

    @property
    def _known(self) -> list[Companion]:
        return [one for one in self.companions if one.number in self.verdicts]

    @property
    def told(self) -> str:
        """What companions come to, in words; empty where there are none."""
        known = self._known
        words = lambda one: ", ".join(  # noqa: E731
            f"{path} = {value:.4g}" for path, value in self.asked.numbers(one.number).items()
        )
        return told(known, lambda one: self.verdicts[one.number].kind, words)

    def plot(self) -> Figure:
        """The grid as a figure, each attractor in a colour."""
        from ..plots.maps import basins as drawn

        return drawn(self)

    def write_csv(self, path: str | Path) -> None:
        """Writes a row a member: its two numbers, its attractor (counted from 1), its motion, its exponent,
        and what series are at the end.
        """
        rows: list[list[object]] = [[*self.asked.paths, "attractor", "kind", "exponent", *self.asked.series]]
        labels = self.labels.reshape(-1)
        for member, one in self.verdicts.items():
            value = "" if one.exponent is None else one.exponent.value
            numbers = self.asked.numbers(member).values()
            rows.append(
                [*numbers, int(labels[member]) + 1, one.kind, value, *self.points[member][-1].tolist()]
            )
        write_rows(path, rows)


def basins(
    mechanism: Mechanism,
    x: Range,
    y: Range,
    *,
    count: tuple[int, int] = (16, 16),
    turns: int = 60,
    dropped: int | None = None,
    series: Sequence[str] = (),
    phase: float = 0.0,
    step: float | None = None,
    exponents: bool = True,
    companions: int = SAMPLE,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    confirm: bool = False,
) -> Basins:
    """To which motion a mechanism comes from each start of a grid: ``x`` and ``y`` are (path, from, to), in
    SI units, with so many values.

    Paths: ``start.crank`` (rad, from the model's own start on), ``start.JOINT.x`` and ``.y`` (m: the journal
    in its bearing, seen from it), ``start.JOINT.vx`` and ``.vy`` (m/s), or any number of the model, as in
    ``joint.pin.clearance``. Members are looked at where the crank has turned so far beyond the model's own
    start, ``phase`` (1), for ``turns`` turns, of which ``dropped`` are left out, two thirds unless said.
    ``exponents``: a small difference is watched, without which chaos is told by the 0-1 test alone, of 100
    turns or more. ``companions``: so many members are gone through again, with 1.25 times and half the step.
    With a ``file`` what is known is kept in it, and the same call goes on there. Ctrl-C leaves what is
    complete. ``confirm``: make them even where it takes more than an hour. A journal outside its bearing is
    no start, and left out. Raises ModelError for a grid that cannot be, HeldError.
    """
    dropped = left_out(dropped, turns)
    job = job_of("basins", file, confirm, progress, lambda one: progress(one.done, one.steps))  # type: ignore[misc]

    def begin(first: Assembly, steps: int) -> None:
        start = TURNED_START if "start.crank" in (x[0], y[0]) else START
        work = MapWork("start", count[0] * count[1], turns, dropped, steps, 4, len(series or (1, 1)) + 1, companions, exponents, start=start,
                       first_look=FIRST_LOOK)  # fmt: skip
        job.begin(work.forecast(first, file))

    grid = [
        tuple(np.linspace(low, high, some).tolist())
        for (_, low, high), some in zip((x, y), count, strict=True)
    ]
    paths, names = (x[0], y[0]), tuple(series)
    asked = BasinSpec(
        dump(mechanism),
        paths,
        ("", ""),
        grid[0],
        grid[1],
        turns,
        dropped,
        names,
        phase,
        0,
        exponents,
        companions,
    )
    asked = planned(mechanism, asked, (x, y), step, begin)
    with job, kept_in(file, {"what": WHAT, "name": mechanism.name, "asked": asked}) as kept:
        known = kept.legs(gaps=True) if kept is not None else {}
        beside = unpacked(kept.array(BESIDE)) if kept is not None else []
        own = Starts(mechanism, asked.steps)
        near = seed(mechanism, own.at({}), asked.steps) if exponents else None
        finer: dict[int, Starts] = {asked.steps: own}

        def made(member: int, steps: int) -> Start:
            starts = finer.setdefault(steps, Starts(mechanism, steps))
            return Start(
                member, partial(starts.at, asked.numbers(member)), starts.ahead(asked.numbers(member), phase)
            )

        try:
            for one, points in observed(
                asked, near, [made(member, asked.steps) for member in range(asked.count)], known=tuple(known)
            ):
                known[one.number] = points, one.growth
                if kept is not None:
                    kept.write_row("legs", one.number, points, one.growth, np.zeros(0))
                job.count(len(known), asked.count, "starts")
            if not beside and companions:
                some = [member for member, (points, _) in sorted(known.items()) if len(points)]
                beside = list(
                    started_companions(asked, [some[k] for k in sampled(len(some), companions)], made, near)
                )
                if kept is not None:
                    kept.write_row("arrays", BESIDE, packed(beside))
        except KeyboardInterrupt:
            if not known:
                raise
    return together(mechanism.name, asked, known, beside)


def planned(
    mechanism: Mechanism,
    asked: BasinSpec,
    ranges: tuple[Range, Range],
    step: float | None,
    begin: Callable[[Assembly, int], None],
) -> BasinSpec:
    """What is asked, with units, series and steps; ``begin`` sees the model at its own start, and the steps
    of a turn.

    Raises ModelError for numbers that there are not, or that do not leave members side by side.
    """
    refuse_idle(mechanism, asked.turns, asked.dropped)
    units = []
    for name, path in zip("xy", asked.paths, strict=True):
        try:
            units.append(unit_of_start(mechanism, path))
        except ValueError as error:
            raise ModelError([Fault(name, str(error))], mechanism.name) from None
    if asked.paths[0] == asked.paths[1]:
        raise ModelError(
            [Fault("y", "this is the number that x is", asked.paths[0], "two numbers", "name another one")],
            mechanism.name,
        )
    refuse_contradiction(mechanism, asked.paths)
    steps = step_count(models_along(mechanism, ranges), step, search=True)
    first = Starts(mechanism, steps).at({})
    refuse_large_frame(first)
    begin(first, steps)
    return replace(
        asked, units=(units[0], units[1]), series=chosen_series(first, asked.series)[0], steps=steps
    )


def together(
    name: str, asked: BasinSpec, known: Mapping[int, tuple[Array, Array]], beside: Sequence[Companion]
) -> Basins:
    """The basins of members."""
    points = {k: one.reshape(-1, len(asked.series)) for k, (one, _) in known.items()}
    return Basins(name, asked, points, {k: one.reshape(-1) for k, (_, one) in known.items()}, tuple(beside))


def read_basins(kept: MapFile) -> Basins:
    """The basins in a map file, as far as they are known."""
    said = kept.spec
    return together(
        said["name"], BasinSpec(**tupled(said["asked"])), kept.legs(gaps=True), unpacked(kept.array(BESIDE))
    )
