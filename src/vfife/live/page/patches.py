"""Positions of sliders as patches of the numbers that a page starts with, and the proof that they combine.

Each position is assembled by itself; what differs from the model's own numbers is its patch. Patches of two
sliders may be laid on one another where what assembly gives for both is that, to the bit; sliders for which
it is not are put into one group, whose positions are assembled together.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...assembly.assemble import assemble
from ...assembly.assembled import Assembly
from ...errors import VfifeError
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import dump, loads
from ...simulation.simulate import prepare
from ...simulation.start import expected_forces
from ...solvers.arguments import RunArguments
from .page_model import PageModel, page_model, refuse_unfit, turned
from .payload import packed
from .sliders import POSITIONS, Slide

Array = NDArray[np.float64]
Slides: TypeAlias = tuple[Slide, ...]
Setting: TypeAlias = tuple[int, ...]  # a position of each slider
GROUP_COMBINATIONS = 400  # of the positions of sliders that have to be assembled together
FEWEST = 7  # positions of such a slider; where there would be fewer, one slider of the group moves at a time
CHECKED = 12  # positions of all sliders at once that are assembled to be compared


@dataclass(frozen=True)
class Group:
    """Sliders (their numbers), the rows that they change, and the values there for each combination, the last
    slider counting fastest.

    ``lines`` are those of the model file that a combination changes, by their numbers. Where one slider moves
    ``singly``, the combinations are the model's own setting, and the other positions of each slider in turn.
    """

    sliders: tuple[int, ...]
    singly: bool
    rows: NDArray[np.intp]
    values: Array
    lines: tuple[dict[int, str | None], ...]


@dataclass(frozen=True)
class Patched:
    """What a page starts with, its sliders, their groups, and what had to be left out."""

    base: PageModel
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
        """The combination of a group that a setting is. Raises ValueError where several sliders are moved of
        which one may be.
        """
        if group.singly:
            return combinations(self.slides, group.sliders, True).index(
                tuple(positions[s] for s in group.sliders)
            )
        at = 0
        for s in group.sliders:
            at = at * len(self.slides[s].values) + positions[s]
        return at

    def json(self) -> dict[str, Any]:
        """As a page takes it."""
        slides = [
            {
                "name": s.name,
                "paths": list(s.paths),
                "unit": s.unit,
                "values": list(s.values),
                "here": s.here,
                "said": list(s.said),
            }
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


UNLIKE = (
    "it has other parts, or other outputs, than the page; over turns, in place of a duration, a speed keeps"
    " its outputs"
)


class Assembler:
    """Assembles a model at settings of sliders, always with one number of steps between outputs, and keeps
    every answer.

    A setting is the position of each slider. ``before_assembly`` is called before each assembly; what it
    raises ends the whole.
    """

    def __init__(
        self, mechanism: Mechanism, step: float | None, before_assembly: Callable[[], None] = lambda: None
    ) -> None:
        self.before_assembly = before_assembly
        self.text, self.fixed = dump(mechanism), step is not None
        self.ideals: list[Assembly] = []
        self.expected: Mapping[str, float] = {}
        if step is None:
            refuse_unfit(mechanism)
            prepared = prepare(mechanism, RunArguments(companions=0))
            step, self.expected = prepared.assembly.choice.step, expected_forces(prepared.reference)
        self.base = page_model(mechanism, step, force=self.fixed, known=self.ideals)
        self.answers: dict[tuple[Any, ...], PageModel | str] = {}

    def mechanism(self, slides: Slides, positions: Setting) -> Mechanism:
        """The model at a setting."""
        changes = [
            change
            for slide, k in zip(slides, positions, strict=True)
            if k != slide.here
            for change in slide.set(k)
        ]
        return loads(self.text, set=changes)

    def refine(self, slides: Slides) -> None:
        """Take as many steps between two outputs as each slider needs at its harder end, and all do there at
        once: one step serves all.
        """
        if self.fixed or not slides:
            return
        hardest = {
            s: max((self._every(slides, {s: k}), k) for k in ends_of(slide))[1]
            for s, slide in enumerate(slides)
        }
        moves = [hardest, *({s: k} for s, k in hardest.items())]
        choice = self.base.own.choice
        every = max(choice.outputs_every, *(self._every(slides, one) for one in moves))
        if every != choice.outputs_every:
            self.base = page_model(self.base.own.mechanism, choice.step * choice.outputs_every / every)

    def _every(self, slides: Slides, moves: Mapping[int, int]) -> int:
        """Steps between two outputs that a setting would have by itself; 0 for one that no model may have."""
        self.before_assembly()
        with suppress(VfifeError):
            return assemble(
                self.mechanism(slides, moved(slides, moves)), expected=self.expected
            ).choice.outputs_every
        return 0

    def answer(self, slides: Slides, positions: Setting) -> PageModel | str:
        """Both mechanisms at a setting; the reason why the page cannot run a setting that no model may have,
        or that another text would run.
        """
        self.before_assembly()
        key = tuple(
            (slide.paths, slide.values[k])
            for slide, k in zip(slides, positions, strict=True)
            if k != slide.here
        )
        if not key:
            return self.base
        if key not in self.answers:
            self.answers[key] = self._assembled(slides, positions)
        return self.answers[key]

    def _assembled(self, slides: Slides, positions: Setting) -> PageModel | str:
        try:
            mechanism = self.mechanism(slides, positions)
            turn, ideal = turn_of(mechanism), self.base.ideal
            steps = turned(self.base.own, turn), None if ideal is None else turned(ideal, turn)
            found = page_model(mechanism, *steps, force=self.fixed, known=self.ideals)
        except VfifeError as error:
            return str(error).split("\n", 1)[0]
        return found if self.base.same_kind(found) else UNLIKE

    def at(self, slides: Slides, positions: Setting) -> PageModel | None:
        """Both mechanisms at a setting; None where the page cannot run it."""
        found = self.answer(slides, positions)
        return None if isinstance(found, str) else found


def moved(slides: Slides, moves: Mapping[int, int]) -> Setting:
    """The model's own setting with some sliders moved."""
    return tuple(moves.get(s, slide.here) for s, slide in enumerate(slides))


