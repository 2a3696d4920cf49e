"""Document of a wear simulation: depths, volumes and life, with uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..job.progress import counted
from ..laws.materials import OILED, PAIRS, SCATTER
from ..measures.values import NOT_ESTIMATED
from ..model.functions import turn_of
from .amounts import life_words, turns_words
from .document import Document, Table, incomplete, paragraphs

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..tribology.wear_state import Worn

MOST_HARMONICS = 32
DIFFERENT = 0.8  # of a life by smoothed profiles: a shorter one by the deepest places is stated
CLEAR = 0.8  # of the wear of the deepest places, the least growth of clearance that needs no remark


def document(wear: Worn) -> Document:
    """Return the document: depth and volume of each surface, and remarks on their uncertainty."""
    rows = []
    for surface, depth in zip(wear.surfaces, wear.depth[-1], strict=True):
        joint = wear.joints.index(surface.joint)
        volume = 1e9 * wear.volume(surface.joint, surface.side)[-1]
        loss = (f"{1e6 * depth.max():.4g} µm", f"{volume:.4g} mm³")
        state = (f"{1e6 * wear.clearance[-1, joint]:.4g} µm", f"{wear.force[-1, joint]:.4g} N")
        rows.append((surface.name, f"{surface.k:.3g}", *loss, *state))
    heads = (
        "surface",
        "k (1/Pa)",
        "deepest",
        "volume",
        "clearance, smoothed",
        f"largest force ({NOT_ESTIMATED})",
    )
    return Document(
        [*incomplete(wear.progress), Table.numeric(heads, rows), *paragraphs(list(_remarks(wear)))],
        f"{wear.name}: {wear.turns[-1]:,.0f} turns{_headline(wear)}",
    )


def _headline(wear: Worn) -> str:
    """Return what ended the life, the shorter life by the deepest places, and a groove that is deeper than
    the clearance.
    """
    groove = _groove(wear)
    if not wear.life_end:
        return groove
    joint, turns = wear.life_end["joint"], wear.life_end["turns"]
    return (
        f"{groove}, the life until joint {joint} reaches its limit of {wear.life_end['by']}"
        f"{_deepest_life(wear, turns)}"
    )


def _groove(wear: Worn) -> str:
    """Return the joint whose groove is most times as deep as its clearance was and hardly widens the smoothed
    one; empty without such a groove.
    """
    grooves = []
    for k, joint in enumerate(wear.joints):
        place = wear.unsmoothed_clearance(joint)
        depth, start = float(place[-1] - place[0]), float(place[0])
        if start > 0.0 and depth > start and wear.clearance[-1, k] - wear.clearance[0, k] < CLEAR * depth:
            grooves.append((depth / start, depth, joint))
    if not grooves:
        return ""
    share, depth, joint = max(grooves)
    return (
        f"; the groove in {joint}, {1e6 * depth:.3g} µm deep, is {share:.2g} times its clearance: no smoothed"
        " clearance describes that joint"
    )


def _remarks(wear: Worn) -> Iterator[str]:
    """Numbers of turns and steps, errors of the extrapolation, sources of coefficients, and life."""
    spec, mechanism = wear.spec, wear.mechanism(0)
    frictions = ", ".join(f"{name} {mechanism.contacts[name].friction.name}" for name in wear.joints)
    yield (
        f"{wear.simulated:,.0f} turns were simulated, {spec.settle} of {spec.settle + spec.block} discarded"
        f" each time, {spec.steps:,} steps a turn; friction: {frictions}.{_half_step(wear)}"
    )
    block = "the scatter of rates over turns is not estimated, because a block has one turn."
    if spec.block > 1:
        block = f"rates are known within {100.0 * wear.spread.max():.2g} % from the turns of a block."
    errors = (
        f"the largest error {1e6 * wear.errors.max():.2g} µm, all together {1e6 * wear.errors.sum():.2g} µm"
    )
    yield f"{counted(len(wear.turns) - 1, 'jump')}, {errors}; {block}"
    yield from _coefficients(mechanism, wear)
    if spec.harmonics == 0:
        yield "Clearances do not follow the wear, so depths are proportional to the turns."
    if wear.sharp.max() > 1.0:
        yield (
            "Grooves are narrower than the journal, which would rest on their edges and widen them: the"
            " depths are too large."
        )
    if 0 < spec.harmonics < MOST_HARMONICS:
        yield from _smoothed(wear)
    if wear.life_end:
        yield (
            f"Life: {_life(wear, wear.life_end['turns'], wear.life_end['joint'])}, until joint"
            f" {wear.life_end['joint']} reaches the limit of its {wear.life_end['by']}"
            f"{_deepest_life(wear, wear.life_end['turns'])}."
        )
    elif spec.clearance is not None or spec.force is not None:
        yield f"Life: more than {wear.turns[-1]:,.0f} turns; no limit was reached{_outlook(wear)}."


def _life(wear: Worn, turns: float, joint: str) -> str:
    """Return turns until a limit, with the scatter of coefficients that come from a table."""
    mechanism = wear.mechanism(0)
    sides = mechanism.contacts[joint].wear
    tabled = any(
        isinstance(getattr(sides, surface.side), str) for surface in wear.surfaces if surface.joint == joint
    )
    return life_words(turns, turn_of(mechanism), SCATTER if tabled else None)


def _deepest_life(wear: Worn, turns: float) -> str:
    """Return the life by the deepest places as they wore, of the joint where it is shortest, if it is much
    shorter than the ``turns`` by smoothed profiles.
    """
    limit = wear.spec.clearance
    if limit is None:
        return ""
    deepest, joint = min((wear.turns_to(joint, limit, smoothed=False), joint) for joint in wear.joints)
    if deepest >= DIFFERENT * turns:
        return ""
    return f"; the deepest places of {joint}, not smoothed, reach it after {turns_words(deepest)} turns"


def _coefficients(mechanism: Mechanism, wear: Worn) -> Iterator[str]:
    """Yield the source and scatter of each coefficient taken from a named pair of materials."""
    for surface in wear.surfaces:
        pair = getattr(mechanism.contacts[surface.joint].wear, surface.side)
        if isinstance(pair, str):
            number, source = PAIRS[pair]
            yield (
                f"The coefficient of {surface.name} is that of {pair}, dry, K = {number:g}"
                f" ({source}): tests lie within a factor of {SCATTER:g}, {surface.k / SCATTER:.2g} to"
                f" {surface.k * SCATTER:.2g} 1/Pa, with oil {OILED * surface.k:.2g} and less; depths are"
                " proportional to it."
            )


def _half_step(wear: Worn) -> str:
    """Return the change of the last block with half the step."""
    if not wear.step_difference:
        return " The error of the time step is not estimated: the simulation is not complete."
    volume, place = (100.0 * share for share in wear.step_difference)
    return (
        f" With half the step the volume that the last block wears changes by {volume:.2g} %, the deepest"
        f" place by {place:.2g} %."
    )


def _smoothed(wear: Worn) -> Iterator[str]:
    """Joints whose clearance grows much less than their deepest places, because the harmonics of their
    profiles smooth these.
    """
    for k, joint in enumerate(wear.joints):
        places = [place for place, surface in enumerate(wear.surfaces) if surface.joint == joint]
        depth = float((wear.depth[-1, places] - wear.depth[0, places]).max(axis=1).sum())
        grown = float(wear.clearance[-1, k] - wear.clearance[0, k])
        if grown < CLEAR * depth:
            yield (
                f"The clearance of {joint} grew by {1e6 * grown:.4g} µm where its deepest places lost"
                f" {1e6 * depth:.4g} µm: {wear.spec.harmonics} harmonics smooth narrow grooves. Try more of"
                f" them (--harmonics {min(2 * wear.spec.harmonics, MOST_HARMONICS)})."
                f"{_unsmoothed_life(wear, joint)}"
            )


def _unsmoothed_life(wear: Worn, joint: str) -> str:
    """Return after how many turns the deepest places as they wore reach the limit of clearance."""
    limit = wear.spec.clearance
    if limit is None:
        return ""
    turns = wear.turns_to(joint, limit, smoothed=False)
    return f" Without smoothing it would reach {1e6 * limit:.4g} µm after {_life(wear, turns, joint)}."


def _outlook(wear: Worn) -> str:
    """Return the when the first joint would reach its limit of clearance at the rate of the last jump; empty
    without a limit or growth.
    """
    limit = wear.spec.clearance
    if limit is None:
        return ""
    turns, joint = min((wear.turns_to(joint, limit), joint) for joint in wear.joints)
    if turns == math.inf:
        return ""
    return (
        f"; at the present rate joint {joint} would reach {1e3 * limit:.4g} mm after"
        f" {_life(wear, turns, joint)}{_deepest_life(wear, turns)}"
    )
