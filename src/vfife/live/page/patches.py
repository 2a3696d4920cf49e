"""Positions of sliders as patches of the numbers with which a page starts, and the proof that they combine.

A page cannot assemble a model; it has one vector of numbers (states and tables) for the model's own values,
and for each position of a slider a patch: the rows of the vector that differ there, with their values. Two
sliders at once need no assembly if their patches combine: no row is in both, and the vector with both patches
is, to the bit, what assembly gives for both positions. Sliders for which this fails share a group, and all
combinations of positions of a group are assembled. To assemble every combination of all sliders instead would
take 21 to the power of their number.

The steps of :func:`slider_patches`, in this order because each changes what the next one assembles:

1. ``Assembler``: the model's own numbers, and one number of steps between outputs that serves all positions;
2. ``usable_positions``: positions that can be assembled and run by the same text;
3. ``slider_groups``: sliders whose patches do not combine, found by pairs at the ends of their ranges;
4. ``all_patches``: fewer positions for sliders of a group, and the patches;
5. ``counterexample``: random settings of all sliders at once, assembled and compared.
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
from ...report.design_words import and_words
from ...report.fall_cautions import fall_remedy, falling_journals
from ...simulation.simulate import prepare
from ...simulation.start import expected_forces
from ...solvers.arguments import RunArguments
from .page_model import PageModel, page_model, refuse_unfit, step_dividing_turn
from .payload import base64_of
from .sliders import POSITIONS, Slide, thinned_positions, with_positions

Array = NDArray[np.float64]
Slides: TypeAlias = tuple[Slide, ...]
Setting: TypeAlias = tuple[int, ...]  # a position of each slider
GROUP_COMBINATIONS = 400  # at most, of the positions of sliders that have to be assembled together
# Fewest positions of such a slider: where there would be fewer, one slider of the group moves at a time and
# all keep theirs. With 400 combinations two sliders get 20 positions each, three get 7, and four move singly.
FEWEST = 7
CHECKED = 12  # positions of all sliders at once that are assembled to be compared


@dataclass(frozen=True)
class Group:
    """Sliders (their numbers), the rows that they change, and the values of these rows for each combination,
    the last slider varying fastest.

    ``lines`` are the changed lines of the model file by number, for each combination. In a group whose
    sliders move ``singly``, the combinations are the model's own setting, then the other positions of each
    slider in turn.
    """

    sliders: tuple[int, ...]
    singly: bool
    rows: NDArray[np.intp]
    values: Array
    lines: tuple[dict[int, str | None], ...]


@dataclass(frozen=True)
class SliderPatches:
    """The numbers with which a page starts, its sliders, their groups, and notes on what was left out."""

    base: PageModel
    slides: tuple[Slide, ...]
    groups: tuple[Group, ...]
    notes: tuple[str, ...] = ()
    texts: bool = True  # whether lines of the model file combine, too

    def vector(self, positions: Sequence[int]) -> Array:
        """Return the numbers at a setting, from patches as in the page."""
        vector = self.base.vector.copy()
        for group in self.groups:
            vector[group.rows] = group.values[self.combination(group, positions)]
        return vector

    def model_file(self, positions: Sequence[int]) -> str:
        """Return the model file at a setting, from patches as in the page."""
        lines: list[str | None] = [*dump(self.base.assembly.mechanism).splitlines()]
        for group in self.groups:
            for line, text in group.lines[self.combination(group, positions)].items():
                lines[line] = text
        return "\n".join(line for line in lines if line is not None) + "\n"

    def combination(self, group: Group, positions: Sequence[int]) -> int:
        """Return the index of a setting among the combinations of a group. Raises ValueError if more than one
        slider of a group with ``singly`` was moved.
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
        """Return the data for the page."""
        keys = ("name", "paths", "unit", "values", "here", "labels")
        slides = [{key: getattr(slide, key) for key in keys} for slide in self.slides]
        groups = [
            {
                "sliders": g.sliders,
                "singly": g.singly,
                "rows": g.rows.tolist(),
                "values": base64_of(g.values),
                "lines": [[*d.items()] for d in g.lines],
            }
            for g in self.groups
        ]
        notes = [*self.notes, *notes_on_start(self.base.assembly.mechanism)]
        return {"slides": slides, "groups": groups, "notes": notes, "texts": self.texts}


OTHER_STEP = (
    "it has other parts, or other outputs, than the page; over turns, in place of a duration, a speed keeps"
    " its outputs"
)


