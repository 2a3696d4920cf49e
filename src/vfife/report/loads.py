"""Loads of a mechanism before a run: kind, place, and the lowest and highest value of each component."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..kinematics.table_peak import table_peak
from .amounts import prefixed
from .digits import Json

if TYPE_CHECKING:
    from ..kinematics.full_turn import FullTurn
    from ..kinematics.initial import Motion
    from ..model.loads import Load
    from ..model.mechanism import Mechanism

COMPONENTS = (("force_x", "N"), ("force_y", "N"), ("moment", "N m"))
WORDS = {"force_x": "force x", "force_y": "force y", "force": "force", "moment": "moment"}


def loads(
    mechanism: Mechanism, motion: Motion | None = None, turn: FullTurn | None = None
) -> list[dict[str, Any]]:
    """Return name, kind, description, place, argument and components of each load.

    A component has the ``lowest`` and ``highest`` value (``unit``) that tables and expressions give it; the
    force of a load on a guide is along the direction of the guide. With the ``motion`` at the start and a
    ``turn`` of the crank, a table over its angle has its ``peak`` against the dead centres (see
    :class:`~vfife.kinematics.table_peak.TablePeak`).
    """
    return [
        {
            "name": name,
            "kind": load.kind,
            "what": load.words,
            "acts_on": load.place,
            "by": load.argument if load.axis else None,
            "components": list(_components(mechanism, load)),
            **_peak(mechanism, load, motion, turn),
        }
        for name, load in mechanism.loads.items()
    ]


def _peak(
    mechanism: Mechanism, load: Load, motion: Motion | None, turn: FullTurn | None
) -> dict[str, dict[str, Any]]:
    """Return the peak of a table over the crank's angle as data, with ``words``; nothing without one."""
    peak = None if motion is None or turn is None else table_peak(mechanism, motion, turn, load)
    if peak is None:
        return {}
    unit = load.measured[0]
    size = f"{1e-5 * peak.value:.4g} bar" if unit == "Pa" else prefixed(peak.value, unit)
    words = f"peak {size}{peak.words.removeprefix('peak')}"
    return {"peak": {**dataclasses.asdict(peak), "unit": unit, "words": words}}


def _components(mechanism: Mechanism, load: Load) -> Iterator[dict[str, Any]]:
    """Yield the components of a load that are not zero; of none, the first."""
    if load.on_guide:
        amounts = [("force", "N", load.unit)]
    else:
        acts = load.pushes(mechanism.joints)[0].acts
        amounts = [(name, unit, act) for (name, unit), act in zip(COMPONENTS, acts, strict=True)]
    for name, unit, factor in [entry for entry in amounts if entry[2]] or amounts[:1]:
        lowest, highest = sorted(factor * value for value in load.bounds)
        yield {"quantity": name, "unit": unit, "lowest": lowest, "highest": highest}


def load_words(entry: Json) -> str:
    """Return a load with its place, and its values with their units, in words."""
    texts = []
    for component in entry["components"]:
        ends = dict.fromkeys(f"{component[key] + 0.0:.6g}" for key in ("lowest", "highest"))
        texts.append(f"{WORDS[component['quantity']]} {' to '.join(ends)} {component['unit']}")
    texts += [entry["peak"]["words"]] if "peak" in entry else []
    return f"Load {entry['name']} on {entry['acts_on']}: {entry['what']}; {', '.join(texts)}"
