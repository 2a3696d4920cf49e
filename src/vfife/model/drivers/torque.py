"""A torque or a force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Many, Measure, described
from ..renamed import renamed
from .driver import Driver


@renamed(torque="value")
@dataclass(frozen=True, kw_only=True)
class Torque(Driver):
    """Torque (N m) on ``body`` (and its opposite on ``against``), or force (N) on ``point`` along ``direction``.

    A constant, or a table over time (s), over the speed of the body (``speeds``, rad/s: a motor's curve) or over its angle from the start
    (``angles``, rad). Tables are natural cubic splines through their points and keep their end values beyond.
    """

    kind: ClassVar[str] = "effort"

    lead: ClassVar[str] = "value"
    moves: ClassVar[bool] = False
    drives: ClassVar[tuple[str, ...]] = ("body", "point")

    value: float | tuple[float, ...] = described(
        Measure("N m", series=True),
        "torque: one, or one for each of the times, speeds or angles",
        key="torque",
        along=described(Measure("N", series=True), "force: one, or one for each of the times, speeds or travels", key="force"),
    )
    times: tuple[float, ...] | None = described(Many(Measure("s")), "times of the values of a table, ascending", None)
    speeds: tuple[float, ...] | None = described(
        Many(Measure("rad/s")),
        "angular velocities of the torques, ascending: a motor's curve",
        None,
        along=described(Many(Measure("m/s")), "velocities of the forces, ascending"),
    )
    angles: tuple[float, ...] | None = described(
        Many(Measure("rad")),
        "angles from the start angle: at the times, or of the torques",
        None,
        along=described(Many(Measure("m")), "ways from the start: at the times, or of the forces", key="travels"),
    )
