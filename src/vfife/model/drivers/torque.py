"""The driver that applies a torque or force."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal

from ...schema import Choice, FreeList, Measure, described
from ...units import in_rpm
from ..geometry.polynomials import Polynomials, constant
from ..geometry.tabulated import INTERPOLATIONS, JOINING, Interpolation, extended, table
from .driver import Driver


@dataclass(frozen=True, kw_only=True)
class Torque(Driver):
    """A torque (N m) on ``body`` with its opposite on ``against``, or a force (N) on ``point`` along
    ``direction``.

    It is constant, or a table over time (s), over the speed of the body (``speeds``, rad/s: a motor's
    characteristic) or over its angle from the start (``angles``, rad). ``interpolation`` connects the values
    of a table; beyond its ends a table keeps its end values.
    """

    kind = "effort"
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {
        "torque": (("slider", "point", "direction"), ("body",))
    }
    sample: ClassVar[dict[str, Any]] = {"value": 2.0}
    lead = "value"
    moves = False
    drives = ("body", "point")

    value: float | tuple[float, ...] = described(
        Measure("N m", series=True),
        "torque: one, or one for each of the times, speeds or angles",
        key="torque",
        linear=described(
            Measure("N", series=True),
            "force: one, or one for each of the times, speeds or travels",
            key="force",
        ),
    )
    times: tuple[float, ...] | None = described(
        FreeList(Measure("s")), "times of the values of a table, ascending", None
    )
    speeds: tuple[float, ...] | None = described(
        FreeList(Measure("rad/s")),
        "angular velocities of the torques, ascending: a motor's curve",
        None,
        linear=described(FreeList(Measure("m/s")), "velocities of the forces, ascending"),
    )
    angles: tuple[float, ...] | None = described(
        FreeList(Measure("rad")),
        "angles from the start angle: at the times, or of the torques",
        None,
        linear=described(
            FreeList(Measure("m")), "travels from the start: at the times, or of the forces", key="travels"
        ),
    )
    interpolation: Interpolation = described(Choice(INTERPOLATIONS), JOINING, "monotone")

    def effort(self) -> Polynomials:
        """Return the torque (N m) or force (N) over its ``argument``."""
        return self._effort

    @cached_property
    def _effort(self) -> Polynomials:
        if isinstance(self.value, int | float):
            return constant(float(self.value))
        places = self.speeds or self.angles or self.times
        return (
            constant(float(self.value[0]))
            if places is None
            else extended(table(places, self.value, self.interpolation))
        )

    @property
    def argument(self) -> Literal["time", "speed", "angle"]:
        """Argument of the effort: time (s), angular speed of the body (rad/s), or its angle from the start
        (rad).
        """
        return "speed" if self.speeds is not None else "angle" if self.angles is not None else "time"

    @property
    def steady(self) -> bool:
        """Whether the effort is independent of time."""
        return self.times is None

    @property
    def words(self) -> str:
        """Description for readers."""
        quantity_name, newton = ("force", "N") if self.point else ("torque", "N m")
        argument_text = (
            " over speed"
            if self.speeds
            else " over " + ("travel" if self.point else "angle")
            if self.angles
            else ""
        )
        if isinstance(self.value, int | float):
            return f"{quantity_name} {self.value:.6g} {newton}"
        span = f"{min(self.value):.6g} to {max(self.value):.6g} {newton}"
        if self.speeds and not self.is_linear:
            argument_text += f" up to {self.speeds[-1]:.6g} rad/s ({in_rpm(self.speeds[-1])})"
        return f"table of {len(self.value)} {quantity_name}s{argument_text}, {span}"
