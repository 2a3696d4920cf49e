"""Drivers: the prescribed rotation of a body about its ideal joint to the ground, or a torque on it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Driver:
    """``body`` turns about its ideal joint to the ground."""

    body: str


@dataclass(frozen=True, kw_only=True)
class ConstantSpeed(Driver):
    """Angle = start angle + speed t; speed in rad/s."""

    speed: float


@dataclass(frozen=True, kw_only=True)
class Ramp(Driver):
    """From rest to ``speed`` (rad/s) within ``duration`` (s): the speed is a fifth-order step, 10 s^3 - 15 s^4 + 6 s^5, then constant."""

    speed: float
    duration: float


@dataclass(frozen=True, kw_only=True)
class AngleTable(Driver):
    """Angle (rad) at given times (s), from the start angle, joined by a cubic spline; the last piece goes on."""

    times: tuple[float, ...]
    angles: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Torque(Driver):
    """Torque (N m) on a body: a constant, or a table over time (s)."""

    torque: float | tuple[float, ...]
    times: tuple[float, ...] | None = None
