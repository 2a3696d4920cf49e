"""Words of design answers: measures, values and lists of names in sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .amounts import limit_digits, quantity_beside_limit

if TYPE_CHECKING:
    from ..assessment.answer import Design

UNKNOWN = "not known"
MEASURES = {  # endings of names of measures, and their words
    "force.max": "the largest force on {}", "approach_speed.max": "the hardest knock of {}",
    "torque.max": "the largest torque of {}", "moment.max": "the largest moment of {}",
    "penetration.max": "the largest penetration in {}", "contact_pressure.max": "the largest pressure in {}",
    "angular_acceleration.max": "the largest angular acceleration of {}",
    "friction_power.mean": "the friction power of {}", "impact_power.mean": "the power of knocks in {}",
    "power.mean": "the mean power of {}", "impacts": "the number of impacts in {}",
}  # fmt: skip


def and_words(names: list[str]) -> str:
    """Return names as words of a sentence."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


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
    return quantity_beside_limit(value, design.unit, digits)
