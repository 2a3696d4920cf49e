"""Massless elements of force between two bodies: springs and dampers along a line, about an axis, stops and bushings."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Spring:
    """Spring and damper between two pins, ``first`` and ``second`` (``body.pin`` or ``ground.point``), along the line between them.

    F = stiffness (l - free_length) + damping dl/dt, pulling where positive; N/m, N s/m, m. The free length is the distance at the start unless
    given.
    """

    name: str
    first: str
    second: str
    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float | None = None


@dataclass(frozen=True, kw_only=True)
class TorsionalSpring:
    """Spring and damper about the axis of the plane between two bodies (or the ground).

    M = -stiffness (angle - free_angle) - damping rate on the second body, angle that of the second less that of the first; N m/rad, N m s/rad,
    rad. The free angle is the angle at the start unless given.
    """

    name: str
    first: str
    second: str
    stiffness: float = 0.0
    damping: float = 0.0
    free_angle: float | None = None


@dataclass(frozen=True, kw_only=True)
class Stop:
    """Rotational stop: the angle of the second body less that of the first stays between ``low`` and ``high`` (rad).

    Beyond either the stop answers like a torsional spring and damper (N m/rad, N m s/rad); it never pulls back.
    """

    name: str
    first: str
    second: str
    low: float
    high: float
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Bushing:
    """Elastic bearing between two pins: stiffness (N/m, N/m, N m/rad) and damping (N s/m, N s/m, N m s/rad) in x, y and about the axis.

    The axes are those of the first body; the bushing is free of force where the pins coincide and the angle is that of the start.
    """

    name: str
    first: str
    second: str
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float] = (0.0, 0.0, 0.0)


AnySpring = Spring | TorsionalSpring | Stop | Bushing