def ends_of(slide: Slide) -> tuple[int, int]:
    """The first and the last position of a slider."""
    return 0, len(slide.values) - 1


def patched(
    mechanism: Mechanism,
    slides: Sequence[Slide],
    step: float | None = None,
    before_assembly: Callable[[], None] = lambda: None,
) -> Patched:
    """Assemble the positions of all sliders, group those whose patches do not combine, and check settings of
    all of them at once.

    ``before_assembly`` is called before each assembly; what it raises ends the whole.
    """
    assembler = Assembler(mechanism, step, before_assembly)
    assembler.refine(tuple(slides))
    usable, notes = runnable(assembler, slides)
    found = combined(assembler, usable, grouped(assembler, usable))
    if len(found.groups) > 1 and differing(found, assembler) is not None:
        # Patches that combine pair by pair need not combine all at once. Then all sliders are one group,
        # whose combinations are assembled.
        found = combined(assembler, found.slides, [tuple(range(len(found.slides)))])
    notes += [
        f"{', '.join(found.slides[s].name for s in one.sliders)}: these move one at a time"
        for one in found.groups
        if one.singly
    ]
    texts = all(
        found.written(positions) == dump(one.own.mechanism) for positions, one in checked(found, assembler)
    )
    return replace(found, notes=tuple(notes), texts=texts)


def combined(assembler: Assembler, slides: Slides, groups: Sequence[tuple[int, ...]]) -> Patched:
    """The patches of all groups, for the positions that they keep."""
    slides = thinned(slides, groups)
    return Patched(assembler.base, slides, tuple(group(assembler, slides, sliders) for sliders in groups))


def runnable(assembler: Assembler, slides: Sequence[Slide]) -> tuple[Slides, list[str]]:
    """Sliders without the positions that cannot be run; a sentence for each slider that lost some."""
    found, notes = [], []
    for s, slide in enumerate(slides):
        answers = [
            assembler.answer(tuple(slides), moved(tuple(slides), {s: k})) for k in range(len(slide.values))
        ]
        good = [k for k, answer in enumerate(answers) if not isinstance(answer, str)]
        reasons = [answer for answer in answers if isinstance(answer, str)]
        if reasons:
            lost = f"{len(reasons)} of {len(answers)} positions cannot be run and are left out"
            notes.append(f"{slide.name}: {lost}, as the last of them: {reasons[-1]}")
        if len(good) > 1:
            found.append(with_positions(slide, good))
    return tuple(found), notes


def with_positions(slide: Slide, kept: Sequence[int]) -> Slide:
    """A slider with some of its positions."""
    values = tuple(slide.values[k] for k in kept)
    return replace(slide, values=values, here=values.index(slide.values[slide.here]))


def differs(one: Array, other: Array) -> NDArray[np.bool_]:
    """Where two vectors differ in a bit."""
    return np.asarray(one.view(np.uint64) != other.view(np.uint64))


def grouped(assembler: Assembler, slides: Slides) -> list[tuple[int, ...]]:
    """Sliders by group: two share one where their patches meet in a row, or do not give together what
    assembly gives.
    """
    base, ends = assembler.base.vector, [ends_of(slide) for slide in slides]
    own = {(s, k): vector_at(assembler, slides, {s: k}) for s, pair in enumerate(ends) for k in pair}
    rows = [
        differs(own[s, first], base) | differs(own[s, last], base) for s, (first, last) in enumerate(ends)
    ]
    group_of = list(range(len(slides)))
    for a, b in itertools.combinations(range(len(slides)), 2):
        if group_of[a] == group_of[b]:
            continue
        overlap = bool((rows[a] & rows[b]).any())
        if overlap or not all(
            _add_up(assembler, slides, own, (a, i), (b, j)) for i, j in zip(ends[a], ends[b], strict=True)
        ):
            group_of = [group_of[a] if g == group_of[b] else g for g in group_of]
    return [tuple(s for s, g in enumerate(group_of) if g == which) for which in dict.fromkeys(group_of)]