class Assembler:
    """Assembles a model at settings of sliders with one number of steps between outputs, and caches the
    results.

    A setting is the position of each slider. ``before_assembly`` is called before each assembly and may raise
    to end the work.
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
        self.base = page_model(mechanism, step, force=self.fixed, references=self.ideals)
        self.cache: dict[tuple[Any, ...], PageModel | str] = {}

    def mechanism(self, slides: Slides, positions: Setting) -> Mechanism:
        """Return the model at a setting."""
        changes = [
            change
            for slide, k in zip(slides, positions, strict=True)
            if k != slide.here
            for change in slide.changes(k)
        ]
        return loads(self.text, set=changes)

    def refine(self, slides: Slides) -> None:
        """Take as many steps between two outputs as the most demanding position needs, because one step
        serves all.

        Positions between the ends of a range are assumed to need no more than the more demanding end; the
        ends of all sliders are combined, too.
        """
        if self.fixed or not slides:
            return
        hardest = {
            s: max((self._output_interval(slides, {s: k}), k) for k in ends_of(slide))[1]
            for s, slide in enumerate(slides)
        }
        moves = [hardest, *({s: k} for s, k in hardest.items())]
        choice = self.base.assembly.choice
        interval = max(
            choice.outputs_every, *(self._output_interval(slides, moved_sliders) for moved_sliders in moves)
        )
        if interval != choice.outputs_every:
            self.base = page_model(
                self.base.assembly.mechanism, choice.step * choice.outputs_every / interval
            )

    def _output_interval(self, slides: Slides, moves: Mapping[int, int]) -> int:
        """Return the steps between two outputs of a setting by itself; 0 if it cannot be assembled."""
        self.before_assembly()
        with suppress(VfifeError):
            return assemble(
                self.mechanism(slides, moved_setting(slides, moves)), expected=self.expected
            ).choice.outputs_every
        return 0

    def model_or_reason(self, slides: Slides, positions: Setting) -> PageModel | str:
        """Return the assembled mechanism and reference at a setting, or the reason why it cannot be assembled
        or has another step function than the page.
        """
        self.before_assembly()
        # The key consists of values, not of positions: sliders lose positions between the steps of
        # :func:`slider_patches`, and models assembled before remain valid.
        key = tuple(
            (slide.paths, slide.values[k])
            for slide, k in zip(slides, positions, strict=True)
            if k != slide.here
        )
        if not key:
            return self.base
        if key not in self.cache:
            self.cache[key] = self._assembled(slides, positions)
        return self.cache[key]

    def _assembled(self, slides: Slides, positions: Setting) -> PageModel | str:
        try:
            mechanism = self.mechanism(slides, positions)
            turn, ideal = turn_of(mechanism), self.base.ideal
            steps = (
                step_dividing_turn(self.base.assembly, turn),
                None if ideal is None else step_dividing_turn(ideal, turn),
            )
            model = page_model(mechanism, *steps, force=self.fixed, references=self.ideals)
        except VfifeError as error:
            return str(error).split("\n", 1)[0]
        return model if self.base.same_kind(model) else OTHER_STEP

    def at(self, slides: Slides, positions: Setting) -> PageModel | None:
        """Return the assembled mechanism and reference at a setting; None if the page cannot run it."""
        model = self.model_or_reason(slides, positions)
        return None if isinstance(model, str) else model


def moved_setting(slides: Slides, moves: Mapping[int, int]) -> Setting:
    """Return the model's own setting with some sliders moved."""
    return tuple(moves.get(s, slide.here) for s, slide in enumerate(slides))


def ends_of(slide: Slide) -> tuple[int, int]:
    """Return the first and the last position of a slider, at which its steps are counted
    (``Assembler.refine``) and it is compared with other sliders (``slider_groups``).
    """
    return 0, len(slide.values) - 1


def slider_patches(
    mechanism: Mechanism,
    slides: Sequence[Slide],
    step: float | None = None,
    before_assembly: Callable[[], None] = lambda: None,
) -> SliderPatches:
    """Assemble the positions of all sliders, group those whose patches do not combine, and check settings of
    all of them at once.

    ``step`` (s) is that of a run, None for the automatic one. ``before_assembly`` is called before each
    assembly and may raise to end the work.
    """
    assembler = Assembler(mechanism, step, before_assembly)
    assembler.refine(tuple(slides))
    usable, notes = usable_positions(assembler, slides)
    patches = all_patches(assembler, usable, slider_groups(assembler, usable))
    if len(patches.groups) > 1 and counterexample(patches, assembler) is not None:
        # Patches that combine pair by pair at the ends of their ranges need not combine all at once, nor
        # between the ends. Then all sliders are one group, whose combinations are assembled; one group always
        # passes, because its values are those of assembly, so there is nothing more to try.
        patches = all_patches(assembler, patches.slides, [tuple(range(len(patches.slides)))])
    notes += [
        one_at_a_time([patches.slides[s].name for s in group.sliders], len(patches.slides))
        for group in patches.groups
        if group.singly
    ]
    # Two sliders may change one line of the model file although their numbers combine. The page then shows
    # the model's own file and the changes as options of the command line.
    texts = all(
        patches.model_file(positions) == dump(model.assembly.mechanism)
        for positions, model in random_settings(patches, assembler)
    )
    return replace(patches, notes=tuple(notes), texts=texts)


