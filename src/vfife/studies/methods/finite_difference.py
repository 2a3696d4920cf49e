"""Models with one number changed: neighbours of a run for its derivatives, and finite changes that check
them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from statistics import linear_regression
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...assembly.assemble import assemble
from ...assembly.assembled import Assembly
from ...assembly.reassemble import reassembled
from ...errors import VfifeError
from ...measures.catalogue import BY_TURN, Groups, compared, over_turn
from ...measures.turns import last_turn
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import loads
from ...modelfile.parameter import Parameter, holds
from ...results.derivatives import Derivative, Kind
from ...solvers.companions import measured_rows
from ...solvers.ensemble import StepSize, measures_of
from ...solvers.record import Record, recorded_rows
from ...solvers.tangents import Neighbours

NEIGHBOUR_SHARE = 1e-5  # of a number, on both sides, at which its neighbours are assembled
# Numbers that may be starting guesses, and the share of their change that the tolerance of a solved position
# leaves of it.
POSITION = re.compile(r"body\..+\.(?:position\.[01]|angle)")
SOLVED = 1e-3
Share: TypeAlias = tuple[str, float]  # a path and the share by which its number is changed
Values: TypeAlias = Mapping[str, float]
Span: TypeAlias = tuple[float, float]


class Direction(NamedTuple):
    """A number of the model by which measures are differentiated: its value (SI) and the models to both sides
    of it.
    """

    path: str
    value: float
    neighbours: Neighbours

    def with_size(self, size: StepSize) -> Direction:
        """Return it with another step size."""
        pair = self.neighbours
        return self._replace(neighbours=Neighbours(size.of(pair.up), size.of(pair.down), pair.distance))


def is_guess(direction: Direction) -> bool:
    """Return whether a number only begins the search for a position that joints and drivers decide.

    The neighbours are then one state but for the tolerance of the search.
    """
    pair = direction.neighbours
    if not POSITION.fullmatch(direction.path) or pair.up.state.shape != pair.down.state.shape:
        return False
    return bool(np.abs(pair.up.state - pair.down.state).max() <= SOLVED * pair.distance)


@dataclass(frozen=True)
class Variants:
    """The model of ``text`` with one other number at a time, assembled for as many steps as ``assembly``,
    each the same part of a turn.

    ``ideal``: without clearance, as ``assembly`` then is, while ``text`` has it.
    """

    text: str
    assembly: Assembly
    ideal: bool = False

    def with_number(self, path: str, value: float, changed: float) -> Assembly:
        """Assemble the model with ``changed`` in place of ``value`` (SI). Raises VfifeError.

        Numbers of a clearance joint change its contact rows alone, in most mechanisms: these are replaced in
        the assembly.
        """
        base = self.assembly
        if not holds(base.mechanism, path, value):
            mechanism = loads(self.text, set=[(path, changed)])
            return with_same_steps(mechanism.ideal() if self.ideal else mechanism, base)
        mechanism = Parameter(base.mechanism, path).set(changed)
        if path.startswith("joint.") and path.split(".")[1] in base.contacts:
            with suppress(ValueError):
                # The four contacts of a block in a guide have other names.
                if all(name in mechanism.contacts for name in base.contacts):
                    return reassembled(base, {name: mechanism.contacts[name] for name in base.contacts})
        return with_same_steps(mechanism, base)

    def neighbours(self, path: str, value: float) -> Neighbours:
        """Assemble the models to both sides of a number, or to one side and the model itself. Raises
        VfifeError where there is neither.
        """
        models: list[tuple[float, Assembly]] = []
        errors = []
        for sign in (1.0, -1.0):
            try:
                models.append(
                    (sign, self.with_number(path, value, value + sign * NEIGHBOUR_SHARE * abs(value)))
                )
            except VfifeError as error:
                errors.append(error)
        if not models:
            raise errors[-1]
        if errors:
            models.append((0.0, self.assembly))
            models.sort(key=lambda model: -model[0])
        (upper, up), (lower, down) = models
        return Neighbours(up, down, (upper - lower) * NEIGHBOUR_SHARE * abs(value))

    def directions(self, chosen: Values) -> tuple[list[Direction], dict[str, str]]:
        """Return the numbers with their neighbours; and of those that cannot be assembled, the reason."""
        directions = []
        refused = {
            path: "zero, of which there is no small part" for path, value in chosen.items() if value == 0.0
        }
        for path, value in chosen.items():
            if path in refused:
                continue
            try:
                directions.append(Direction(path, value, self.neighbours(path, value)))
            except VfifeError as error:
                refused[path] = str(error).strip().splitlines()[-1].strip()
        return directions, refused

    def finite(self, chosen: Values) -> dict[Share, Assembly]:
        """Assemble the model with each number changed by each of ``SHARES``, where the model allows it."""
        variants: dict[Share, Assembly] = {}
        for path, value in chosen.items():
            for share in SHARES:
                with suppress(ValueError):  # beyond a limit, or no longer a mechanism: the other side remains
                    variants[path, share] = self.with_number(path, value, value + share * abs(value))
        return variants

    def has(self, path: str, value: float) -> bool:
        """Return whether the model has a number; the ideal one has none of clearance joints."""
        return not path.startswith("joint.") or holds(self.assembly.mechanism, path, value)


def with_same_steps(mechanism: Mechanism, assembly: Assembly) -> Assembly:
    """Assemble a mechanism for as many steps as another one, each the same part of a turn."""
    choice, turn = assembly.choice, turn_of(mechanism)
    scale = turn / choice.turn if turn is not None and choice.turn is not None else 1.0
    length: dict[str, Any] = {"duration": choice.step * scale * choice.steps} if choice.turn is None else {
        "turns": choice.steps * choice.step / choice.turn
    }  # fmt: skip
    length |= {"outputs": assembly.mechanism.settings.outputs, "force_step": True}
    variant = assemble(mechanism, choice.step * scale, **length)
    return replace(variant, layout=assembly.layout) if variant.topology == assembly.topology else variant


@dataclass(frozen=True)
class LastTurn:
    """Some measures of the last turn of a run; those against the ideal mechanism with its own as
    ``reference``.
    """

    measures: Groups

    @property
    def extremes(self) -> bool:
        """Whether all of them are extremes and totals, for which a turn may be one output."""
        return set(self.measures) <= set(BY_TURN)

    def rows(self, assembly: Assembly) -> NDArray[np.uint32]:
        """Return the rows of the state that they need."""
        return measured_rows(assembly) if self.extremes else recorded_rows(assembly)

    def __call__(self, record: Record, reference: Values | None = None) -> dict[str, float]:
        """Return the measures of a record."""
        values = over_turn(record, last_turn(record), self.measures)
        return values | compared(record, values, reference)


# Relative changes of a number: the one that users have in mind, and one over which a curve is nearly
# straight.
WIDE, CLOSE = 0.01, 0.001
SHARES = tuple(sign * share for share in (WIDE, CLOSE) for sign in (1.0, -1.0))
# A derivative agrees with a change that lies within this share of it outside its range: the curvature of a
# smooth measure over 1 %.
CURVATURE = 0.02
# Of the largest effect on a measure: a smaller disagreement matters to nobody, and is covered by the range.
INSIGNIFICANT = 1e-3
# Of the largest effect on a measure: step sizes that agree on less may do so by chance, and the range reaches
# as much further, but no more than a few times its own width. Of 344 derivatives of the gallery one, a five-
# thousandth of the largest, was outside without it.
LEAST_AGREEMENT, WIDTHS = 1e-4, 5.0
# A range whose ends are further apart than this factor is that of a motion that is nearly chaotic: it may be
# wider still at finer steps.
FACTOR = 5.0
# Of a smooth measure the changes to both sides, over those of the number, differ in proportion to their size.
# Those of 0.1 % may differ by twice that.
STRAIGHTER = 2.0 * CLOSE / WIDE
# Fewer step sizes give no range: a very short run, or one whose coarser steps diverge.
LEAST_SIZES = 3


@dataclass(frozen=True)
class FiniteChanges:
    """Measures of a model and of its variants, at each of several step sizes; None where a run did not come
    to its end.

    ``unchanged``: of the model itself. ``changed``: of the model with a number changed by a share. A
    variant that cannot be assembled is missing. ``steps``: sizes of the steps, in any unit.
    """

    unchanged: Sequence[Values | None]
    changed: Mapping[Share, Sequence[Values | None]]
    steps: Sequence[float] = ()

    def quotients(self, measure: str, path: str, value: float, share: float) -> list[float]:
        """Return the change of a measure over the change of the number, at each step size at which both are
        known; ``share`` has a sign.
        """
        pairs = zip(self.unchanged, self.changed.get((path, share), ()), strict=False)
        return [
            (changed[measure] - unchanged[measure]) / (share * abs(value))
            for unchanged, changed in pairs
            if unchanged and changed and measure in unchanged and measure in changed
        ]

    def central(self, measure: str, path: str, value: float, share: float) -> list[float]:
        """Return central quotients at each step size, or those to one side where the number may go to one
        side only.
        """
        up, down = (self.quotients(measure, path, value, sign * share) for sign in (1.0, -1.0))
        if not up or not down:
            return up or down
        return [0.5 * (forward + backward) for forward, backward in zip(up, down, strict=False)]

    def unevenness(self, measure: str) -> float:
        """Return by how much a measure of the model scatters about a straight line over the step size."""
        pairs = zip(self.steps, self.unchanged, strict=False)
        points = [(step, measures[measure]) for step, measures in pairs if measures and measure in measures]
        if len(points) < LEAST_SIZES:
            return 0.0
        steps, values = zip(*points, strict=True)
        slope, level = linear_regression(steps, values)
        residuals = [value - slope * step - level for step, value in points]
        return (max(residuals) - min(residuals)) * math.sqrt(len(residuals) / (len(residuals) - 2))

    def largest(self, measure: str, chosen: Values) -> float:
        """Return the largest change of a measure by 100 % of one of the numbers, at the run's own step."""
        central = (self.central(measure, path, value, WIDE) for path, value in chosen.items())
        changes = (
            abs(quotients[0] * value)
            for quotients, value in zip(central, chosen.values(), strict=True)
            if quotients
        )
        return max(changes, default=0.0)


