"""Finite changes of the numbers of a model, and whether derivatives agree with them.

A derivative of a run is that of its steps. It is worthless to a user where the motion is chaotic (it grows
without end), where an impact is missed a hundredth of a clearance further on, or where a kink of friction
lies in one step. So every derivative is compared with the change of the measure when the number is changed by
1 % and by 0.1 %, both ways, and with derivatives and changes at other step sizes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..modelfile.numbered import with_number
from ..results.derivatives import Derivative, Kind
from ..solvers.record import Record, recorded_rows
from ..solvers.variants import Look, StepSize, measures_of
from .nearby import nearby
from .neighbours import placed

WIDE, CLOSE = 0.01, 0.001  # of a number: the change that users have in mind, and one at which a curve is nearly straight
SHARES = tuple(sign * share for share in (WIDE, CLOSE) for sign in (1.0, -1.0))
# A derivative agrees with a change that lies within this share of it outside its range: the curvature of a
# smooth measure over 1 %.
CURVATURE = 0.02
# Of the largest effect on a measure: a smaller disagreement matters to nobody, and is covered by the range.
INSIGNIFICANT = 1e-3
# Of the largest effect on a measure: step sizes that agree on less may do so by chance, and the range reaches as much further, but no more
# than a few times its own width. Of 344 derivatives of the gallery one, a five-thousandth of the largest, was outside without it.
LEAST_KNOWN, WIDTHS = 1e-4, 5.0
# A range whose ends are further apart than this factor is that of a motion that is nearly chaotic: it may be
# wider still at finer steps.
FACTOR = 5.0
# Fewer step sizes give no range: a very short run, or one whose coarser steps diverge.
LEAST_SIZES = 3

Change: TypeAlias = tuple[str, float]  # a path and the share by which its number is changed
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
    changed: Mapping[Change, Sequence[Values | None]]

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


def assembled(text: str, chosen: Mapping[str, float], base: Assembly) -> dict[Change, Assembly]:
    """Return the variants of a model with each number of ``chosen`` changed by each of ``SHARES``; none
    where the model does not allow it.
    """
    changes = [(path, value + share * abs(value), share) for path, value in chosen.items() for share in SHARES]
    made = nearby(text, chosen, [(path, value) for path, value, _ in changes], base)
    found: dict[Change, Assembly] = {}
    for (path, value, share), one in zip(changes, made, strict=True):
        try:
            found[path, share] = one or placed(text, path, chosen[path], value, base)
        except (VfifeError, ValueError):  # beyond a limit, or no longer a mechanism: the other side remains
            continue
    return found


def references(text: str, chosen: Mapping[str, float], ideal: Assembly, peaks: Look) -> dict[Change, Values | None]:
    """Return the largest values of the ideal mechanism for each change of a number that it has."""
    variants: dict[Change, Assembly] = {}
    for path, value in chosen.items():
        if path.startswith("joint.") and with_number(ideal.mechanism, path, value, value) is None:
            continue  # a number of the clearance
        for share in SHARES:
            try:
                variants[path, share] = placed(text, path, value, value + share * abs(value), ideal, ideal=True)
            except (VfifeError, ValueError):
                continue
    rows = recorded_rows(ideal)
    return dict(zip(variants, measures_of([(one, rows, peaks) for one in variants.values()], whole=True), strict=True))


def finite_changes(
    base: Assembly,
    variants: Mapping[Change, Assembly],
    sizes: Sequence[StepSize],
    rows: NDArray[np.uint32],
    measured: Measured,
    ideals: Mapping[Change, Values | None],
    reference: Values | None,
    *,
    whole: bool,
) -> FiniteChanges:
    """Run a model and its variants at each step size, side by side. ``rows`` of the state are those that
    ``measured`` needs.

    ``whole``: all measures are of extremes and totals.
    """
    keys: list[Change | None] = [None, *variants]
    tasks = []
    for size in sizes:  # runs with one step stay in phase: contacts begin in all lanes of a register at nearly the same time
        for key in keys:
            assembly = base if key is None else variants[key]
            own = reference if key is None else ideals.get(key, reference)
            tasks.append((size.of(assembly), rows, partial(measured, reference=own)))
    values = measures_of(tasks, whole=whole)
    each = {key: values[k :: len(keys)] for k, key in enumerate(keys)}
    return FiniteChanges(each[None], {key: each[key] for key in variants})


def compared(found: Derivative, slopes: Mapping[str, Sequence[float]], changes: FiniteChanges, sizes: Mapping[str, float]) -> Derivative:
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
        certain = len(wide) >= LEAST_SIZES and same_sign(spans[name]) and all(sure(widened(side)) for side in sides if side)
        kinds[name] = "derivative" if holds and sure(ranges[name]) else "change" if certain else "unknown"
    return Derivative(found.path, found.value, found.values, ranges, quotients, spans, kinds, found.runs)


def agreement(slopes: Sequence[float], wide: Sequence[float], close: Sequence[float], little: float) -> tuple[Span, bool]:
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
