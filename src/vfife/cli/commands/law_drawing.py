"""Numbers and picture of a law by itself: contact laws in free impacts, friction laws in steady sliding."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import suggestion
from ...laws import MATERIALS, ContactLaw, FrictionLaw, Law, Pair
from ...laws.check import try_out
from ...measures.impact import breakaway, free_impact, presliding, steady_sliding, with_restitution
from ...model.readers import read_law
from ...model.validation.settings import unsuitable
from ...modelfile.csvtables import expand_curves
from ...modelfile.paths import parsed
from ...plots.laws import save_law
from ..arguments.models import LawsOptions
from ..outputs import PICTURES, refuse_folder
from ..terminal import writing
from ..values import overrides, positive


def draw_law(law: dict[str, Any], options: LawsOptions) -> dict[str, Any]:
    """Numbers of a law by itself, and the file with its picture."""
    contacts = law["kind"] == "contact"
    mass, speed, normal = (
        positive(f"--{name.replace('_', '-')}", getattr(options, name), unit)
        for name, unit in (("mass", "kg"), ("speed", "m/s"), ("normal_force", "N"))
    )
    pair = pair_of(options)
    base: Any = ContactLaw if contacts else FrictionLaw
    instance: Any = build_law(base.registry[law["name"]], law["kind"], options.set_, pair)
    target = target_of(options.picture, law["name"])
    numbers, curves = contact(instance, pair, mass, speed) if contacts else friction(instance, pair, normal)
    with writing(str(target), "The existing file is unchanged."):
        save_law(law["kind"], target, **curves)
    return {
        "derived": instance.derived(pair),
        "units": instance.units(pair),
        "numbers": numbers,
        "picture": str(target),
    }


LOOPS = (0.3, 0.5, 0.7, 0.9, 1.0)
RESTITUTIONS = tuple(round(0.05 * k, 2) for k in range(1, 21))
SPEEDS = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)  # of the table


def surfaces(clearance: str, radius: str, length: str, materials: tuple[str, str]) -> Pair:
    """Return the pair of surfaces of the options: lengths as quantities (m). Raises ValueError for impossible
    ones.
    """
    options = (("--bearing-radius", radius), ("--clearance", clearance), ("--axial-length", length))
    outer, gap, width = (positive(option, text, "m") for option, text in options)
    if gap >= outer:
        raise ValueError(
            f"--clearance {clearance}: as large as the bearing, so the journal vanishes; allowed: below"
            f" --bearing-radius {radius}"
        )
    for name in materials:
        if name not in MATERIALS:
            raise ValueError(
                f"--material {name}: there is no material of this name."
                f" {suggestion(name, MATERIALS, 'name one of them')}"
            )
    return Pair(outer, gap, width, MATERIALS[materials[0]], MATERIALS[materials[1]])


def build_law(law: type[Law], kind: str, texts: Iterable[str] | None, pair: Pair) -> Law:
    """Build the law with the values of ``--set`` and evaluate it at these surfaces. Raises ValueError with
    all faults.
    """
    holder = {"law": law.name, **{key: parsed(value) for key, value in overrides(texts)}}
    broken = expand_curves(holder, "laws") if kind == "contact" else []
    instance, faults = read_law(kind, holder)
    faults = broken + [fault for fault in faults if fault.path[:1] not in {fault.path for fault in broken}]
    if instance is None or faults:
        raise ValueError("\n".join(f"--set {fault}" for fault in faults))
    if reason := unsuitable(instance, pair):
        raise ValueError(
            f"{reason} (clearance {pair.clearance:g} m); try another --clearance, --bearing-radius or"
            " --material"
        )
    try_out([(instance, pair)])
    return instance


def contact(law: Any, pair: Pair, mass: float, speed: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers of free impacts through a contact law, and what to draw of them."""
    has_restitution = hasattr(law, "restitution")
    loops, rows = {}, []
    for value in RESTITUTIONS if has_restitution else (None,):
        try:
            variant = with_restitution(law, value) if value is not None else law
            impact = free_impact(variant, pair, mass, speed)
        except (ArithmeticError, ValueError):
            continue  # a coefficient that this law does not take
        rows.append(
            {
                "restitution": value,
                "delivered": impact.restitution,
                "deepest": impact.deepest,
                "force": impact.largest,
                "time": impact.duration,
            }
        )
        if value is None or value in LOOPS:
            loops["free impact" if value is None else f"{value:g} → {impact.restitution:.3f}"] = impact
    restitutions = np.array([entry["restitution"] for entry in rows]) if has_restitution else None
    delivered = (restitutions, np.array([entry["delivered"] for entry in rows])) if has_restitution else None
    dry = ", dry contact" if law.film else ""
    title = (
        f"{law.name}{dry}: {mass:g} kg at {speed:g} m/s, clearance {1e3 * pair.clearance:g} mm, radius"
        f" {1e3 * pair.bearing_radius:g} mm"
    )
    return {"mass": mass, "speed": speed, "impacts": rows}, {
        "title": title,
        "loops": loops,
        "delivered": delivered,
    }


def friction(law: Any, pair: Pair, normal: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers of steady sliding through a friction law, and what to draw of it."""
    positive_ = np.geomspace(1e-5, 1.0, 81)
    speeds = np.concatenate([-positive_[::-1], [0.0], positive_])
    forces = steady_sliding(law, pair, normal, speeds)
    at = steady_sliding(law, pair, normal, SPEEDS)
    numbers: dict[str, Any] = {
        "normal_force": normal,
        "steady": [{"speed": v, "force": 0.0 - float(f)} for v, f in zip(SPEEDS, at, strict=True)],
    }
    loops = {}
    if law.memory:
        numbers["breakaway"] = reach = breakaway(law, pair, normal)
        loops = {f"{share:g}": presliding(law, pair, normal, share * reach) for share in (0.5, 1.0, 3.0)}
    title = f"{law.name}: normal force {normal:g} N"
    return numbers, {"title": title, "speeds": speeds, "forces": forces, "loops": loops, "normal": normal}


def target_of(picture: Path | None, name: str) -> Path:
    """Return the file to draw into. Raises ValueError for an unknown ending, or a folder."""
    plain = re.sub(r"[^\w-]+", "-", name).strip("-") or "law"
    target = picture if picture is not None else Path(f"{plain}.png")
    if target.suffix.lower() not in PICTURES:
        raise ValueError(
            f"-o {target}: the ending chooses the kind of picture; allowed: {', '.join(PICTURES)}"
        )
    refuse_folder("-o", target)
    return target


def pair_of(options: LawsOptions) -> Pair:
    """Return the pair of surfaces of the options. Raises ValueError for impossible ones."""
    bearing, _, journal = options.material.partition(",")
    return surfaces(
        options.clearance,
        options.bearing_radius,
        options.axial_length,
        (bearing.strip(), journal.strip() or bearing.strip()),
    )
