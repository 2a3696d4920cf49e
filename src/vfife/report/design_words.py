"""Words of design answers: measures, values, effects and lists of names in sentences; sentences on lives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..numerics.outward import DOWN, NEAREST, UP
from .amounts import (
    Digits,
    interval,
    large_numbers,
    life_range_words,
    life_words,
    limit_digits,
    limit_quantity,
    percent,
    prefixed,
    quantity_of_digits,
    turns_words,
)
from .digits import NOT_DETERMINED
from .wear import groove_sentences, open_life_sentence, wear_length

if TYPE_CHECKING:
    from ..assessment.answer import Design, Life
    from ..results.derivatives import Effect
    from ..tribology.wear_state import Worn

UNKNOWN = "not known"
MISSING = "not estimated"
MOST_PARTS = 1e-3  # of a difference: its range is not shown finer
PART_WORDS = {"life": "lives", "limits": "machines within the limits of the fits"}
MEASURES = {  # endings of names of measures, and their words
    "force.max": "the largest force on {}", "approach_speed.max": "the hardest knock of {}",
    "torque.max": "the largest torque of {}", "moment.max": "the largest moment of {}",
    "penetration.max": "the largest penetration in {}", "contact_pressure.max": "the largest pressure in {}",
    "angular_acceleration.max": "the largest angular acceleration of {}",
    "friction_power.mean": "the friction power of {}", "impact_power.mean": "the power of knocks in {}",
    "torque.rms": "the rms torque of {}", "energy_fluctuation": "the energy fluctuation of {}",
    "power.mean": "the mean power of {}", "impacts": "the number of impacts in {}",
}  # fmt: skip


def and_words(names: list[str]) -> str:
    """Return names as words of a sentence."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def missing_parts(design: Design) -> str:
    """Return the parts that an answer does not have, in words."""
    return and_words([PART_WORDS.get(part, part) for part in sorted(design.missing)])


