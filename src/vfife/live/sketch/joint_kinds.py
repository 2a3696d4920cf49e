"""Change of a joint's kind: a revolute or a guide, ideal or with clearance."""

from __future__ import annotations

from typing import Any

from ...model.joints import Joint
from ...modelfile.tables import tables
from .edit import Edit, refusal
from .rounding import length_unit

# Sizes of a new kind, as shares of the size of the mechanism: a clearance of 1/50 of the radius is loose, and
# can be seen.
CLEARANCE, RADIUS, LENGTH, HEIGHT = 4e-4, 2e-2, 0.1, 0.05
# Kinds that need no more than two pins and a direction, with their own values.
CHOICES: dict[str, dict[str, Any]] = {
    "ideal": {},
    "clearance": {"clearance": CLEARANCE, "bearing_radius": RADIUS},
    "slider": {},
    "slot": {"turning": True},
    "clearance-slider": {"clearance": CLEARANCE, "length": LENGTH, "height": HEIGHT},
    "weld": {},
}


def choice_of(joint: Joint) -> str:
    """Return the choice that a joint corresponds to; its kind if it is none of them."""
    return "slot" if joint.kind == "slider" and getattr(joint, "turning", False) else joint.kind


def set_kind(edit: Edit, joint: str, choice: str) -> None:
    """Change the kind of a joint between its two pins; keys that the new kind also has keep their values.

    A new clearance, radius, length or height is a share of the size of the mechanism.
    """
    entry = edit.entry("joint", joint)
    if choice not in CHOICES:
        raise refusal(f"no joint is changed to {choice!r}", f"choose one of {', '.join(CHOICES)}")
    if choice == choice_of(edit.mechanism.joints[joint]):
        return
    kind = "slider" if choice == "slot" else choice
    [kind_table] = [table for table in tables("joint") if table.word == kind]
    old = {
        key: value
        for key, value in entry.items()
        if key in kind_table.keys and key not in ("kind", "turning")
    }
    entry.clear()
    entry.update({} if kind_table.optional else {"kind": kind}, **old)
    for key, share in CHOICES[choice].items():
        if key not in entry:
            entry[key] = share if share is True else _rounded(edit, share)


def _rounded(edit: Edit, share: float) -> Any:
    """Return a share of the size of a mechanism, rounded to one digit, as it is written."""
    value = float(f"{share * edit.pose.size:.1g}")
    return f"{1e3 * value:g} mm" if length_unit(edit.raw) else value
