"""Sentences of a design answer about its fits: the choice, its assumption, and the limits of clearances."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.outward import UP
from ..numerics.scalar import power
from .amounts import percent, prefixed
from .design_words import MISSING, and_words, default_limit_words, end, quantity_of, words
from .searches import allocation as allocation_document

if TYPE_CHECKING:
    from ..assessment.answer import Design
    from ..studies.study_work import Allocation

CONFIDENCE = 0.95  # that no larger share of machines exceeds the largest of the independent ones
NO_FITS = {  # by the search for fits
    "all": "No choice of fits limits",
    "descent": "None of the choices of fits that were tried limits",
    "same": "No fit or grades common to all joints limit",
}
ASSUMPTION = (
    "if holes and shafts are normally distributed about the middle of their tolerance zones, with the limits"
    " at {:g} standard deviations"
)


def fit_sentence(design: Design) -> str:
    """Return the fits that keep the limit."""
    if reason := design.missing.get("fits"):
        return f"Fits are not computed: {end(reason)}"
    answer = design.allocation
    share = f"{100.0 * design.share:g} %"
    aim = f"{words(design.measure)} to {quantity_of(design, design.limit)} in {share} of machines"
    if answer is None or answer.choice is None or answer.quantile is None:
        return f"{NO_FITS[design.search]} {aim}; {fit_remedy(design)}."
    fits = ", ".join(f"{fit} for {name}" for name, fit in (answer.fits or {}).items())
    reached = quantity_of(design, answer.quantile.value)
    subject = {
        "all": "The cheapest fits that limit {} are",
        "same": "The cheapest fits of the same grades in all joints that limit {} are",
        "descent": "Fits that limit {}, each as cheap as the others allow, are",
    }[design.search].format(aim)
    assumption = ASSUMPTION.format(design.limit_deviations)
    choice = (
        f"{subject} {fits}; {share} of {answer.machines} such machines stay below {reached}, {assumption}."
    )
    return " ".join([choice, *limit_sentences(design)])


def limit_sentences(design: Design) -> Iterator[str]:
    """Yield the measure anywhere within the limits of the fits, and that coarser fits were not tried."""
    values = design.values_within_limits
    if len(values) and design.limit is not None:
        low, high = (quantity_of(design, float(end)) for end in (values.min(), values.max()))
        part = even_values(design)
        counted, place = (part, " evenly distributed") if len(part) else (values, "")
        exceeding = int((counted > design.limit).sum())
        excess = (
            f"{exceeding or 'none'} of these {len(counted)}{place} machines"
            f" exceed{'s' * (exceeding == 1)} the limit"
        )
        yield (
            f"In {len(values)} machines within the limits of these fits ({machine_words(design)}),"
            f" {words(design.measure)} is {low} to {high}; {excess}. {bound_sentence(design)}"
            f" {jump_sentence(design)}{largest_sentence(design)}"
        )
    if coarsest := coarsest_fits(design):
        fits = "; ".join(f"{fit} for {and_words(names)}" for fit, names in coarsest.items())
        yield f"Coarser fits than these were not tried: {fits} (--cost names other grades)."


def even_values(design: Design) -> NDArray[np.float64]:
    """Return the measure (SI) of the machines evenly distributed within the limits of the fits."""
    return np.concatenate([machines.values for machines in design.even_machines] or [np.empty(0)])


def bound_sentence(design: Design) -> str:
    """Return how many other machines within the limits may have more than the largest value: of n independent
    machines none exceeds it, which has the probability (1 - p)^n if a share p of all does.
    """
    values = even_values(design)
    largest = quantity_of(design, float(design.values_within_limits.max()))
    share = 1.0 - power(1.0 - CONFIDENCE, 1.0 / max(1, len(values)))
    if not len(values) or not np.isfinite(values).all():
        return f"Other clearances within these limits may give more than {largest}: in how many is {MISSING}."
    return (
        f"Other clearances within these limits may give more than {largest}: at most"
        f" {percent(100.0 * share, 0.1, UP)} of machines whose clearances are evenly distributed do, with"
        f" {100.0 * CONFIDENCE:g} % confidence. By how much is {MISSING}."
    )


def jump_sentence(design: Design) -> str:
    """Return that a larger share may exceed the limit, where machines with nearly the same clearances differ
    by more than is left to it; "" elsewhere.
    """
    left = math.inf if design.limit is None else design.limit - float(design.values_within_limits.max())
    if not design.jump or design.jump <= left:
        return ""
    size = quantity_of(design, design.jump)
    return (
        f"Machines with nearly the same clearances differ by {size} (root mean square), more than is left to"
        " the limit: a larger share than in these machines may exceed it. "
    )


def largest_sentence(design: Design) -> str:
    """Return the clearances of the machine with the largest value, and that a run has its cautions."""
    clearances = ", ".join(
        f"{prefixed(size, 'm')} in {name}" for name, size in design.clearances_of_largest.items()
    )
    return (
        f"It is largest with {clearances}. Machines have no cautions about contact laws, pressures and"
        " whirl: vfife run with these clearances has them."
    )


def machine_words(design: Design) -> str:
    """Return which machines within the limits of the fits were run, and which joints keep their clearance."""
    if (corners := design.corners) is None:
        return ""
    near = design.around.count if design.around is not None else 0
    inner = sum(machines.count for machines in design.even_machines)
    if len(corners.clearances) == 1 << len(corners.names):
        place = "every clearance at a limit" if len(corners.names) > 1 else "the clearance at a limit"
    else:
        place = "all clearances at the lower or all at the upper limits"
    machines = f"{corners.count} machines with {place}"
    if inner:
        machines = f"{inner} machines evenly distributed, {corners.count} with {place}"
    if near:
        machines += f", {near} near the machine with the largest value"
    unfitted = [joint for joint in design.joints if not joint.limits]
    sizes = [f"{prefixed(joint.clearance, 'm')} in {joint.name}" for joint in unfitted]
    return f"{machines}; all with {and_words(sizes)}" if sizes else machines


def coarsest_fits(design: Design) -> dict[str, list[str]]:
    """Return the joints by fit for which the chosen fit is the coarsest of several that were tried."""
    answer, joints = design.allocation, dict[str, list[str]]()
    if answer is None or answer.choice is None:
        return joints
    pairs = zip(answer.task.parameters, answer.task.options, answer.choice.options, strict=True)
    for parameter, options, option in pairs:
        largest = max(offer.clearance.limits[1] for offer in options)
        if len(options) > 1 and option.clearance.limits[1] == largest:
            joints.setdefault(option.name, []).append(parameter.name)
    return joints


def fit_remedy(design: Design) -> str:
    """Return what may give fits: finer grades do not where more clearance makes the measure smaller."""
    low = design.sample.span[0] if design.sample is not None and design.sample.count else -math.inf
    if design.limit is not None and low > design.limit:
        return (
            f"all {design.sample.count if design.sample else 0} machines from the finest to the coarsest fit"
            f" exceed it, with {quantity_of(design, low)} or more: allow a higher limit (--limit)"
        )
    falling = [name for name, rank in design.ranks.items() if rank.high < 0.0 and name in design.letters]
    if falling:
        return f"more clearance of {and_words(falling)} makes it smaller; allow coarser grades (--cost) there"
    return "allow finer grades (--cost) or a higher limit (--limit)"


def fit_cautions(design: Design, allocation: Allocation) -> Iterator[str]:
    """Yield what the choice of fits assumes."""
    if design.default_limit:
        yield f"The limit is {default_limit_words(design)}, because none was given (--limit)."
    letters = ", ".join(f"{name} {fit}" for name, fit in design.letters.items())
    yield f"Letters of fits are those nearest to the clearances of the model ({letters})."
    yield f"Relative costs of a hole or a shaft by grade: {design.costs} (--cost states your own)."
    if design.search == "descent":
        choices = math.prod(map(len, allocation.task.options))
        yield (
            f"Not all {choices:,} choices of fits were tried, but the same grades in all joints (if none"
            " keeps the limit, the most favourable fits by the machines so far), then cheaper fits joint by"
            " joint, the joint that matters least first; a cheaper choice may exist."
        )
    if allocation.choice is not None:
        yield (
            f"{allocation.failures} of {allocation.machines} machines exceed the limit"
            f" ({100.0 * allocation.task.table.confidence:g} % confidence)."
        )


def fits_data(design: Design) -> dict[str, Any]:
    """Return the allocation as data, with its assumption and the machines within the limits of its fits."""
    answer, values = design.allocation, design.values_within_limits
    within = None
    if len(values):
        ends = {"least": float(values.min()), "largest": float(values.max())}
        within = {
            "machines": len(values),
            **ends,
            "which": machine_words(design),
            "largest_clearances": dict(design.clearances_of_largest),
        }
    return {
        "allocation": None if answer is None else allocation_document(answer).data,
        "assumption": None if answer is None else ASSUMPTION.format(design.limit_deviations),
        "within_limits": within,
        "coarsest": coarsest_fits(design),
    }
