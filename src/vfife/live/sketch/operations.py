"""Operations on a sketch, each with a name and arguments: the text of a model file before and after."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from ...model.bodies import Link
from ...model.joints import Joint
from ...model.rows import Guided, place_row
from ...modelfile.paths import assign, parsed
from ...modelfile.tables import tables
from ...numerics.scalar import cos, sin
from .additions import add_bar, add_joint, add_load, add_pin, add_point, add_slider, anchor, drive
from .edit import Edit, finite, length_unit, refusal
from .removal import delete

# Sizes of a new kind, as shares of the size of the mechanism: a clearance of 1/50 of the radius is loose, and
# can be seen.
CLEARANCE, RADIUS, LENGTH, HEIGHT = 4e-4, 2e-2, 0.1, 0.05
DIRECTION_PLACES = 6  # decimals of the direction of a guide
# Kinds that need no more than two pins and a direction, with their own values.
CHOICES: dict[str, dict[str, Any]] = {
    "ideal": {},
    "clearance": {"clearance": CLEARANCE, "bearing_radius": RADIUS},
    "slider": {},
    "slot": {"turning": True},
    "clearance-slider": {"clearance": CLEARANCE, "length": LENGTH, "height": HEIGHT},
    "weld": {},
}


def apply(text: str, name: str, arguments: dict[str, Any], file: str | None = None) -> str:
    """Return the text of a model file after an operation; comments and all other values remain.

    ``file`` is the path of the model, beside which its tables are.
    Raises ModelError if the operation is unknown, its arguments do not fit, or the result is no valid model.
    """
    act = OPERATIONS.get(name)
    if act is None:
        raise refusal(f"there is no operation {name!r}", f"use {', '.join(OPERATIONS)}")
    edit = Edit.of(text, file)
    try:
        inspect.signature(act).bind(edit, **arguments)
    except TypeError as error:
        raise refusal(f"{name}: {error}", "see vfife.live.sketch.operations") from None
    act(edit, **arguments)
    return edit.text(text) if act in FREE else edit.fixed_text(text)


def move_point(edit: Edit, point: str, x: float, y: float) -> None:
    """Move a pin, and all pins that joints hold there, to (x, y) in m at the start of the motion.

    Links that end there get another length and angle; their other ends remain where they are. A pin in a
    guide stays on it.
    """
    cluster = edit.pose.cluster(edit.side(point))
    target = edit.on_guides(cluster, finite(x, y))
    for side in cluster:
        edit.move(side, target)
    edit.stretch_rods(cluster, target)


def set_length(edit: Edit, body: str, length: float) -> None:
    """Give a link a length (m); the mechanism closes anew."""
    entry, part = edit.entry("body", body), edit.mechanism.bodies[body]
    size, _ = finite(length, 0.0)
    if not isinstance(part, Link):
        raise refusal(f"{body} has no length", "drag its pins")
    edit.lengthen(part, entry, size)


def set_direction(edit: Edit, joint: str, angle: float) -> None:
    """Turn a straight guide to an angle (rad) from the x axis of its bearing's body; the mechanism closes
    anew.
    """
    entry = edit.entry("joint", joint)
    value, _ = finite(angle, 0.0)
    if not isinstance(place_row(edit.mechanism.joints[joint].rows()), Guided):
        raise refusal(f"{joint} has no straight guide", "choose a joint with a guide")
    entry["direction"] = [round(part, DIRECTION_PLACES) + 0.0 for part in (cos(value), sin(value))]


def set_value(edit: Edit, section: str, name: str, key: str, value: str) -> None:
    """Set a value of a table, written as in ``--set``: a number with its unit, a list, a text."""
    edit.entry(section, name)
    assign(edit.raw, (section, name, key), parsed(value))


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


FREE: tuple[Callable[..., None], ...] = (move_point, set_length, set_direction, set_value)  # bodies may move
STRUCTURE: tuple[Callable[..., None], ...] = (
    add_point, add_pin, add_bar, add_joint, anchor, add_slider, add_load, drive, delete, set_kind,
)  # fmt: skip
OPERATIONS = {act.__name__: act for act in (*FREE, *STRUCTURE)}