def ideal_references(
    variants: Variants, chosen: Values, look: Callable[[Record], Values]
) -> dict[Share, Values | None]:
    """Run the ideal mechanism with each finite change of a number that it has; return its measures."""
    ideals = variants.finite({path: value for path, value in chosen.items() if variants.has(path, value)})
    rows = recorded_rows(variants.assembly)
    return dict(
        zip(
            ideals,
            measures_of([(assembly, rows, look) for assembly in ideals.values()], merged=True),
            strict=True,
        )
    )


def finite_changes(
    variants: Variants,
    chosen: Values,
    sizes: Sequence[StepSize],
    measures: LastTurn,
    reference: Values | None,
    ideals: Mapping[Share, Values | None],
    progress: Callable[[int, int], None] | None = None,
) -> FiniteChanges:
    """Run a model, and it with finite changes of the numbers ``chosen``, at each step size, all in lanes.

    ``reference`` and ``ideals``: measures of the ideal mechanism, and of it with the same changes.
    ``progress(done, total)`` is called after each run.
    """
    changed = variants.finite(chosen)
    models: list[tuple[Share | None, Assembly]] = [(None, variants.assembly), *changed.items()]
    rows, tasks = measures.rows(variants.assembly), []
    # Runs with one step stay in phase: contacts begin in all lanes of a register at nearly the same time.
    for size in sizes:
        for share, assembly in models:
            ideal_values = reference if share is None else ideals.get(share, reference)
            tasks.append((size.of(assembly), rows, partial(measures, reference=ideal_values)))
    values = measures_of(tasks, merged=measures.extremes, progress=progress)
    own_values, *changed_values = (values[k :: len(models)] for k in range(len(models)))
    steps = [1.0 / size.steps for size in sizes]
    return FiniteChanges(own_values, dict(zip(changed, changed_values, strict=True)), steps)