def one_at_a_time(names: Sequence[str], count: int) -> str:
    """Explain sliders that cannot be combined, out of ``count``."""
    sliders = "the sliders" if len(names) == count else f"{', '.join(names[:-1])} and {names[-1]}"
    return f"Only one of {sliders} can differ from the model at a time: moving one returns the others"


def all_patches(assembler: Assembler, slides: Slides, groups: Sequence[tuple[int, ...]]) -> SliderPatches:
    """Return the patches of all groups, with fewer positions if a group would have too many combinations."""
    slides = fewer_positions(slides, groups)
    return SliderPatches(
        assembler.base, slides, tuple(group(assembler, slides, sliders) for sliders in groups)
    )


def usable_positions(assembler: Assembler, slides: Sequence[Slide]) -> tuple[Slides, list[str]]:
    """Return the sliders without positions that cannot be run, and a sentence for each slider that
    lost some.
    """
    usable, notes = [], []
    for s, slide in enumerate(slides):
        models = [
            assembler.model_or_reason(tuple(slides), moved_setting(tuple(slides), {s: k}))
            for k in range(len(slide.values))
        ]
        positions = [k for k, model in enumerate(models) if not isinstance(model, str)]
        reasons = [model for model in models if isinstance(model, str)]
        if reasons:
            note = f"{len(reasons)} of {len(models)} positions cannot be run and are left out"
            notes.append(f"{slide.name}: {note}, as the last of them: {reasons[-1].removesuffix('.')}")
        if len(positions) > 1:
            usable.append(with_positions(slide, positions))
    return tuple(usable), notes


def changed_bits(first: Array, second: Array) -> NDArray[np.bool_]:
    """Return where two vectors differ in any bit; -0.0 and 0.0 differ."""
    return np.asarray(first.view(np.uint64) != second.view(np.uint64))


def slider_groups(assembler: Assembler, slides: Slides) -> list[tuple[int, ...]]:
    """Return the numbers of sliders by group: two share one if their patches have a row in common, or do not
    combine.

    Each pair is assembled at two settings only, both sliders at their first positions and both at their last
    ones: for n sliders at most 2 n + n (n - 1) assemblies. It is assumed that a row that changes anywhere
    changes at an end, and that patches that combine at the ends combine between them; ``counterexample`` may
    detect where that is wrong. Groups are merged as pairs are found, so that pairs within a group are not
    assembled.
    """
    base, ends = assembler.base.vector, [ends_of(slide) for slide in slides]
    vectors = {(s, k): vector_at(assembler, slides, {s: k}) for s, pair in enumerate(ends) for k in pair}
    rows = [
        changed_bits(vectors[s, first], base) | changed_bits(vectors[s, last], base)
        for s, (first, last) in enumerate(ends)
    ]
    group_of = list(range(len(slides)))
    for a, b in itertools.combinations(range(len(slides)), 2):
        if group_of[a] == group_of[b]:
            continue
        # Overlaps are known without another assembly, so they are tested first.
        overlap = bool((rows[a] & rows[b]).any())
        if overlap or not all(
            _combine(assembler, slides, vectors, (a, i), (b, j))
            for i, j in zip(ends[a], ends[b], strict=True)
        ):
            group_of = [group_of[a] if g == group_of[b] else g for g in group_of]
    return [tuple(s for s, g in enumerate(group_of) if g == number) for number in dict.fromkeys(group_of)]


def _combine(
    assembler: Assembler,
    slides: Slides,
    vectors: Mapping[tuple[int, int], Array],
    first: tuple[int, int],
    second: tuple[int, int],
) -> bool:
    """Return whether the vector with the patches of two sliders at a position is the one that assembly gives
    for both.
    """
    model = assembler.at(slides, moved_setting(slides, dict((first, second))))
    # The rows of both patches are disjoint here, so the order in which they are written does not matter.
    patched = np.where(changed_bits(vectors[first], assembler.base.vector), vectors[first], vectors[second])
    return model is not None and not changed_bits(patched, model.vector).any()


def vector_at(assembler: Assembler, slides: Slides, moves: Mapping[int, int]) -> Array:
    """Return the numbers at a setting; those of the model if it cannot be run, as if it changed nothing."""
    return (assembler.at(slides, moved_setting(slides, moves)) or assembler.base).vector


def moves_singly(sliders: tuple[int, ...]) -> bool:
    """Return whether these sliders move one at a time, because each would have fewer than ``FEWEST``
    positions in their combinations.
    """
    return len(sliders) > 1 and GROUP_COMBINATIONS ** (1.0 / len(sliders)) < FEWEST


