"""A model with one other number each: neighbours of a run for derivatives, and finite changes that
derivatives are compared with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...assembly.assemble import assemble, reassembled
from ...assembly.assembled import Assembly
from ...errors import VfifeError
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile import loads
from ...modelfile.parameter import Parameter, holds
from ...results.derivatives import Derivative, Kind
from ...solvers.ensemble import Look, StepSize, measures_of
from ...solvers.record import Record, recorded_rows
from ...solvers.tangents import Neighbours

NEAR = 1e-5  # of a number, on both sides, at which its neighbours are assembled


@dataclass(frozen=True)
class Way:
    """A number of the model, its value (SI) and the models to both sides."""

    path: str
    value: float
    near: Neighbours


def neighbours(
    text: str, chosen: Mapping[str, float], assembly: Assembly
) -> tuple[list[Way], dict[str, str]]:
    """The models to both sides of each number; and of those that cannot be assembled, why."""
    ways, refused = (
        [],
        {path: "zero, of which there is no small part" for path, value in chosen.items() if value == 0.0},
    )
    for path, value in chosen.items():
        if path in refused:
            continue
        try:
            ways.append(Way(path, value, beside(text, path, value, assembly)))
        except VfifeError as error:
            refused[path] = str(error).strip().splitlines()[-1].strip()
    return ways, refused


def beside(text: str, path: str, value: float, assembly: Assembly, *, ideal: bool = False) -> Neighbours:
    """A number a little larger and a little smaller; where only one of them is a mechanism, that and the
    model itself.

    ``ideal``: of the mechanism without its play, which ``assembly`` is then of, while ``text`` has it.
    """
    models: list[tuple[float, Assembly]] = []
    trouble: VfifeError | None = None
    for sign in (1.0, -1.0):
        try:
            models.append(
                (sign, placed(text, path, value, value + sign * NEAR * abs(value), assembly, ideal=ideal))
            )
        except VfifeError as error:
            trouble = error
    if trouble is not None and not models:
        raise trouble
    if trouble is not None:
        models.append((0.0, assembly))
        models.sort(key=lambda one: -one[0])
    (above, up), (below, down) = models
    return Neighbours(up, down, (above - below) * NEAR * abs(value))


def placed(
    text: str, path: str, was: float, value: float, assembly: Assembly, *, ideal: bool = False
) -> Assembly:
    """The model with another number, assembled for as many steps, each the same part of a turn."""
    if not holds(assembly.mechanism, path, was):
        mechanism = loads(text, set=[(path, value)])
        return alike(mechanism.ideal() if ideal else mechanism, assembly)
    mechanism = Parameter(assembly.mechanism, path).set(value)
    if path.startswith("joint.") and path.split(".")[1] in assembly.contacts:
        with suppress(
            ValueError
        ):  # numbers of play reach the rows of their contact alone, in most mechanisms
            if all(
                name in mechanism.contacts for name in assembly.contacts
            ):  # a block in a guide has four contacts with names of their own
                return reassembled(assembly, {name: mechanism.contacts[name] for name in assembly.contacts})
    return alike(mechanism, assembly)


def alike(mechanism: Mechanism, assembly: Assembly) -> Assembly:
    """A mechanism assembled for as many steps as another one, each the same part of a turn."""
    choice, turn = assembly.choice, turn_of(mechanism)
    scale = turn / choice.turn if turn is not None and choice.turn is not None else 1.0
    length: dict[str, Any] = {"duration": choice.step * scale * choice.steps} if choice.turn is None else {
        "turns": choice.steps * choice.step / choice.turn
    }  # fmt: skip
    outputs = assembly.mechanism.settings.outputs
    found = assemble(mechanism, choice.step * scale, outputs=outputs, force_step=True, **length)
    return replace(found, layout=assembly.layout) if found.topology == assembly.topology else found


WIDE, CLOSE = (
    0.01,
    0.001,
)  # of a number: the change that users have in mind, and one at which a curve is nearly straight
SHARES = tuple(sign * share for share in (WIDE, CLOSE) for sign in (1.0, -1.0))
# A derivative agrees with a change that lies within this share of it outside its range: the curvature of a
# smooth measure over 1 %.
CURVATURE = 0.02
# Of the largest effect on a measure: a smaller disagreement matters to nobody, and is covered by the range.
INSIGNIFICANT = 1e-3
# Of the largest effect on a measure: step sizes that agree on less may do so by chance, and the range reaches
# as much further, but no more
# than a few times its own width. Of 344 derivatives of the gallery one, a five-thousandth of the largest, was
# outside without it.
LEAST_KNOWN, WIDTHS = 1e-4, 5.0
# A range whose ends are further apart than this factor is that of a motion that is nearly chaotic: it may be
# wider still at finer steps.
FACTOR = 5.0
# Fewer step sizes give no range: a very short run, or one whose coarser steps diverge.
LEAST_SIZES = 3

Share: TypeAlias = tuple[str, float]  # a path and the share by which its number is changed
Values: TypeAlias = Mapping[str, float]
Span: TypeAlias = tuple[float, float]


class Measured(Protocol):
    """Measures of the last turn of a record; those against the ideal mechanism with its own as
    ``reference``.
    """

    def __call__(self, record: Record, *, reference: Values | None) -> Values:
        """Take them."""


@dataclass(frozen=True)
class FiniteChanges:
    """Measures of a model and of its variants, at each of several step sizes; None where a run did not come
    to its end.

    ``own``: of the model itself. ``changed``: of the model with a number changed by a share. A variant that
    cannot be assembled is missing.
    """

    own: Sequence[Values | None]
    changed: Mapping[Share, Sequence[Values | None]]

    def quotients(self, measure: str, path: str, value: float, share: float) -> list[float]:
        """Return the change of a measure over the change of the number, at each step size at which both
        are known; ``share`` has a sign.
        """
        found = []
        for own, other in zip(self.own, self.changed.get((path, share), ()), strict=False):
            if own is not None and other is not None and measure in own and measure in other:
                found.append((other[measure] - own[measure]) / (share * abs(value)))
        return found

    def central(self, measure: str, path: str, value: float, share: float) -> list[float]:
        """Return central quotients at each step size, or those to one side where the number may go to one
        side only.
        """
        up, down = (self.quotients(measure, path, value, sign * share) for sign in (1.0, -1.0))
        if not up or not down:
            return up or down
        return [0.5 * (one + other) for one, other in zip(up, down, strict=False)]


def assembled(text: str, chosen: Mapping[str, float], base: Assembly) -> dict[Share, Assembly]:
    """Return the variants of a model with each number of ``chosen`` changed by each of ``SHARES``; none
    where the model does not allow it.
    """
    found: dict[Share, Assembly] = {}
    for path, value in chosen.items():
        for share in SHARES:
            with suppress(ValueError):  # beyond a limit, or no longer a mechanism: the other side remains
                found[path, share] = placed(text, path, value, value + share * abs(value), base)
    return found


def references(
    text: str, chosen: Mapping[str, float], ideal: Assembly, peaks: Look
) -> dict[Share, Values | None]:
    """Return the largest values of the ideal mechanism for each change of a number that it has."""
    variants: dict[Share, Assembly] = {}
    for path, value in chosen.items():
        if path.startswith("joint.") and not holds(ideal.mechanism, path, value):
            continue  # a number of the clearance
        for share in SHARES:
            try:
                variants[path, share] = placed(
                    text, path, value, value + share * abs(value), ideal, ideal=True
                )
            except (VfifeError, ValueError):
                continue
    rows = recorded_rows(ideal)
    return dict(
        zip(variants, measures_of([(one, rows, peaks) for one in variants.values()], whole=True), strict=True)
    )


def finite_changes(
    base: Assembly,
    variants: Mapping[Share, Assembly],
    sizes: Sequence[StepSize],
    rows: NDArray[np.uint32],
    measured: Measured,
    ideals: Mapping[Share, Values | None],
    reference: Values | None,
    *,
    whole: bool,
) -> FiniteChanges:
    """Run a model and its variants at each step size, side by side. ``rows`` of the state are those that
    ``measured`` needs.

    ``whole``: all measures are of extremes and totals.
    """
    keys: list[Share | None] = [None, *variants]
    tasks = []
    for size in (
        sizes
    ):  # runs with one step stay in phase: contacts begin in all lanes of a register at nearly the same time
        for key in keys:
            assembly = base if key is None else variants[key]
            own = reference if key is None else ideals.get(key, reference)
            tasks.append((size.of(assembly), rows, partial(measured, reference=own)))
    values = measures_of(tasks, whole=whole)
    each = {key: values[k :: len(keys)] for k, key in enumerate(keys)}
    return FiniteChanges(each[None], {key: each[key] for key in variants})


def compared(
    found: Derivative,
    slopes: Mapping[str, Sequence[float]],
    changes: FiniteChanges,
    sizes: Mapping[str, float],
) -> Derivative:
    """Return a derivative with its ranges and what is known of each measure.

    ``slopes``: derivatives of each measure by displaced runs and step sizes. ``sizes``: of each measure, the
    largest change that one of all numbers makes (measure's unit for 100 %), beside which a disagreement may
    be insignificant.
    """
    ranges: dict[str, Span] = {}
    quotients: dict[str, float] = {}
    spans: dict[str, Span] = {}
    kinds: dict[str, Kind] = {}
    for name in found.values:
        wide, close = (changes.central(name, found.path, found.value, share) for share in (WIDE, CLOSE))
        sides = [changes.quotients(name, found.path, found.value, sign * WIDE) for sign in (1.0, -1.0)]
        little = INSIGNIFICANT * sizes.get(name, 0.0) / abs(found.value)
        ranges[name], holds = agreement(slopes[name], wide, close, little)
        if wide:
            quotients[name], spans[name] = wide[0], hull([widened(side) for side in sides if side])
        certain = (
            len(wide) >= LEAST_SIZES
            and same_sign(spans[name])
            and all(sure(widened(side)) for side in sides if side)
        )
        kinds[name] = "derivative" if holds and sure(ranges[name]) else "change" if certain else "unknown"
    return Derivative(found.path, found.value, found.values, ranges, quotients, spans, kinds, found.runs)


def agreement(
    slopes: Sequence[float], wide: Sequence[float], close: Sequence[float], little: float
) -> tuple[Span, bool]:
    """Return the range of a derivative, and whether changes of 1 % (``wide``) and 0.1 % (``close``) agree
    with it.

    ``slopes``, ``wide`` and ``close`` are the same quantity at several step sizes. The range of each is
    widened on both sides by its own width. They agree where these ranges overlap, or miss each other by less
    than the curvature of a smooth measure, or by ``little``. Changes of 0.1 % scatter ten times as much with
    the steps as those of 1 %: they join the range only where they are as narrow.
    """
    own = widened(slopes)
    if min(len(slopes), len(wide), len(close)) < LEAST_SIZES:
        return own, False
    margin = max(CURVATURE * max(abs(own[0]), abs(own[1])), little)
    holds = all(overlap(own, widened(one), margin) for one in (wide, close))
    if not holds:
        return own, False
    found = hull([own, widened(wide)])
    narrow = widened(close)
    found = hull([found, narrow]) if narrow[1] - narrow[0] <= found[1] - found[0] + margin else found
    reach = min(LEAST_KNOWN / INSIGNIFICANT * little, WIDTHS * (found[1] - found[0]))
    return (found[0] - reach, found[1] + reach), True


def widened(values: Sequence[float]) -> Span:
    """Return the range of values, widened on both sides by its own width."""
    low, high = min(values), max(values)
    return low - (high - low), high + (high - low)


def hull(spans: Sequence[Span]) -> Span:
    """Return the range that has all of some ranges."""
    return min(low for low, _ in spans), max(high for _, high in spans)


def overlap(one: Span, other: Span, margin: float) -> bool:
    """Return whether two ranges have a point in common, or miss each other by no more than a margin."""
    return one[0] - margin <= other[1] and other[0] - margin <= one[1]


def same_sign(span: Span) -> bool:
    """Return whether a range leaves no doubt about the sign, or is nothing but zero."""
    return span[0] > 0.0 or span[1] < 0.0 or span == (0.0, 0.0)


def sure(span: Span) -> bool:
    """Return whether a range says what sign and what order of magnitude a quantity has."""
    small, large = sorted(map(abs, span))
    return same_sign(span) and large <= FACTOR * small
