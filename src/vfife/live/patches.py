"""Positions of sliders as patches of the numbers that a page starts with, and the proof that they combine.

Each position is assembled by itself; what differs from the model's own numbers is its patch. Patches of two sliders may be laid on one another
where what assembly gives for both is that, to the bit; sliders for which it is not are put into one group, whose positions are assembled together.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..simulation import expected_forces, prepare
from ..solvers.arguments import RunArguments
from .given import packed
from .sliders import POSITIONS, Slide
from .together import Together, refuse_unfit, together, turned

Array = NDArray[np.float64]
GROUP_COMBINATIONS = 400  # of the positions of sliders that have to be assembled together
FEWEST = 7  # positions of such a slider; where there would be fewer, one slider of the group moves at a time
CHECKED = 12  # positions of all sliders at once that are assembled to be compared


@dataclass(frozen=True)
class Group:
    """Sliders (their numbers), the rows that they change, and the values there for each combination, the last slider counting fastest.

    ``lines`` are those of the model file that a combination changes, by their numbers. Where one slider moves ``singly``, the combinations are the
    model's own setting, and the other positions of each slider in turn.
    """

    sliders: tuple[int, ...]
    singly: bool
    rows: NDArray[np.intp]
    values: Array
    lines: tuple[dict[int, str | None], ...]


@dataclass(frozen=True)
class Patched:
    """What a page starts with, its sliders, their groups, and what had to be left out."""

    base: Together
    slides: tuple[Slide, ...]
    groups: tuple[Group, ...]
    notes: tuple[str, ...] = ()
    texts: bool = True  # whether their lines combine, too

    def laid(self, positions: Sequence[int]) -> Array:
        """The numbers at a setting, as the page lays the patches on one another."""
        vector = self.base.vector.copy()
        for group in self.groups:
            vector[group.rows] = group.values[self.place(group, positions)]
        return vector

    def written(self, positions: Sequence[int]) -> str:
        """The model file at a setting, likewise."""
        lines: list[str | None] = [*dump(self.base.own.mechanism).splitlines()]
        for group in self.groups:
            for line, text in group.lines[self.place(group, positions)].items():
                lines[line] = text
        return "\n".join(line for line in lines if line is not None) + "\n"

    def place(self, group: Group, positions: Sequence[int]) -> int:
        """The combination of a group that a setting is. Raises ValueError where several sliders are moved of which one may be."""
        if group.singly:
            return combinations(self.slides, group.sliders, True).index(tuple(positions[s] for s in group.sliders))
        at = 0
        for s in group.sliders:
            at = at * len(self.slides[s].values) + positions[s]
        return at

    def json(self) -> dict[str, Any]:
        """As a page takes it."""
        slides = [
            {"name": s.name, "paths": list(s.paths), "unit": s.unit, "values": list(s.values), "here": s.here, "said": list(s.said)}
            for s in self.slides
        ]
        groups = [
            {
                "sliders": list(g.sliders),
                "singly": g.singly,
                "rows": g.rows.tolist(),
                "values": packed(g.values),
                "lines": [list(map(list, d.items())) for d in g.lines],
            }
            for g in self.groups
        ]
        return {"slides": slides, "groups": groups, "notes": list(self.notes), "texts": self.texts}


OTHERWISE = "it has other parts, or other outputs, than the page; over turns, in place of a duration, a speed keeps its outputs"


class Settings:
    """Settings of sliders, and what assembly gives for each of them with one number of steps between outputs."""

    def __init__(self, mechanism: Mechanism, slides: Sequence[Slide], step: float | None, going: Callable[[], None] = lambda: None) -> None:
        self.going = going
        self.slides, self.text, self.given = tuple(slides), dump(mechanism), step
        self.ideals: list[Assembly] = []
        self.expected: Mapping[str, float] = {}
        if step is None:
            refuse_unfit(mechanism)
            prepared = prepare(mechanism, RunArguments(companions=0))
            step, self.expected = prepared.assembly.choice.step, expected_forces(prepared.reference)
        self.base = together(mechanism, step, force=self.given is not None, known=self.ideals)
        self.every = self.base.own.choice.outputs_every
        self.known: dict[tuple[Any, ...], Together | None] = {}
        self.why = ""  # the last of those that no model may have cannot be run

    @property
    def here(self) -> tuple[int, ...]:
        """The model's own setting."""
        return tuple(slide.here for slide in self.slides)

    def moved(self, moves: dict[int, int]) -> tuple[int, ...]:
        """The model's own setting with some sliders moved."""
        return tuple(moves.get(s, here) for s, here in enumerate(self.here))

    def mechanism(self, positions: tuple[int, ...]) -> Mechanism:
        """The model at a setting."""
        settings = [one for slide, k in zip(self.slides, positions, strict=True) if k != slide.here for one in slide.set(k)]
        return loads(self.text, set=settings)

    def refine(self) -> None:
        """Takes as many steps between two outputs as each slider needs at its harder end, and all do there at once: one step serves all."""
        if self.given is not None or not self.slides:
            return
        hardest = {}
        for s, slide in enumerate(self.slides):
            ends = [(self._every({s: k}), k) for k in (0, len(slide.values) - 1)]
            hardest[s] = max(ends)[1]
        self.every = max(self.every, self._every(hardest), *(self._every({s: k}) for s, k in hardest.items()))
        choice = self.base.own.choice
        if self.every != choice.outputs_every:
            self.base = together(self.base.own.mechanism, choice.step * choice.outputs_every / self.every)

    def _every(self, moves: dict[int, int]) -> int:
        """Steps between two outputs that a setting would have by itself; 0 for one that no model may have."""
        self.going()
        with suppress(VfifeError):
            return assemble(self.mechanism(self.moved(moves)), expected=self.expected).choice.outputs_every
        return 0

    def at(self, positions: tuple[int, ...]) -> Together | None:
        """Both mechanisms at a setting; None for one that no model may have, or that another text would run."""
        self.going()
        if positions == self.here:
            return self.base
        key = tuple((slide.paths, slide.values[k]) for slide, k in zip(self.slides, positions, strict=True) if k != slide.here)
        if key not in self.known:
            try:
                mechanism = self.mechanism(positions)
                turn, ideal = turn_of(mechanism), self.base.ideal
                steps = turned(self.base.own, turn), None if ideal is None else turned(ideal, turn)
                found = together(mechanism, *steps, force=self.given is not None, known=self.ideals)
                fits = self.base.same_kind(found)
                self.known[key] = found if fits else None
                self.why = self.why if fits else OTHERWISE
            except VfifeError as error:
                self.known[key], self.why = None, str(error).split("\n", 1)[0]
        return self.known[key]


