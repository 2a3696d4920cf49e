"""Moments of a run as people name them: an angle of the crank in the last turn, or a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import Fault, VfifeError, shown
from ..units import number
from .turn import abscissa

if TYPE_CHECKING:
    from ..results.view import View


def output_at(result: View, text: str) -> int:
    """The output nearest to a moment: ``90deg`` or ``0.25 turn`` in the last turn, ``12ms`` or a bare number of seconds; a load factor.

    Raises VfifeError for what is no moment of the run.
    """
    moments = result.time
    if result.record.static:
        at = _read(text, "1")
        if at is None:
            raise VfifeError(f"at {shown(text)}: this is a static analysis; give a load factor, up to {moments[-1]:g}")
    else:
        at, angle = _read(text, "s"), _read(text, "rad")
        if at is None and angle is not None:
            return _at_angle(result, float(np.degrees(angle)), text)
        if at is None:
            raise VfifeError(f"at {shown(text)}: this is neither an angle nor a time; give 90deg, or 12ms")
    if not moments[0] <= at <= moments[-1]:
        unit = "" if result.record.static else " s"
        raise VfifeError(f"at {shown(text)}: the run goes from {moments[0]:g} to {moments[-1]:g}{unit}")
    return int(np.argmin(np.abs(moments - at)))


def _at_angle(result: View, angle: float, text: str) -> int:
    if result.crank is None:
        raise VfifeError(f"at {shown(text)}: nothing is driven, so there is no crank with an angle; give a time, as 12ms")
    inside = np.flatnonzero(result.last_turn)
    off = np.abs(np.mod(abscissa(result)[inside] - angle + 180.0, 360.0) - 180.0)
    k = int(np.argmin(off))
    spacing = float(np.abs(np.diff(abscissa(result)[inside])).max()) if len(inside) > 1 else 0.0
    if off[k] > spacing:
        low, high = np.sort(abscissa(result)[inside[[0, -1]]])
        raise VfifeError(f"at {shown(text)}: {result.crank} goes from {low:.4g} to {high:.4g} degrees in this run")
    return int(inside[k])


def _read(text: str, unit: str) -> float | None:
    try:
        return number(text, unit)
    except Fault:
        return None
