"""Cautions about equilibria: what is unstable, snaps, coarse meshes, missing load factors, and remedies."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

from ..measures.motion import times
from ..measures.statics import displacement, first_leap
from ..model.validation.plausibility import clearances_at_rest, suspect_surfaces
from ..solvers.buckling import MOST_COORDINATES
from ..solvers.status import Status
from .trust import static_verdict

if TYPE_CHECKING:
    from ..results.run_data import RunData
    from ..solvers.record import Record

SOFTER = (
    "a limit load may have been passed, or the structure became softer, which load factors so far apart do"
    " not tell"
)


def static_cautions(result: RunData) -> Iterator[str]:
    """Yield sentences on what makes equilibria doubtful, each with a remedy."""
    record = result.record
    if record.damaged_parts:
        yield (
            f"The run file is damaged: {', '.join(record.damaged_parts)} could not be read; run the model"
            " again."
        )
    if record.message:
        yield record.message
    elif record.status != Status.COMPLETE:
        yield f"The analysis is {record.status}: it reached only the load factors listed here."
    yield from stability_cautions(record)
    yield from record.assembly.missing_joints
    if coarse := static_verdict(result):
        yield coarse
    yield from suspect_surfaces(record.assembly.mechanism)
    yield from clearances_at_rest(record.assembly.mechanism)
    yield from snap_cautions(record)
    if not record.snaps and (leap := first_leap(record)):
        yield (
            f"At load factor {leap.load_factor:g} the displacement leaps by {leap.size:.4g} m, per load"
            f" {leap.by_load:.3g} times the step before: {SOFTER}."
            " Choose closer load factors before it, or prescribe a travel to follow the path."
        )


def snap_cautions(record: Record) -> Iterator[str]:
    """Yield a sentence on each way between two load factors on which the structure was unstable."""
    factors, moved = times(record).tolist(), displacement(record)
    for start, end in record.snaps:
        last = factors.index(end)
        yield (
            f"Between load factors {start:g} and {end:g} the structure became unstable, and the displacement"
            f" goes from {moved[last - 1]:.4g} to {moved[last]:.4g} m: a limit load was passed and it snapped"
            " through, it left an unstable start, or a buckling load was passed. Equilibria from"
            f" {end:g} on lie beyond it. Closer load factors show which, and at which load; a prescribed"
            " travel in place of the load follows the path."
        )


def stability_cautions(record: Record) -> Iterator[str]:
    """Yield sentences on load factors whose equilibria are unstable, or whose stability is not examined."""
    last_stable: float | None = None
    for unstable, group in groupby(record.unstable, key=lambda entry: entry[1]):
        factors = [factor for factor, _ in group]
        place = f"load factor{'s' * (len(factors) > 1)} {factors[0]:g}"
        if len(factors) > 1:
            place += f" to {factors[-1]:g}"
        if unstable is None:
            yield (
                f"Whether the equilibria at {place} are stable is not known: loads follow the structure,"
                " contacts are about to open, or the mechanism has more than"
                f" {MOST_COORDINATES} free coordinates."
            )
        elif unstable:
            begin = "" if last_stable is None else f"This begins between {last_stable:g} and {factors[0]:g}. "
            yield (
                f"The equilibria at {place} are unstable: a real structure leaves them, as a strut beyond its"
                f" buckling load does. {begin}What is straight or symmetric has no reason to"
                " leave its path when it is computed. A small imperfection shows where it goes: a"
                " lateral load of a thousandth of the others, or an angle of 0.1 deg."
            )
        last_stable = factors[-1] if unstable is False else None