def patched(mechanism: Mechanism, slides: Sequence[Slide], step: float | None = None, going: Callable[[], None] = lambda: None) -> Patched:
    """Assembles the positions of all sliders, groups those whose patches do not combine, and checks settings of all of them at once.

    ``going`` is called before each assembly; what it raises ends the whole.
    """
    settings = Settings(mechanism, slides, step, going)
    settings.refine()
    settings, notes = usable(settings)
    groups = joined(settings)
    for _ in range(len(settings.slides)):
        settings = thinned(settings, groups)
        found = Patched(settings.base, settings.slides, tuple(group(settings, sliders) for sliders in groups), tuple(notes))
        if len(groups) < 2 or differing(found, settings) is None:
            notes += [f"{', '.join(found.slides[s].name for s in one.sliders)}: these move one at a time" for one in found.groups if one.singly]
            found = replace(found, notes=tuple(notes))
            return replace(found, texts=all(found.written(positions) == dump(one.own.mechanism) for positions, one in checked(found, settings)))
        groups = [tuple(sorted(itertools.chain(*groups)))]
    return Patched(settings.base, (), (), tuple(notes))


def usable(settings: Settings) -> tuple[Settings, list[str]]:
    """Sliders without the positions that no model may have; a sentence for each that lost some."""
    kept, notes = [], []
    for s, slide in enumerate(settings.slides):
        settings.why = ""
        good = [k for k in range(len(slide.values)) if settings.at(settings.moved({s: k})) is not None]
        if len(good) < len(slide.values):
            notes.append(
                f"{slide.name}: {len(slide.values) - len(good)} of {len(slide.values)} positions cannot be run and are left out"
                + (f", as the last of them: {settings.why}" if settings.why else "")
            )
        if len(good) > 1:
            kept.append(with_positions(slide, good))
    return again(settings, kept), notes


def with_positions(slide: Slide, kept: Sequence[int]) -> Slide:
    """A slider with some of its positions."""
    values = tuple(slide.values[k] for k in kept)
    return replace(slide, values=values, here=values.index(slide.values[slide.here]))


def again(settings: Settings, slides: Sequence[Slide]) -> Settings:
    """Settings of other sliders over the same model with the same step."""
    found = copy(settings)
    found.slides = tuple(slides)
    return found


def differs(one: Array, other: Array) -> NDArray[np.bool_]:
    """Where two vectors differ in a bit."""
    return np.asarray(one.view(np.uint64) != other.view(np.uint64))