def compared_with_changes(
    derivative: Derivative,
    slopes: Mapping[str, Sequence[float]],
    changes: FiniteChanges,
    sizes: Mapping[str, float],
) -> Derivative:
    """Return a derivative with its ranges and how far each measure is known.

    ``slopes``: derivatives of each measure by displaced runs and step sizes. ``sizes``: of each measure, the
    largest change that one of all numbers makes (measure's unit for 100 %), beside which a disagreement may
    be insignificant.
    """
    ranges: dict[str, Span] = {}
    quotients: dict[str, float] = {}
    spans: dict[str, Span] = {}
    kinds: dict[str, Kind] = {}
    for name in derivative.values:
        wide, close = (
            changes.central(name, derivative.path, derivative.value, share) for share in (WIDE, CLOSE)
        )
        sides = [
            changes.quotients(name, derivative.path, derivative.value, sign * WIDE) for sign in (1.0, -1.0)
        ]
        negligible = INSIGNIFICANT * sizes.get(name, 0.0) / abs(derivative.value)
        # A peak that falls between two steps follows a number as a saw does: its teeth have a slope that no
        # step size changes, and jumps as high as the measure scatters over steps. If no change of 1 % meets a
        # jump, the slope over many teeth may still differ by one jump over the distance of both changes.
        jump = changes.unevenness(name) / (2.0 * WIDE * abs(derivative.value))
        ranges[name], holds = agreement(slopes[name], wide, close, negligible, jump)
        if holds and not is_smooth(changes, derivative, name, widened(slopes[name]), negligible):
            ranges[name], holds = widened(slopes[name]), False
        if wide:
            quotients[name] = wide[0]
            spans[name] = reaching(hull([widened(side) for side in sides if side]), jump)
        clear = all(sure(widened(side)) for side in sides if side)
        certain = len(wide) >= LEAST_SIZES and same_sign(spans[name]) and clear
        kinds[name] = "derivative" if holds and sure(ranges[name]) else "change" if certain else "unknown"
        if clear and contradicts(changes, derivative, name, negligible):
            kinds[name] = "unknown"
    return Derivative(
        derivative.path, derivative.value, derivative.values, ranges, quotients, spans, kinds, derivative.runs
    )