def _add_up(
    assembler: Assembler,
    slides: Slides,
    own: Mapping[tuple[int, int], Array],
    first: tuple[int, int],
    second: tuple[int, int],
) -> bool:
    """Whether the patches of two sliders at a position, laid on one another, are what assembly gives for
    both.
    """
    both = assembler.at(slides, moved(slides, dict((first, second))))
    laid = np.where(differs(own[first], assembler.base.vector), own[first], own[second])
    return both is not None and not differs(laid, both.vector).any()


def vector_at(assembler: Assembler, slides: Slides, moves: Mapping[int, int]) -> Array:
    """The numbers at a setting; those of the model where it cannot be run."""
    return (assembler.at(slides, moved(slides, moves)) or assembler.base).vector


def single(sliders: tuple[int, ...]) -> bool:
    """Whether of so many sliders only one moves at a time."""
    return len(sliders) > 1 and GROUP_COMBINATIONS ** (1.0 / len(sliders)) < FEWEST


def combinations(slides: Sequence[Slide], sliders: tuple[int, ...], singly: bool) -> list[tuple[int, ...]]:
    """Positions of the sliders of a group that are assembled."""
    if not singly:
        return list(itertools.product(*(range(len(slides[s].values)) for s in sliders)))
    here = tuple(slides[s].here for s in sliders)
    moved = [
        (*here[:i], k, *here[i + 1 :])
        for i, s in enumerate(sliders)
        for k in range(len(slides[s].values))
        if k != here[i]
    ]
    return [here, *moved]


def thinned(slides: Slides, groups: Sequence[tuple[int, ...]]) -> Slides:
    """Fewer positions for sliders that are assembled together."""
    found = list(slides)
    for sliders in groups:
        most = (
            int(GROUP_COMBINATIONS ** (1.0 / len(sliders)))
            if len(sliders) > 1 and not single(sliders)
            else POSITIONS + 1
        )
        for s in sliders:
            count = len(found[s].values)
            if count > most and not (found[s].whole and len(sliders) == 1):
                even = {round(k * (count - 1) / (most - 1)) for k in range(most)}
                nearest = min(even, key=lambda k, here=found[s].here: (abs(k - here), -k))  # type: ignore[misc]
                found[s] = with_positions(found[s], sorted({*(even - {nearest}), found[s].here}))
    return tuple(found)


def group(assembler: Assembler, slides: Slides, sliders: tuple[int, ...]) -> Group:
    """The patches of a group."""
    base, lines, singly = assembler.base.vector, assembler.text.splitlines(), single(sliders)
    settings = (
        moved(slides, dict(zip(sliders, at, strict=True))) for at in combinations(slides, sliders, singly)
    )
    found = [assembler.at(slides, positions) or assembler.base for positions in settings]
    changed = np.zeros(len(base), dtype=bool)
    for one in found:
        changed |= differs(one.vector, base)
    rows = np.flatnonzero(changed)
    texts = [dump(one.own.mechanism).splitlines() for one in found]
    return Group(
        sliders,
        singly,
        rows,
        np.array([one.vector[rows] for one in found]),
        tuple(rewritten(lines, text) for text in texts),
    )


def rewritten(lines: list[str], text: list[str]) -> dict[int, str | None]:
    """Lines of a text that another one has otherwise, by their numbers; None where it has none, more than one
    where it has more.
    """
    found: dict[int, str | None] = {}
    for what, i, j, m, n in SequenceMatcher(None, lines, text, autojunk=False).get_opcodes():
        if what == "insert":
            found[i - 1] = "\n".join([found.get(i - 1) or lines[i - 1], *text[m:n]])
        elif what != "equal":
            found |= dict.fromkeys(range(i, j))
            found[i] = "\n".join(text[m:n]) if n > m else None
    return found


def checked(found: Patched, assembler: Assembler) -> Iterator[tuple[Setting, PageModel]]:
    """Some settings of all sliders at once, and what assembly gives for them."""
    draw = random.Random(1)
    for _ in range(CHECKED):
        positions = [draw.randrange(len(slide.values)) for slide in found.slides]
        for group in (group for group in found.groups if group.singly):
            for s in set(group.sliders) - {draw.choice(group.sliders)}:
                positions[s] = found.slides[s].here
        if (both := assembler.at(found.slides, tuple(positions))) is not None:
            yield tuple(positions), both


def differing(found: Patched, assembler: Assembler) -> Setting | None:
    """A setting for which the patches do not give what assembly gives, to the bit; None where all that were
    tried do.
    """
    return next(
        (
            positions
            for positions, both in checked(found, assembler)
            if differs(found.laid(positions), both.vector).any()
        ),
        None,
    )
