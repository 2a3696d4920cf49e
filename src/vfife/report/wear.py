"""Document of a wear simulation: depths, volumes and life, with uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..job.progress import counted
from ..laws.materials import OILED, PAIRS, SCATTER
from ..measures.values import NOT_ESTIMATED
from ..model.functions import turn_of
from ..model.joints.contact import Contact
from .amounts import life_range_words, life_words, prefixed, quantity, turns_words
from .digits import NOT_DETERMINED
from .document import Document, Table, incomplete, paragraphs

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism
    from ..tribology.wear_state import WearLife, Worn

MOST_HARMONICS = 32
NARROW = (
    "Grooves are narrower than the journal, which would rest on their edges and widen them: the depths are"
    " too large."
)
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
    """Return a groove that is deeper than the clearance, and what first the life, with its range where the
    model does not determine it.
    """
    groove = _groove(wear)
    text = f"; {groove}" if groove else ""
    if not wear.life_end:
        return text
    joint, by = wear.life_end["joint"], wear.life_end["by"]
    if life := _open_life(wear, joint):
        span = life_range_words(life.shortest, life.longest, None)
        return f"{text}; joint {joint} reaches its limit of {by} after {span}"
    return f"{text}, the life until joint {joint} reaches its limit of {by}"


def _deep_groove(wear: Worn) -> tuple[float, float, str] | None:
    """Return the joint whose groove is most times as deep as its clearance was and hardly widens the smoothed
    one: this ratio, the depth (m) and the joint; None without such a groove.
    """
    grooves = []
    for k, joint in enumerate(wear.joints):
        place = wear.unsmoothed_clearance(joint)
        depth, start = float(place[-1] - place[0]), float(place[0])
        if start > 0.0 and depth > start and wear.clearance[-1, k] - wear.clearance[0, k] < CLEAR * depth:
            grooves.append((depth / start, depth, joint))
    return max(grooves, default=None)


def _groove(wear: Worn) -> str:
    """Return the groove that is deeper than the clearance, as text; empty without one."""
    if (groove := _deep_groove(wear)) is None:
        return ""
    share, depth, joint = groove
    return (
        f"the groove in {joint}, {1e6 * depth:.3g} µm deep, is {share:.2g} times its clearance: no smoothed"
        " clearance describes that joint"
    )


def _is_narrow(wear: Worn) -> bool:
    """Return whether a journal would rest on the edges of its groove, as the profiles of the contact show it,
    or as more harmonics show a groove that is deeper than the clearance.
    """
    groove = _deep_groove(wear)
    hidden = groove is not None and wear.sharpness(groove[2], MOST_HARMONICS) > 1.0
    return hidden or bool(wear.sharp.max() > 1.0)


def groove_sentences(wear: Worn) -> Iterator[str]:
    """Yield what contradicts the contact geometry: a groove that is deeper than the clearance, and grooves
    that are narrower than the journal.
    """
    if groove := _groove(wear):
        yield f"{groove[0].upper()}{groove[1:]}."
    if _is_narrow(wear):
        yield NARROW


# Length over diameter, or inverse, from which a default length is mentioned: plain bearings have 0.5 to 1.5.
UNLIKE = 2.0


def on_default_length(joint: Contact) -> bool:
    """Return whether a joint has the default length although its size is unlike it: a run does not know
    which lengths the model file gives.
    """
    size, length = joint.nominal_size or math.inf, joint.axial_length
    return length == Contact.axial_length and not size / UNLIKE <= length <= size * UNLIKE


def length_sentence(subject: str, joints: list[str]) -> str:
    """Return that the ``subject`` of ``joints`` is that on the default length; "" without joints."""
    length = prefixed(Contact.axial_length, "m")
    names = ", ".join(joints)
    return f"{subject} of {names}: on {length}, the length of joints without axial_length." if names else ""


def length_note(summary: Mapping[str, Any], joints: Iterable[str]) -> str:
    """Return a sentence on the ``joints`` whose pressure is on a default length unlike their size; "" for
    none.
    """
    names = [name for name in joints if "default_length" in summary["joints"][name]]
    return length_sentence("Pressure", names)


def wear_length(mechanism: Mechanism, joints: Iterable[str]) -> list[str]:
    """Return a sentence on the ``joints`` that wear on such a length; empty without any."""
    names = [name for name in joints if on_default_length(mechanism.contacts[name])]
    return [length_sentence("Wear", names)] if names else []


def open_life_sentence(life: WearLife, harmonics: int) -> str:
    """Return what the ends of the range of a life mean that the model does not determine."""
    subject = f"grooves smoothed by {counted(harmonics, 'harmonic')}" if harmonics else "their mean depths"
    return (
        "The model determines no more than this range: the shortest life is that of the deepest places as"
        " they wore, the longest that of wear spread evenly around bearing and journal;"
        f" {subject} give {turns_words(life.smoothed)} turns. Another number of harmonics changes this and"
        " the shortest life."
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
    yield from wear_length(mechanism, wear.joints)
    if left_out := [name for name in mechanism.contacts if name not in wear.joints]:
        yield (
            f"The wear of {', '.join(left_out)} is not computed here: it has no coefficient, or is no pin"
            " joint. The answer of a run has the worn volume of each joint with a table wear."
        )
    if spec.harmonics == 0:
        yield "Clearances do not follow the wear, so depths are proportional to the turns."
    if _is_narrow(wear):
        yield NARROW
    if 0 < spec.harmonics < MOST_HARMONICS:
        yield from _smoothed(wear)
    if wear.life_end:
        joint, by = wear.life_end["joint"], wear.life_end["by"]
        text, remark = _life(wear, wear.life_end["turns"], joint, _open_life(wear, joint))
        yield f"Life: {text}, until joint {joint} reaches the limit of its {by}.{remark}"
    elif spec.clearance is not None or spec.force is not None:
        yield f"Life: {_bound(wear)}{_outlook(wear)}"


def _life(wear: Worn, turns: float, joint: str, life: WearLife | None) -> tuple[str, str]:
    """Return turns until a limit, with the scatter of coefficients that come from a table, and a remark; for
    a ``life`` that is not determined its range, and what its ends mean.
    """
    mechanism = wear.mechanism(0)
    sides = mechanism.contacts[joint].wear
    tabled = any(
        isinstance(getattr(sides, surface.side), str) for surface in wear.surfaces if surface.joint == joint
    )
    scatter, turn = SCATTER if tabled else None, turn_of(mechanism)
    if life is None:
        return life_words(turns, turn, scatter), ""
    remark = f" {open_life_sentence(life, wear.spec.harmonics)}"
    return life_range_words(life.shortest, life.longest, turn, scatter), remark


def _open_life(wear: Worn, joint: str) -> WearLife | None:
    """Return the life of a joint by its clearance if the model does not determine it; None for any other, and
    for a life that the force first.
    """
    limit = wear.spec.clearance
    if limit is None or wear.life_end.get("by") == "force":
        return None
    life = wear.life(joint, limit)
    return None if life.determined else life


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
    limit, first = wear.spec.clearance, wear.life_end.get("joint")
    for k, joint in enumerate(wear.joints):
        places = [place for place, surface in enumerate(wear.surfaces) if surface.joint == joint]
        depth = float((wear.depth[-1, places] - wear.depth[0, places]).max(axis=1).sum())
        grown = float(wear.clearance[-1, k] - wear.clearance[0, k])
        if grown < CLEAR * depth:
            life = None if joint == first else _open_life(wear, joint)
            span = ""
            if life is not None and limit is not None:
                text, _ = _life(wear, life.smoothed, joint, life)
                span = f" It would reach {quantity(limit, 'm')} after {text}."
            yield (
                f"The clearance of {joint} grew by {1e6 * grown:.4g} µm where its deepest places lost"
                f" {1e6 * depth:.4g} µm: {wear.spec.harmonics} harmonics smooth narrow grooves."
                f" {_advice(wear, joint)}{span}"
            )


def _advice(wear: Worn, joint: str) -> str:
    """Return the advice to follow more harmonics, if the journal fits into the grooves that these resolve."""
    harmonics = min(2 * wear.spec.harmonics, MOST_HARMONICS)
    limit = wear.spec.clearance
    turns = 0.0 if limit is None else wear.turns_to(joint, limit)
    if wear.sharpness(joint, harmonics, turns) <= 1.0:
        return f"Try more of them (--harmonics {harmonics})."
    return (
        "More of them do not help: the grooves that they resolve are narrower than the journal, which would"
        " widen them."
    )


def _bound(wear: Worn) -> str:
    """Return that no limit was reached: as a least life only where no range of a life begins below it."""
    turns, limit = f"{wear.turns[-1]:,.0f} turns", wear.spec.clearance
    lives = [] if limit is None else [wear.life(joint, limit) for joint in wear.joints]
    if all(life.shortest >= wear.turns[-1] for life in lives):
        return f"more than {turns}; no limit was reached"
    grooves = "smoothed grooves" if wear.spec.harmonics else "mean depths"
    return f"{NOT_DETERMINED}; with {grooves} no limit was reached in {turns}"


def _outlook(wear: Worn) -> str:
    """Return when the first joint would reach its limit of clearance at the rate of the last jump, and the
    full stop; nothing more without a limit or growth.
    """
    limit = wear.spec.clearance
    if limit is None:
        return "."
    turns, joint = min((wear.turns_to(joint, limit), joint) for joint in wear.joints)
    if turns == math.inf:
        return "."
    text, remark = _life(wear, turns, joint, _open_life(wear, joint))
    return f"; at the present rate joint {joint} would reach {1e3 * limit:.4g} mm after {text}.{remark}"