def agreement(
    slopes: Sequence[float],
    wide: Sequence[float],
    close: Sequence[float],
    negligible: float,
    jump: float = 0.0,
) -> tuple[Span, bool]:
    """Return the range of a derivative, and whether changes of 1 % (``wide``) and 0.1 % (``close``) agree
    with it.

    ``slopes``, ``wide`` and ``close`` are the same quantity at several step sizes. The range of each is
    widened on both sides by its own width. They agree where these ranges overlap, or miss each other by less
    than the curvature of a smooth measure, or by ``negligible``. Changes of 0.1 % scatter ten times as much
    with the steps as those of 1 %: they join the range only where they are as narrow. ``jump``: by how much
    the quantity may jump where a peak passes from one step to the next.
    """
    tangent_range = widened(slopes)
    if min(len(slopes), len(wide), len(close)) < LEAST_SIZES:
        return tangent_range, False
    margin = max(CURVATURE * max(abs(tangent_range[0]), abs(tangent_range[1])), negligible)
    holds = all(overlap(tangent_range, widened(quotients), margin) for quotients in (wide, close))
    if not holds:
        return tangent_range, False
    low, high = hull([tangent_range, widened(wide)])
    close_range = widened(close)
    if close_range[1] - close_range[0] <= high - low + margin:
        low, high = hull([(low, high), close_range])
    return reaching((low, high), LEAST_AGREEMENT / INSIGNIFICANT * negligible + jump), True


def is_smooth(
    changes: FiniteChanges, derivative: Derivative, measure: str, tangent_range: Span, negligible: float
) -> bool:
    """Return whether a measure is smooth where its changes of 1 % to both sides differ in sign, or in size by
    more than :data:`FACTOR`; true where they do not.

    Their mean may agree with the derivative by chance: a jump to one side hides in it. Near the extremum of a
    smooth measure, changes of 0.1 % differ by a tenth as much, and each agrees with the derivative.
    ``tangent_range`` has the derivatives at all step sizes, ``negligible`` is a change of no import.
    """
    wide, close = (
        [
            side
            for sign in (1.0, -1.0)
            if (side := changes.quotients(measure, derivative.path, derivative.value, sign * share))
        ]
        for share in (WIDE, CLOSE)
    )
    low, high = hull([(min(side), max(side)) for side in wide])
    if sure((low, high)) or high - low <= negligible:
        return True
    margin = max(STRAIGHTER * (high - low), negligible)
    return all(overlap(tangent_range, (min(side), max(side)), margin) for side in close)


def contradicts(changes: FiniteChanges, derivative: Derivative, measure: str, negligible: float) -> bool:
    """Return whether a change of 0.1 % moves a measure to where the change of 1 % to the same side does not:
    against it, or further than it.

    The measure then jumps between nearby values, and the result of 1 % is one draw of several. The margin is
    a tenth of the change of 1 %, which is what 0.1 % makes of a straight line, or ``negligible``.
    """
    part = CLOSE / WIDE
    for sign in (1.0, -1.0):
        wide, close = (
            changes.quotients(measure, derivative.path, derivative.value, sign * share)
            for share in (WIDE, CLOSE)
        )
        if wide:
            low, high = hull([(0.0, 0.0), widened(wide)])
            margin = max(part * max(-low, high), negligible)
            if any(not low - margin <= part * quotient <= high + margin for quotient in close):
                return True
    return False


def widened(values: Sequence[float]) -> Span:
    """Return the range of values, widened on both sides by its own width."""
    low, high = min(values), max(values)
    return low - (high - low), high + (high - low)


def reaching(span: Span, reach: float) -> Span:
    """Return a range that reaches further on both sides, but no more than a few times its own width."""
    low, high = span
    reach = min(reach, WIDTHS * (high - low))
    return low - reach, high + reach


def hull(spans: Sequence[Span]) -> Span:
    """Return the range that has all of some ranges."""
    return min(low for low, _ in spans), max(high for _, high in spans)


def overlap(first: Span, second: Span, margin: float) -> bool:
    """Return whether two ranges have a point in common, or miss each other by no more than a margin."""
    return first[0] - margin <= second[1] and second[0] - margin <= first[1]


def same_sign(span: Span) -> bool:
    """Return whether a range leaves no doubt about the sign, or is nothing but zero."""
    return span[0] > 0.0 or span[1] < 0.0 or span == (0.0, 0.0)


def sure(span: Span) -> bool:
    """Return whether a range says what sign and what order of magnitude a quantity has."""
    small, large = sorted(map(abs, span))
    return same_sign(span) and large <= FACTOR * small
