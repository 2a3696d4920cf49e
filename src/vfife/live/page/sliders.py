"""Sliders: fields of a model, and the values that each may take in a page."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ...errors import shown, suggestion
from ...model.mechanism import Mechanism
from ...schema.described import described_fields, key_of
from ...units import ends_of, number

POSITIONS = 21  # of a slider
WIDE = 8.0  # ratio of a range from which its positions are spaced by ratios
SHARES = {
    "clearance": (0.4, 2.5),
    "speed": (0.5, 1.25),
    "coefficient": (0.0, 2.0),
}  # of the model's value, by default
RESTITUTION = (0.4, 0.95)
SECTIONS = {
    "joint": "joints",
    "body": "bodies",
    "driver": "drivers",
    "spring": "springs",
    "load": "loads",
    "gear": "gears",
}


@dataclass(frozen=True)
class Slide:
    """A slider: its name, the fields that it sets by their paths, their unit, its values and which of them
    the model has.

    One that is ``whole`` keeps all its values where it moves by itself.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    values: tuple[float, ...]
    here: int
    whole: bool = False

    @property
    def said(self) -> tuple[str, ...]:
        """What a page says of each position; without any it says the value."""
        return ()

    def set(self, position: int) -> list[tuple[str, Any]]:
        """What a position sets, as a model file takes it."""
        return [(path, self.values[position]) for path in self.paths]


def default_slides(mechanism: Mechanism) -> list[Slide]:
    """A slider for every clearance, one for the speed of each driver, one for all friction and one for all
    restitution.
    """
    found = [made(f"joint.{name}.clearance", mechanism, *SHARES["clearance"]) for name in mechanism.contacts]
    found += [made(f"driver.{name}.speed", mechanism, *SHARES["speed"]) for name in mechanism.drivers]
    for field, law in (("coefficient", "friction"), ("restitution", "contact")):
        by_value: dict[float, list[str]] = {}
        for name in mechanism.contacts:
            try:
                by_value.setdefault(value_at(mechanism, f"joint.{name}.{law}.{field}")[0], []).append(
                    f"joint.{name}.{law}.{field}"
                )
            except ValueError:
                continue
        for value, paths in by_value.items():
            which = law if field == "coefficient" else field
            name = (
                which
                if len(by_value) == 1
                else f"{which} of {', '.join(path.split('.')[1] for path in paths)}"
            )
            low, high = (
                RESTITUTION
                if field == "restitution"
                else (SHARES[field][0] * value, SHARES[field][1] * value)
            )
            found.append(
                spaced(name, tuple(paths), "1", min(low, value), max(high, value), value) if value else None
            )
    return [slide for slide in found if slide is not None]


def made(path: str, mechanism: Mechanism, low: float, high: float) -> Slide | None:
    """A slider over shares of what the model has; None where it has no such number, or zero."""
    try:
        value, unit = value_at(mechanism, path)
    except ValueError:
        return None
    ends = sorted((low * value, high * value))
    return spaced(path, (path,), unit, ends[0], ends[1], value) if value else None


def asked_slides(mechanism: Mechanism, texts: Iterable[str], option: str = "--slide") -> list[Slide]:
    """Sliders asked for as PATH=LOW..HIGH with a unit, such as ``joint.C.clearance=0.01..0.5mm``. ValueError
    names the ``option``.
    """
    found = []
    for text in texts:
        path, sign, span = (part.strip() for part in text.partition("="))
        ends = ends_of(span)
        if not (sign and path and ends):
            raise ValueError(
                f"{option} {text}: this is not PATH=LOW..HIGH; write it as in {option}"
                " joint.C.clearance=0.01..0.5mm"
            )
        try:
            value, unit = value_at(mechanism, path)
            low_value, high_value = (number(end, unit) for end in ends)
        except ValueError as error:
            raise ValueError(f"{option} {text}: {error}") from None
        if not low_value < high_value:
            raise ValueError(f"{option} {text}: the range is empty; write its lower end first")
        found.append(spaced(path, (path,), unit, low_value, high_value, value))
    return found


def spaced(name: str, paths: tuple[str, ...], unit: str, low: float, high: float, here: float) -> Slide:
    """Positions from low to high, evenly or by ratios where the range is wide, and the model's own value
    among them.
    """
    wide = low > 0.0 and high / low >= WIDE
    shares = [k / (POSITIONS - 1) for k in range(POSITIONS)]
    values = [low * (high / low) ** share if wide else low + (high - low) * share for share in shares]
    values = [float(f"{value:.3g}") for value in values]
    gap = min((abs(a - b) for a, b in zip(values, values[1:], strict=False)), default=0.0)
    values = sorted({here, *(value for value in values if abs(value - here) > 0.3 * gap)})
    return Slide(name, paths, unit, tuple(values), values.index(here))


def value_at(mechanism: Mechanism, path: str) -> tuple[float, str]:
    """The number at a path such as ``joint.C.contact.restitution``, and its unit. Raises ValueError where
    there is none.
    """
    section, *keys = path.split(".")
    here: Any = getattr(mechanism, SECTIONS.get(section, ""), None)
    if here is None or not keys or keys[0] not in here:
        known = [f"{one}.{name}" for one, where in SECTIONS.items() for name in getattr(mechanism, where)]
        raise ValueError(
            f"there is no {shown('.'.join([section, *keys[:1]]))} in the model;"
            f" {suggestion(path, known, 'name a number by its path')}"
        )
    here, unit = here[keys[0]], "1"
    for key in keys[1:]:
        fields = {
            key_of(field): field
            for field in (described_fields(type(here)) if hasattr(here, "__dataclass_fields__") else ())
        }
        if key not in fields:
            raise ValueError(
                f"there is no {shown(key)} at {shown(path)};"
                f" {suggestion(key, list(fields), 'name a number by its path')}"
            )
        along = (
            fields[key].metadata.get("along")
            if getattr(here, "slider", None) or getattr(here, "point", None)
            else None
        )
        here, unit = getattr(here, fields[key].name), (along or fields[key].metadata).get("unit") or "1"
    if isinstance(here, bool) or not isinstance(here, int | float) or not math.isfinite(here):
        raise ValueError(f"{shown(path)} is no number that a slider could change")
    return float(here), str(unit)
