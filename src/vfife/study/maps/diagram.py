"""What a bifurcation diagram has, as far as it is known: points, growth, motions in words, companions; written as a table, read from a map file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...analysis.chaos import exponent
from ...analysis.verdict import Verdict, verdict
from ...modelfile import loads
from ...results.csvtable import write_rows
from ...results.mapfile import MapFile
from .beside import Companion, alike, told, unpacked
from .looks import law_words, tupled
from .starts import spoken

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
CHAINS = ("up", "down")
WHAT = "bifurcation"


@dataclass(frozen=True)
class Swept:
    """What is asked: the number's ``path`` and its ``values`` in the order of the way up, ``turns`` at each, the first of them ``dropped``;
    ``series`` are looked at once a turn at ``phase`` (1) of it; ``steps`` in a turn. ``unit`` is that of the number, ``units`` are those of series.
    ``starts``: numbers of each start from which every value begins; without any the state is carried on, up and down. So many values have
    ``companions``.
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
    starts: tuple[tuple[tuple[str, float], ...], ...] = ()
    companions: int = 0

    @property
    def ways(self) -> tuple[str, ...]:
        """How a value is reached, in words: on the ways up and down, or from its starts."""
        return tuple(spoken(one) or "own start" for one in self.starts) or CHAINS


@dataclass(frozen=True)
class Spell:
    """A motion in words, the ``first`` and the ``last`` of the values at which it is found, and how many they are."""

    kind: str
    first: float
    last: float
    count: int


@dataclass(frozen=True)
class Bifurcation:
    """A diagram, its values in the order of the way up and NaN where it is not known yet; chains are the way up and the way down, or the starts.

    Of each of ``asked.series`` its ``points`` in SI units, shape (chains, values, turns); ``growth`` of a small difference in each of these turns,
    its logarithm; the largest Lyapunov ``exponents`` (1/turn), each with the lower and the higher of its two halves, shape (chains, values, 3);
    ``kinds`` of the motion in words, shape (chains, values). So many values are ``done`` in each chain. ``companions``: members with other steps.
    """

    name: str
    asked: Swept
    points: Mapping[str, Array]
    growth: Array
    exponents: Array
    kinds: tuple[tuple[str, ...], ...]
    done: int
    companions: tuple[Companion, ...] = field(default=())

    def spells(self, chain: int) -> list[Spell]:
        """Values next to each other at which the motion is called the same, in the order of the way up."""
        known = [(value, kind) for value, kind in zip(self.asked.values, self.kinds[chain], strict=True) if kind]
        found: list[Spell] = []
        for kind, some in groupby(known, key=lambda one: one[1]):
            values = [value for value, _ in some]
            found.append(Spell(kind, values[0], values[-1], len(values)))
        return found

    def verdict(self, chain: int, value: int) -> Verdict:
        """What the motion at a value is, with its evidence."""
        points = np.stack([one[chain, value] for one in self.points.values()], axis=1)
        return verdict(points, exponent(self.growth[chain, value]))

    @property
    def laws(self) -> str:
        """Contact and friction laws, in words."""
        return law_words(loads(self.asked.model))

    @property
    def alike(self) -> str:
        """How many companions are told to be the same, in a few words."""
        return alike(self._known, lambda one: self.kinds[one.way][one.number])

    @property
    def _known(self) -> list[Companion]:
        return [one for one in self.companions if self.kinds[one.way][one.number]]

    @property
    def told(self) -> str:
        """What companions come to, in words; empty where there are none."""
        asked, known = self.asked, self._known
        name = lambda one: f"{asked.path} = {asked.values[one.number]:.5g} ({asked.ways[one.way]})"  # noqa: E731
        return told(known, lambda one: self.kinds[one.way][one.number], name)

    def plot(self) -> Figure:
        """The diagram as a figure, with the exponents below it."""
        from ...plots.bifurcation import diagram

        return diagram(self)

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for every value, direction and turn that was looked at, with the exponent and the kind of the motion."""
        rows: list[list[object]] = [[self.asked.path, "way", "turn", *self.asked.series, "exponent", "kind"]]
        for k, way in enumerate(self.asked.ways):
            for place, value in enumerate(self.asked.values):
                if self.kinds[k][place]:
                    said = float(self.exponents[k, place, 0]), self.kinds[k][place]
                    for turn, row in enumerate(np.stack([one[k, place] for one in self.points.values()], axis=1).tolist()):
                        rows.append([value, way, self.asked.dropped + turn + 1, *row, *said])
        write_rows(path, rows)


@dataclass
class Legs:
    """What is known of a map: points and growth by the number of a value, of all chains (carried on) or of one (from starts), and companions."""

    asked: Swept
    legs: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    companions: list[Companion] = field(default_factory=list)

    @classmethod
    def of(cls, asked: Swept, kept: MapFile) -> Legs:
        """Those of a file; of what is carried on, up to the first that is missing."""
        legs = kept.members() if asked.starts else dict(enumerate(kept.legs()))
        return cls(asked, legs, [one for number in legs for one in unpacked(kept.stored(f"beside {number}"))])

    @property
    def count(self) -> int:
        """Legs that there will be."""
        return len(self.asked.values) * max(1, len(self.asked.starts))

    def add(self, number: int, points: Array, growth: Array, beside: Sequence[Companion]) -> None:
        """One more."""
        self.legs[number] = points, growth
        self.companions += beside

    def each(self) -> Iterator[tuple[int, int, Array, Array]]:
        """Chain, value, points (turns, series) and growth (turns,) of all that is known."""
        count, series = len(self.asked.values), len(self.asked.series)
        for number, (points, growth) in self.legs.items():
            if self.asked.starts:
                yield number // count, number % count, points, growth.reshape(-1)
                continue
            shaped = points.reshape(len(points), series, 2)
            for k, place in enumerate((number, count - 1 - number)):
                yield k, place, shaped[:, :, k], growth[:, k]

    def diagram(self, name: str) -> Bifurcation:
        """The diagram; chains that go down have their values in the order of the way up."""
        asked = self.asked
        shape = len(asked.ways), len(asked.values), asked.turns - asked.dropped
        points, growth = {series: np.full(shape, np.nan) for series in asked.series}, np.full(shape, np.nan)
        exponents, kinds = np.full((*shape[:2], 3), np.nan), [[""] * shape[1] for _ in asked.ways]
        for k, place, values, grown in self.each():
            for j, series in enumerate(asked.series):
                points[series][k, place] = values[:, j]
            growth[k, place] = grown
            found = exponent(grown)
            exponents[k, place] = found.value, found.low, found.high
            kinds[k][place] = verdict(values, found).kind
        done, beside = len(self.legs) // max(1, len(asked.starts)), sorted(self.companions, key=lambda one: (one.way, one.number, one.ratio))
        return Bifurcation(name, asked, points, growth, exponents, tuple(map(tuple, kinds)), done, tuple(beside))


def read_diagram(kept: MapFile) -> Bifurcation:
    """The diagram in a map file, as far as it is known."""
    said = kept.asked
    asked = Swept(**tupled(said["asked"]))
    return Legs.of(asked, kept).diagram(said["name"])