def joined(settings: Settings) -> list[tuple[int, ...]]:
    """Sliders by group: two share one where their patches meet in a row, or do not give together what assembly gives."""
    slides, base = settings.slides, settings.base.vector
    ends = [(0, len(slide.values) - 1) for slide in slides]
    own = {(s, k): of(settings.at(settings.moved({s: k})), base) for s, pair in enumerate(ends) for k in pair}
    touched = [differs(own[s, ends[s][0]], base) | differs(own[s, ends[s][1]], base) for s in range(len(slides))]
    group_of = list(range(len(slides)))
    for a, b in itertools.combinations(range(len(slides)), 2):
        if group_of[a] == group_of[b]:
            continue
        apart = bool((touched[a] & touched[b]).any())
        for i, j in () if apart else zip(ends[a], ends[b], strict=True):
            both = settings.at(settings.moved({a: i, b: j}))
            laid = np.where(differs(own[a, i], base), own[a, i], own[b, j])
            apart = apart or both is None or bool(differs(laid, both.vector).any())
        if apart:
            group_of = [group_of[a] if g == group_of[b] else g for g in group_of]
    return [tuple(s for s, g in enumerate(group_of) if g == which) for which in dict.fromkeys(group_of)]


def of(found: Together | None, base: Array) -> Array:
    """The numbers of a setting; those of the model where it has none."""
    return base if found is None else found.vector


def single(sliders: tuple[int, ...]) -> bool:
    """Whether of so many sliders only one moves at a time."""
    return len(sliders) > 1 and GROUP_COMBINATIONS ** (1.0 / len(sliders)) < FEWEST


def combinations(slides: Sequence[Slide], sliders: tuple[int, ...], singly: bool) -> list[tuple[int, ...]]:
    """Positions of the sliders of a group that are assembled."""
    if not singly:
        return list(itertools.product(*(range(len(slides[s].values)) for s in sliders)))
    here = tuple(slides[s].here for s in sliders)
    moved = [(*here[:i], k, *here[i + 1 :]) for i, s in enumerate(sliders) for k in range(len(slides[s].values)) if k != here[i]]
    return [here, *moved]


def thinned(settings: Settings, groups: Sequence[tuple[int, ...]]) -> Settings:
    """Fewer positions for sliders that are assembled together."""
    slides = list(settings.slides)
    for sliders in groups:
        most = int(GROUP_COMBINATIONS ** (1.0 / len(sliders))) if len(sliders) > 1 and not single(sliders) else POSITIONS + 1
        for s in sliders:
            count = len(slides[s].values)
            if count > most and not (slides[s].whole and len(sliders) == 1):
                even = {round(k * (count - 1) / (most - 1)) for k in range(most)}
                gaps = {abs(k - slides[s].here): k for k in even}
                slides[s] = with_positions(slides[s], sorted({*(even - {gaps[min(gaps)]}), slides[s].here}))
    return again(settings, slides) if tuple(slides) != settings.slides else settings


def group(settings: Settings, sliders: tuple[int, ...]) -> Group:
    """The patches of a group."""
    base, lines = settings.base.vector, settings.text.splitlines()
    found = [
        settings.at(settings.moved(dict(zip(sliders, positions, strict=True)))) or settings.base
        for positions in combinations(settings.slides, sliders, single(sliders))
    ]
    changed = np.zeros(len(base), dtype=bool)
    for one in found:
        changed |= differs(one.vector, base)
    rows = np.flatnonzero(changed)
    texts = [dump(one.own.mechanism).splitlines() for one in found]
    return Group(sliders, single(sliders), rows, np.array([one.vector[rows] for one in found]), tuple(rewritten(lines, text) for text in texts))


def rewritten(lines: list[str], text: list[str]) -> dict[int, str | None]:
    """Lines of a text that another one has otherwise, by their numbers; None where it has none, more than one where it has more."""
    found: dict[int, str | None] = {}
    for what, i, j, m, n in SequenceMatcher(None, lines, text, autojunk=False).get_opcodes():
        if what == "insert":
            found[i - 1] = "\n".join([found.get(i - 1) or lines[i - 1], *text[m:n]])
        elif what != "equal":
            found |= dict.fromkeys(range(i, j))
            found[i] = "\n".join(text[m:n]) if n > m else None
    return found


def checked(found: Patched, settings: Settings) -> Iterator[tuple[tuple[int, ...], Together]]:
    """Some settings of all sliders at once, and what assembly gives for them."""
    draw = random.Random(1)
    for _ in range(CHECKED):
        positions = [draw.randrange(len(slide.values)) for slide in found.slides]
        for group in (group for group in found.groups if group.singly):
            for s in set(group.sliders) - {draw.choice(group.sliders)}:
                positions[s] = found.slides[s].here
        if (both := settings.at(tuple(positions))) is not None:
            yield tuple(positions), both


def differing(found: Patched, settings: Settings) -> tuple[int, ...] | None:
    """A setting for which the patches do not give what assembly gives, to the bit; None where all that were tried do."""
    return next((positions for positions, both in checked(found, settings) if differs(found.laid(positions), both.vector).any()), None)
