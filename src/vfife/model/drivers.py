"""Drivers: a prescribed motion of a body, a slider or a pin, or a torque or force on it."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What is driven: the angle of ``body``, the travel of the joint ``slider``, or the pin ``point`` along ``direction`` (fixed in space).

    The angle (rad) counts from the body's start angle; a body turns about its one ideal revolute to the ground, or, with ``against``, relative
    to another body. Travel and path (m) count from the start.
    """

    body: str = ""
    slider: str = ""
    point: str = ""
    direction: Point = (1.0, 0.0)
    against: str = "ground"


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed(Driver):
    """speed t; rad/s or m/s."""

    speed: float


@dataclass(frozen=True, kw_only=True)
class Ramp(Driver):
    """From rest to ``speed`` (rad/s, m/s) within ``duration`` (s): the speed is a fifth-order step, 10 s^3 - 15 s^4 + 6 s^5, then constant."""

    speed: float
    duration: float


@dataclass(frozen=True, kw_only=True)
class StepTo(Driver):
    """From 0 to ``travel`` (rad, m) between ``begin`` and ``begin + duration`` (s), by the step 10 s^3 - 15 s^4 + 6 s^5; at rest else."""

    travel: float
    duration: float
    begin: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Harmonic(Driver):
    """amplitude [sin(2 pi frequency t + phase) - sin(phase)]; rad or m, Hz, rad."""

    amplitude: float
    frequency: float
    phase: float = 0.0


@dataclass(frozen=True, kw_only=True)
class AngleTable(Driver):
    """Angle (rad) or travel (m) at given times (s), joined by a cubic spline; the last piece goes on."""

    times: tuple[float, ...]
    angles: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Torque(Driver):
    """Torque (N m) on ``body`` (and its opposite on ``against``), or force (N) on ``point`` along ``direction``.

    A constant, or a table over time (s), over the speed of the body (``speeds``, rad/s: a motor's curve) or over its angle from the start
    (``angles``, rad). Tables are natural cubic splines through their points and keep their end values beyond.
    """

    torque: float | tuple[float, ...]
    times: tuple[float, ...] | None = None
    speeds: tuple[float, ...] | None = None
    angles: tuple[float, ...] | None = None
