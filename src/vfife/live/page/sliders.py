"""Sliders of a page: parameters of a model and the values that each may take."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...errors import shown
from ...model.mechanism import Mechanism
from ...modelfile.parameter import Parameter
from ...units import ends_of, number_range, unit_fault

POSITIONS = 21  # of a slider
WIDE = 8.0  # ratio of a range from which its positions are spaced by ratios
# Default ranges, over the model's value.
SHARES = {"clearance": (0.1, 2.5), "speed": (0.5, 1.25), "coefficient": (0.0, 2.0)}
# A clearance may reach that of a worn pin (m), but not a larger share of the bearing's radius.
LARGEST_CLEARANCE, SHARE_OF_RADIUS = 2e-4, 0.05
RESTITUTION = (0.4, 0.95)
CLOSEST_FACTORS = 1.02  # ratio of two factors of which one position is enough


@dataclass(frozen=True)
class Slide:
    """A slider: its name, the ``paths`` that it sets, their unit, its values, and ``here``, the position of
    the model's own value. A ``complete`` slider keeps all its values if it belongs to no group. The values in
    ``common`` are at factors of the model's value that other sliders have, too.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    values: tuple[float, ...]
    here: int
    complete: bool = False
    common: tuple[float, ...] = ()

    @property
    def labels(self) -> tuple[str, ...]:
        """Texts for the positions; empty to show the values."""
        return ()

    def changes(self, position: int) -> list[tuple[str, Any]]:
        """Return paths and values of a position."""
        return [(path, self.values[position]) for path in self.paths]


def default_slides(mechanism: Mechanism) -> list[Slide]:
    """Return a slider for each clearance, one for each driver speed, one for all friction and one for all
    restitution.
    """
    slides = [
        share_slide(f"joint.{name}.clearance", mechanism, *clearance_shares(joint))
        for name, joint in mechanism.contacts.items()
    ]
    slides += [share_slide(f"driver.{name}.speed", mechanism, *SHARES["speed"]) for name in mechanism.drivers]
    for field, law in (("coefficient", "friction"), ("restitution", "contact")):
        by_value: dict[float, list[str]] = {}
        for name, joint in mechanism.contacts.items():
            if isinstance(value := getattr(getattr(joint, law), field, None), float):
                by_value.setdefault(value, []).append(f"joint.{name}.{law}.{field}")
        for value, paths in by_value.items():
            title = law if field == "coefficient" else field
            name = (
                title
                if len(by_value) == 1
                else f"{title} of {', '.join(path.split('.')[1] for path in paths)}"
            )
            low, high = (
                RESTITUTION
                if field == "restitution"
                else (SHARES[field][0] * value, SHARES[field][1] * value)
            )
            slides.append(
                slider(name, tuple(paths), "1", min(low, value), max(high, value), value) if value else None
            )
    return common_clearances([slide for slide in slides if slide is not None])


def clearance_shares(joint: Any) -> tuple[float, float]:
    """Return the least and the largest clearance on a slider, over that of the joint."""
    low, high = SHARES["clearance"]
    clearance, radius = getattr(joint, "clearance", None), getattr(joint, "bearing_radius", None)
    if clearance and radius:
        high = max(high, min(LARGEST_CLEARANCE, SHARE_OF_RADIUS * radius) / clearance)
    return low, high


def share_slide(path: str, mechanism: Mechanism, low: float, high: float) -> Slide | None:
    """Return a slider from ``low`` to ``high`` times the model's value; None if it has no such number, or
    zero.
    """
    try:
        value, unit = number_at(mechanism, path)
    except ValueError:
        return None
    ends = sorted((low * value, high * value))
    return slider(path, (path,), unit, ends[0], ends[1], value) if value else None


def parse_slides(mechanism: Mechanism, texts: Iterable[str], option: str = "--slide") -> list[Slide]:
    """Return the sliders of texts PATH=LOW..HIGH with a unit, such as ``joint.C.clearance=0.01..0.5mm``.
    Raises ValueError, with the name of the ``option``.
    """
    slides = []
    for text in texts:
        bounds = number_range(
            text, lambda path: number_at(mechanism, path)[1], option, "joint.C.clearance=0.01..0.5mm"
        )
        value = number_at(mechanism, bounds.path)[0]
        ends = ends_of(text.partition("=")[2]) or ("", "")
        if fault := unit_fault(f"{option} {bounds.path}", ends[1], bounds.unit, value, "the model's value"):
            raise ValueError(str(fault))
        slides.append(slider(bounds.path, (bounds.path,), bounds.unit, bounds.low, bounds.high, value))
    return common_clearances(slides)