def or_words(names: list[str]) -> str:
    """Return names as words of a sentence, any of which may be meant."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def words(measure: str) -> str:
    """Return a measure in words; its name if it has none."""
    ending = next((ending for ending in MEASURES if measure.endswith(f".{ending}")), "")
    owner, _, corner = measure.removesuffix(f".{ending}").partition(".")
    return MEASURES[ending].format(f"{owner}, corner {corner}" if corner else owner) if ending else measure


def sentence(text: str) -> str:
    """Return a text as the begin of a sentence; a name as it is."""
    return text[0].upper() + text[1:] if " " in text else text


def end(reason: str) -> str:
    """Return a reason as the end of a sentence."""
    return reason if reason.endswith(".") else f"{reason}."


def quantity_of(design: Design, value: float | None) -> str:
    """Return a value of the measure with its unit, and the digits by which it differs from the limit."""
    if value is None:
        return UNKNOWN
    reached = None if design.allocation is None else design.allocation.quantile
    within = design.values_within_limits
    values = [design.nominal, design.ideal, None if reached is None else reached.value]
    values += [float(end) for end in (within.min(), within.max())] if len(within) else []
    digits = limit_digits(design.limit, values, not design.default_limit)
    return limit_quantity(value, design.unit, digits)


def effect_words(design: Design, effect: Effect) -> str:
    """Return an effect in per cent; that of a coordinate as a difference."""
    sign = "+" if effect.value > 0.0 else ""
    if design.by_difference:
        return f"{sign}{difference_words(effect.value, design.unit, effect.high - effect.low)}"
    return f"{sign}{percent(effect.value, effect.high - effect.low)}"


def effect_range(design: Design, effect: Effect) -> str:
    """Return the range of an effect, as :func:`effect_words`, its ends rounded outwards."""
    width = effect.high - effect.low
    ends = (effect.low, effect.high)
    ways = (DOWN, UP) if width > 0.0 else (NEAREST, NEAREST)
    if design.by_difference:
        if not width or design.unit not in ("m", "rad"):
            return " to ".join(
                difference_words(end, design.unit, width, way) for end, way in zip(ends, ways, strict=True)
            )
        size = max(abs(effect.low), abs(effect.high))
        return interval(effect.low, effect.high, design.unit, max(0.1 * width, MOST_PARTS * size))
    return " to ".join(percent(end, width, way) for end, way in zip(ends, ways, strict=True))


def effect_difference(design: Design, effect: Effect) -> str:
    """Return the difference (unit of the measure) that an effect in per cent is of the nominal value; "" for
    a coordinate, whose effects are differences, and where that value is not known.
    """
    if design.by_difference or not design.nominal:
        return ""
    share = 0.01 * abs(design.nominal)
    width = share * (effect.high - effect.low)
    return f"{'+' if effect.value > 0.0 else ''}{difference_words(share * effect.value, design.unit, width)}"


def difference_words(value: float, unit: str, width: float, direction: int = NEAREST) -> str:
    """Return a difference with four digits at most, none finer than its uncertainty ``width``."""
    if unit == "rad" and value:
        return prefixed(value, unit, max(width, abs(value) * MOST_PARTS), direction)
    return quantity_of_digits(value, unit, Digits(error=max(width, abs(value) * MOST_PARTS)), direction)


def reference_words(design: Design) -> str:
    """Return the value of a measure in brackets, beside that of the ideal mechanism for a coordinate."""
    ideal = "" if design.ideal is None else f", ideal {quantity_of(design, design.ideal)}"
    return f"({quantity_of(design, design.value)}{ideal})"


def default_limit_words(design: Design) -> str:
    """Return how far the default limit is from the value of the model."""
    if design.by_difference:
        return "a tenth of the difference from the ideal mechanism above the value of the model"
    return "a tenth above the value of the model"


def life_range(life: Life) -> str:
    """Return the range of a life in turns."""
    if not math.isfinite(life.turns):
        return ""
    if (span := life.bounds) is None:
        return MISSING
    if not math.isfinite(span[1]):
        return f"more than {turns_words(span[0])}"
    (low, high), word = large_numbers(*span)
    return f"{low} to {high} {word}".rstrip()


def life_sentence(design: Design) -> str:
    """Return the joint that reaches its end of life first."""
    if reason := design.missing.get("life"):
        return f"How long the joints last is {MISSING}: {end(reason)}"
    lives = [(joint.life.turns, joint.name, joint.life) for joint in design.joints if joint.life is not None]
    turns, name, life = min(lives)
    if not math.isfinite(turns):
        return "No clearance grows by wear over the turns that were simulated."
    rivals = first_joints(lives)
    beginning = f"{name} wears out first: its clearance"
    if len(rivals) > 1:
        beginning = (
            f"Which of {and_words(rivals)} wears out first is {NOT_DETERMINED}. The clearance of {name}"
        )
    range_text = f", range {life_range(life)} turns" if life.span is not None else ""
    lasts, remarks = f"{life_words(turns, design.turn)}{range_text}", list[str]()
    if not life.determined and design.wear is not None:
        wear_life = design.wear.life(name, life.clearance)
        lasts = life_range_words(*(life.bounds or (wear_life.shortest, wear_life.longest)), design.turn)
        remarks = [open_life_sentence(wear_life, design.wear.spec.harmonics), *groove_sentences(design.wear)]
    text = f"{beginning} reaches {prefixed(life.clearance, 'm')} after {lasts}, {scatter(design)}."
    return " ".join([text, *remarks])


def first_joints(lives: list[tuple[float, str, Life]]) -> list[str]:
    """Return the joints whose life may be the shortest: by smoothed grooves, by either end of their range."""
    firsts = {min(lives)[1]}
    if spans := [(span, name) for _, name, life in lives if (span := life.bounds) is not None]:
        firsts |= {min((span[end], name) for span, name in spans)[1] for end in (0, 1)}
    return sorted(firsts)


def scatter(design: Design) -> str:
    """Return what the range of lives covers."""
    if design.wears_by_pair:
        return "with a factor of ten for the scatter of wear coefficients"
    return "if the wear coefficient is exact; ten times the coefficient is a tenth of the life"


def life_cautions(design: Design, wear: Worn) -> Iterator[str]:
    """Yield what lives assume, and why one is not estimated."""
    covered = "and a factor of ten for pairs of materials" if design.wears_by_pair else "not the coefficient"
    yield (
        "Lives are inversely proportional to wear coefficients, which are uncertain by decades. The range"
        f" of a life covers scatter over turns and the time step, {covered}."
    )
    yield from wear_length(design.mechanism, wear.joints)
    if flat := [assessed.name for assessed in design.joints if assessed.name in design.flat_joints]:
        yield (
            f"The life of {and_words(flat)} is {MISSING}: wear is simulated of a journal in a round"
            " bearing, not of a slider in its guide."
        )
    if names := [joint.name for joint in design.joints if joint.life and not joint.life.determined]:
        yield (
            f"The life of {and_words(names)} is {NOT_DETERMINED}: its range reaches from that of the deepest"
            " places as they wore to that of wear spread evenly around bearing and journal."
        )
    if names := [joint.name for joint in design.joints if joint.life and joint.life.span is None]:
        yield (
            f"The life of {and_words(names)} lacks scatter over turns and the error of the time step, because"
            " the simulation of wear was interrupted."
        )
    if any(joint.life is not None and is_extrapolated(joint.life, wear) for joint in design.joints):
        yield (f"Lives beyond {turns_words(float(wear.turns[-1]))} turns are extrapolated at the last rate.")


def is_extrapolated(life: Life, wear: Worn) -> bool:
    """Return whether a life, or an end of its range, lies beyond the turns that were simulated."""
    return not life.reached or (not life.determined and life.uniform > wear.turns[-1])
