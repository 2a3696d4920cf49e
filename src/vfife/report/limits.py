"""Where a run went beyond what its models are for: one warning with numbers, and quiet lines on what is
usual.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..laws import Material
from ..laws.materials import hardness_of
from ..measures.contacts import CONFORMAL, line_pressure
from ..model.surfaces import cautions, remarks, surfaces

if TYPE_CHECKING:
    from ..results.view import View

PIN = 0.1  # of the journal's radius: a pin that sinks in deeper is no pin any more


def worst(result: View) -> dict[str, tuple[float, float]]:
    """Deepest penetration (m) and fastest impact (m/s) of each joint with play, over the whole run."""
    record = result.record
    found: dict[str, tuple[float, float]] = {}
    if not record.assembly.contacts:
        return found
    depths = record.block("contact_penetration_max").max(axis=0)
    speeds = record.block("contact_fastest")[-1] if record.keeps("contact_fastest") else np.zeros(len(depths))
    for name, depth, speed in zip(record.assembly.contact_joints, depths, speeds, strict=True):
        before = found.get(name, (0.0, 0.0))
        found[name] = max(before[0], float(depth)), max(before[1], float(speed))
    return found


def out_of_range(result: View) -> Iterable[str]:
    """Sentences of the laws on where the run left their ranges, and one on what no joint is built for."""
    found = worst(result)
    yield from cautions(result.record.assembly.mechanism, found)
    beyond = [*_too_deep(result, found), *_too_hard(result)]
    if beyond:
        yield (
            f"Beyond what joints are built for, at some time of the run: {'; '.join(beyond)}. Forces are"
            " taken as the laws give them; check loads, sizes and materials, and the law's stiffness."
        )


def quiet(result: View) -> list[str]:
    """Lines on what is usual and worth a line."""
    return list(remarks(result.record.assembly.mechanism, worst(result)))


def _too_deep(result: View, found: dict[str, tuple[float, float]]) -> Iterable[str]:
    """Penetrations beyond the clearance, or beyond a tenth of the pin's radius, whichever is the less; joints
    with one limit together.
    """
    mechanism, alike = result.record.assembly.mechanism, dict[str, list[str]]()
    for name, (depth, _) in found.items():
        joint = mechanism.contacts[name]
        pin, clearance = (
            PIN * surfaces(mechanism, joint).journal_radius,
            getattr(joint, "clearance", None) or np.inf,
        )
        text = (
            f"a clearance of {1e6 * clearance:.4g} µm"
            if clearance < pin
            else f"a tenth of the journal's radius, {1e6 * pin:.4g} µm"
        )
        if depth > min(pin, clearance):
            alike.setdefault(text, []).append(f"{1e6 * depth:.4g} µm in {name}")
    yield from (f"penetrations of {', '.join(depths)} are more than {text}" for text, depths in alike.items())


def _too_hard(result: View) -> Iterable[str]:
    """Hertz' line pressure beyond the hardness of the softer material, over the whole run; joints with one
    material together.
    """
    record = result.record
    largest: dict[str, float] = {}
    squares = record.block("contact_force_squared_max").max(axis=0) if record.assembly.contacts else []
    for name, square in zip(record.assembly.contact_joints, squares, strict=True):
        largest[name] = max(largest.get(name, 0.0), float(square))
    alike: dict[str, list[str]] = {}
    for name, square in largest.items():
        pair = surfaces(record.assembly.mechanism, record.assembly.mechanism.contacts[name])
        softest = softer(pair.bearing, pair.journal)
        pressure = float(line_pressure(pair, np.sqrt(square))[0])
        if softest is not None and pressure > softest[1]:
            text = f"the hardness of {softest[0]}, {1e-9 * softest[1]:.3g} GPa"
            alike.setdefault(text, []).append(
                f"{1e-9 * pressure:.3g} GPa in {name} on its {1e3 * pair.axial_length:.4g} mm"
            )
    yield from (f"line pressures of {', '.join(found)} are more than {text}" for text, found in alike.items())


def conformal(result: View) -> list[str]:
    """Joints whose contact becomes wider than Hertz' theory is for."""
    mechanism, found = result.record.assembly.mechanism, []
    for contact, name in zip(
        result.record.assembly.contacts, result.record.assembly.contact_joints, strict=True
    ):
        width = result.measures.get(f"{contact}.contact_half_width.max", 0.0)
        if (
            width > CONFORMAL * surfaces(mechanism, mechanism.contacts[name]).journal_radius
            and name not in found
        ):
            found.append(name)
    return found


def softer(*materials: Material) -> tuple[str, float] | None:
    """The softer of those whose hardness is known, with it (Pa)."""
    known = [(one.name, hard) for one in materials if (hard := hardness_of(one)) is not None]
    return min(known, key=lambda one: one[1], default=None)