def common_clearances(slides: list[Slide]) -> list[Slide]:
    """Return sliders in which all clearances have positions at the same factors of the model's values, where
    their ranges overlap, so that one slider can multiply them all; other positions remain outside of that.
    """
    shared = [slide for slide in slides if all(path.endswith(".clearance") for path in slide.paths)]
    if len(shared) < 2 or not all(slide.values[slide.here] for slide in shared):
        return slides
    low = max(slide.values[0] / slide.values[slide.here] for slide in shared)
    high = min(slide.values[-1] / slide.values[slide.here] for slide in shared)
    steps = slider("", (), "1", low, high, 1.0).values
    inner = [factor for factor in steps if low * CLOSEST_FACTORS < factor < high / CLOSEST_FACTORS]
    factors = sorted({low, high, 1.0, *inner})
    return [with_factors(slide, factors) if slide in shared else slide for slide in slides]


def with_factors(slide: Slide, factors: Sequence[float]) -> Slide:
    """Return a slider with positions at factors of the model's value, and its own outside of their range."""
    model_value = slide.values[slide.here]
    # Twelve digits keep 0.1 x 20 um from being 2.0000000000000003e-06 in the model file.
    common = tuple(
        model_value if factor == 1.0 else float(f"{factor * model_value:.12g}") for factor in factors
    )
    outside = [value for value in slide.values if not common[0] <= value <= common[-1]]
    values = tuple(sorted([*common, *outside]))
    return replace(slide, values=values, here=values.index(model_value), complete=True, common=common)


def slider(name: str, paths: tuple[str, ...], unit: str, low: float, high: float, own_value: float) -> Slide:
    """Return a slider with positions from low to high, evenly or geometrically spaced, including the model's
    value.
    """
    wide = low > 0.0 and high / low >= WIDE
    shares = [k / (POSITIONS - 1) for k in range(POSITIONS)]
    values = [low * (high / low) ** share if wide else low + (high - low) * share for share in shares]
    values = [float(f"{value:.3g}") for value in values]
    gap = min((abs(a - b) for a, b in zip(values, values[1:], strict=False)), default=0.0)
    values = sorted({own_value, *(value for value in values if abs(value - own_value) > 0.3 * gap)})
    return Slide(name, paths, unit, tuple(values), values.index(own_value))


def with_positions(slide: Slide, positions: Sequence[int]) -> Slide:
    """Return a slider with some of its positions, including the model's own."""
    values = tuple(slide.values[k] for k in positions)
    common = tuple(value for value in slide.common if value in values)
    return replace(slide, values=values, here=values.index(slide.values[slide.here]), common=common)


def thinned_positions(slide: Slide, limit: int) -> list[int]:
    """Return ``limit`` positions of a slider, including the model's own. A quarter of those of a slider
    with common factors, at least two, are not at such factors.
    """
    shared = [k for k, value in enumerate(slide.values) if value in slide.common]
    if not shared:
        return spaced(range(len(slide.values)), limit, slide.here)
    outside = sorted({*range(len(slide.values))} - {*shared})
    room = max(2, limit // 4)
    return sorted([*spaced(shared, limit - room, slide.here), *spaced(outside, room)])


def spaced(positions: Sequence[int], limit: int, here: int | None = None) -> list[int]:
    """Return at most ``limit`` of the positions, evenly spaced; ``here`` replaces the nearest one."""
    count = len(positions)
    if count <= limit or limit < 2:
        return [*positions] if count <= limit else []
    places = {round(k * (count - 1) / (limit - 1)) for k in range(limit)}
    if here is not None:
        # The model's own position must remain: it is the setting with which the page starts, and the base of
        # all patches.
        place = positions.index(here)
        *_, nearest = min((abs(k - place), -k, k) for k in places)
        places = (places - {nearest}) | {place}
    return [positions[k] for k in sorted(places)]


def number_at(mechanism: Mechanism, path: str) -> tuple[float, str]:
    """Return the number at a path such as ``joint.C.contact.restitution``, and its unit. Raises ValueError if
    there is none.
    """
    parameter = Parameter(mechanism, path)
    value = parameter.get()
    if parameter.quantity is None or not isinstance(value, float) or not math.isfinite(value):
        raise ValueError(f"{shown(path)} is no number that a slider could change")
    return value, parameter.unit
