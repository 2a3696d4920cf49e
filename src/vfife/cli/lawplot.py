"""A law by itself, for ``vfife laws NAME --plot``: which surfaces, which parameters, numbers and picture."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .options import overrides, positive

if TYPE_CHECKING:
    from ..laws import Law, Pair

LOOPS = (0.3, 0.5, 0.7, 0.9, 1.0)
ASKED = tuple(round(0.05 * k, 2) for k in range(1, 21))
SPEEDS = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)  # of the table


def surfaces(clearance: str, radius: str, length: str, materials: tuple[str, str]) -> Pair:
    """The pair of surfaces that the options tell. Raises ValueError for what is none."""
    from ..errors import suggestion
    from ..laws import MATERIALS, Pair

    options = (("--bearing-radius", radius), ("--clearance", clearance), ("--axial-length", length))
    outer, gap, along = (positive(option, text, "m") for option, text in options)
    if gap >= outer:
        raise ValueError(f"--clearance {clearance}: as large as the bearing, so no journal is left; allowed: below --bearing-radius {radius}")
    for name in materials:
        if name not in MATERIALS:
            raise ValueError(f"--material {name}: there is no material of this name. {suggestion(name, MATERIALS, 'name one of them')}")
    return Pair(outer, gap, along, MATERIALS[materials[0]], MATERIALS[materials[1]])


def made(law: type[Law], kind: str, texts: Iterable[str] | None, pair: Pair) -> Law:
    """The law with what ``--set`` says, tried out at these surfaces. Raises ValueError with all that is wrong."""
    from ..laws.check import try_out
    from ..model.reading import read_law
    from ..model.validate.settings import senseless
    from ..modelfile.csvtables import expand_curves
    from ..modelfile.paths import parsed

    holder = {"law": law.name, **{key: parsed(value) for key, value in overrides(texts)}}
    broken = expand_curves(holder, "laws") if kind == "contact" else []
    found, faults = read_law(kind, holder)
    faults = broken + [one for one in faults if one.path[:1] not in {fault.path for fault in broken}]
    if found is None or faults:
        raise ValueError("\n".join(f"--set {fault}" for fault in faults))
    if what := senseless(found, pair):
        raise ValueError(f"{what} (clearance {pair.clearance:g} m); try another --clearance, --bearing-radius or --material")
    try_out([(found, pair)])
    return found


def contact(law: Any, pair: Pair, mass: float, speed: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers of free impacts through a contact law, and what to draw of them."""
    import numpy as np

    from ..analysis.impact import free_impact, with_restitution

    has = hasattr(law, "restitution")
    loops, rows = {}, []
    for value in ASKED if has else (None,):
        try:
            one = with_restitution(law, value) if value is not None else law
            found = free_impact(one, pair, mass, speed)
        except (ArithmeticError, ValueError):
            continue  # a coefficient that this law does not take
        rows.append(
            {"restitution": value, "delivered": found.restitution, "deepest": found.deepest, "force": found.largest, "time": found.duration}
        )
        if value is None or value in LOOPS:
            loops["free impact" if value is None else f"{value:g} → {found.restitution:.3f}"] = found
    asked = np.array([entry["restitution"] for entry in rows]) if has else None
    delivered = (asked, np.array([entry["delivered"] for entry in rows])) if has else None
    dry = ", dry contact" if law.film else ""
    title = f"{law.name}{dry}: {mass:g} kg at {speed:g} m/s, clearance {1e3 * pair.clearance:g} mm, radius {1e3 * pair.bearing_radius:g} mm"
    return {"mass": mass, "speed": speed, "impacts": rows}, {"title": title, "loops": loops, "delivered": delivered}


def friction(law: Any, pair: Pair, normal: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Numbers of steady sliding through a friction law, and what to draw of it."""
    import numpy as np

    from ..analysis.impact import breakaway, presliding, remembers, steady_sliding

    positive_ = np.geomspace(1e-5, 1.0, 81)
    speeds = np.concatenate([-positive_[::-1], [0.0], positive_])
    forces = steady_sliding(law, pair, normal, speeds)
    at = steady_sliding(law, pair, normal, SPEEDS)
    found: dict[str, Any] = {"normal_force": normal, "steady": [{"speed": v, "force": 0.0 - float(f)} for v, f in zip(SPEEDS, at, strict=True)]}
    loops = {}
    if remembers(law, pair, normal):
        found["breakaway"] = reach = breakaway(law, pair, normal)
        loops = {f"{share:g}": presliding(law, pair, normal, share * reach) for share in (0.5, 1.0, 3.0)}
    title = f"{law.name}: normal force {normal:g} N"
    return found, {"title": title, "speeds": speeds, "forces": forces, "loops": loops, "normal": normal}


def target_of(asked: Path | None, name: str) -> Path:
    """The file to draw into. Raises ValueError where none can be there."""
    plain = re.sub(r"[^\w-]+", "-", name).strip("-") or "law"
    target = asked if asked is not None else Path(f"{plain}.png")
    if target.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise ValueError(f"-o {target}: the ending chooses the kind of picture; allowed: .png, .pdf, .svg")
    if not target.absolute().parent.is_dir():
        raise ValueError(f"-o {target}: there is no folder {target.absolute().parent}; make it first")
    return target
