"""Operations on a sketch, each with a name and arguments: the text of a model file before and after."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

from ...model.bodies import Link
from .edit import Edit, refusal
from .pose import Point

OPERATIONS: dict[str, Callable[..., None]] = {}


def operation(function: Callable[..., None]) -> Callable[..., None]:
    """Register an operation under its name."""
    OPERATIONS[function.__name__] = function
    return function


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
    return edit.text(text)


def finite(*values: Any) -> tuple[float, ...]:
    """Return numbers. Raises ModelError for anything else."""
    if not all(
        isinstance(one, int | float) and not isinstance(one, bool) and math.isfinite(one) for one in values
    ):
        raise refusal(f"{values!r} are not finite numbers", "give coordinates in m")
    return tuple(float(one) for one in values)


@operation
def move_point(edit: Edit, point: str, x: float, y: float) -> None:
    """Move a pin, and all pins that joints hold there, to (x, y) in m at the start of the motion.

    Links that end there get another length and angle; their other ends remain where they are. A pin in a
    guide stays on it.
    """
    at: Point = finite(x, y)  # type: ignore[assignment]
    cluster = edit.pose.cluster(edit.side(point))
    target = edit.on_guides(cluster, at)
    for side in cluster:
        edit.move(side, target)
    edit.stretch_rods(cluster, target)


@operation
def set_length(edit: Edit, body: str, length: float) -> None:
    """Give a link a length (m); the mechanism closes anew."""
    entry, noun = edit.entry("body", body), edit.mechanism.bodies[body]
    [size] = finite(length)
    if not isinstance(noun, Link):
        raise refusal(f"{body} has no length", "drag its pins")
    edit.lengthen(noun, entry, size)