def combinations(slides: Sequence[Slide], sliders: tuple[int, ...], singly: bool) -> list[tuple[int, ...]]:
    """Return the combinations of positions of a group that are assembled, the model's own first if sliders
    move singly.
    """
    if not singly:
        return list(itertools.product(*(range(len(slides[s].values)) for s in sliders)))
    own_setting = tuple(slides[s].here for s in sliders)
    moved_settings = [
        (*own_setting[:i], k, *own_setting[i + 1 :])
        for i, s in enumerate(sliders)
        for k in range(len(slides[s].values))
        if k != own_setting[i]
    ]
    return [own_setting, *moved_settings]


def fewer_positions(slides: Slides, groups: Sequence[tuple[int, ...]]) -> Slides:
    """Return sliders without the positions by which a group would have more than ``GROUP_COMBINATIONS``
    combinations; none of them has fewer than ``FEWEST``, unless it had before (:func:`moves_singly`).

    The positions are evenly spaced, except that the model's own replaces the nearest one.
    """
    thinned = list(slides)
    for sliders in groups:
        limit = (
            # The n-th root gives all sliders of a group the same number of positions.
            int(GROUP_COMBINATIONS ** (1.0 / len(sliders)))
            if len(sliders) > 1 and not moves_singly(sliders)
            else POSITIONS + 1
        )
        for s in sliders:
            if len(thinned[s].values) > limit and not (thinned[s].complete and len(sliders) == 1):
                thinned[s] = with_positions(thinned[s], thinned_positions(thinned[s], limit))
    return tuple(thinned)


def group(assembler: Assembler, slides: Slides, sliders: tuple[int, ...]) -> Group:
    """Return the patches of a group."""
    base, lines, singly = assembler.base.vector, assembler.text.splitlines(), moves_singly(sliders)
    settings = (
        moved_setting(slides, dict(zip(sliders, at, strict=True)))
        for at in combinations(slides, sliders, singly)
    )
    # ``usable_positions`` has left out positions that fail by themselves. A combination that fails although
    # its positions do not gets an empty patch, so that the page runs the model itself there.
    models = [assembler.at(slides, positions) or assembler.base for positions in settings]
    changed = np.zeros(len(base), dtype=bool)
    for model in models:
        changed |= changed_bits(model.vector, base)
    rows = np.flatnonzero(changed)
    texts = [dump(model.assembly.mechanism).splitlines() for model in models]
    return Group(
        sliders,
        singly,
        rows,
        np.array([model.vector[rows] for model in models]),
        tuple(changed_lines(lines, text) for text in texts),
    )


def changed_lines(lines: list[str], text: list[str]) -> dict[int, str | None]:
    """Return the lines of ``text`` that differ from ``lines``, by number; None for a removed line, several
    for an insertion.
    """
    changes: dict[int, str | None] = {}
    for change, i, j, m, n in SequenceMatcher(None, lines, text, autojunk=False).get_opcodes():
        # Inserted lines have no number in the file of the model, so they are appended to the line before
        # them.
        if change == "insert":
            changes[i - 1] = "\n".join([changes.get(i - 1) or lines[i - 1], *text[m:n]])
        elif change != "equal":
            changes |= dict.fromkeys(range(i, j))
            changes[i] = "\n".join(text[m:n]) if n > m else None
    return changes


def random_settings(patches: SliderPatches, assembler: Assembler) -> Iterator[tuple[Setting, PageModel]]:
    """Yield ``CHECKED`` settings of all sliders, the same in every run, and what assembly gives for them."""
    draw = random.Random(1)
    for _ in range(CHECKED):
        positions = [draw.randrange(len(slide.values)) for slide in patches.slides]
        # In a group whose sliders move singly, one slider keeps its random position and the others return to
        # the model's own.
        for group in patches.groups:
            for s in set(group.sliders) - {draw.choice(group.sliders)} if group.singly else ():
                positions[s] = patches.slides[s].here
        if (model := assembler.at(patches.slides, tuple(positions))) is not None:
            yield tuple(positions), model


def counterexample(patches: SliderPatches, assembler: Assembler) -> Setting | None:
    """Return a random setting at which patches differ from assembly in a bit; None if there is none."""
    return next(
        (
            positions
            for positions, model in random_settings(patches, assembler)
            if changed_bits(patches.vector(positions), model.vector).any()
        ),
        None,
    )


def notes_on_start(mechanism: Mechanism) -> list[str]:
    """Return a sentence on journals that fall at the start of a page's run; none where none start free."""
    if not (joints := falling_journals(mechanism)):
        return []
    part = "" if turn_of(mechanism) is None else " of the first turn"
    return [
        f"Largest values{part} may be those of the start, where the journals of {and_words(joints)} fall onto"
        f" their bearings. {fall_remedy(mechanism, joints, turns=False)}"
    ]
