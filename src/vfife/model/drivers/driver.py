"""Base of all drivers."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...schema import Direction, Text, described, key_of
from ...units import in_rpm
from ..geometry.polynomials import Polynomials
from ..kind import Kind

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver(Kind):
    """Base of all drivers, which act on the angle of ``body``, the travel of the joint ``slider``, or the pin
    ``point`` along ``direction`` (fixed in space).

    The angle (rad) is measured from the body's start angle. A body turns about its one ideal revolute joint
    to the ground, or relative to the body ``against``. Travel and path (m) are measured from the start.
    """

    body: str = described(Text("body"), "the driven body, by default that with the name of the driver", "")
    slider: str = described(Text("joint"), 'a joint of kind "slider"', "")
    point: str = described(Text("pin"), 'the pin, "body.pin"', "")
    direction: Point = described(Direction(), "direction, fixed in space", (1.0, 0.0))
    against: str = described(
        Text("body"), "body against which the angle counts, or on which the opposite torque acts", "ground"
    )

    lead: ClassVar[str] = ""  # the field whose key in a file determines the kind
    moves: ClassVar[bool] = True  # whether it prescribes a motion; else a torque or a force
    drives: ClassVar[tuple[str, ...]] = ("body", "slider", "point")  # what it can act on
    tabled: ClassVar[bool] = True  # a model file may have its table in a CSV file beside it
    revolves: ClassVar[bool] = False  # may turn a body round and round
    has_turns: ClassVar[bool] = False  # does so at a constant speed, at least in the end: its turns are equal
    registry: ClassVar[dict[str, type[Driver]]] = {}

    @property
    def target(self) -> str:
        """Type of what is driven: "body", "slider" or "point"."""
        return "slider" if self.slider else "point" if self.point else "body"

    @property
    def lead_key(self) -> str:
        """Key of a model file that determines the kind of driver."""
        return self.lead_keys(self.is_linear)

    @classmethod
    def lead_keys(cls, linear: bool) -> str:
        """Return that key for a driver along a line (``linear``) or about an axis."""
        return next(
            (key_of(field, linear) for field in dataclasses.fields(cls) if field.name == cls.lead), cls.lead
        )

    @property
    def is_linear(self) -> bool:
        """Whether the driver acts along a line (m or N) rather than about an axis (rad or N m)."""
        return bool(self.slider or self.point)

    def motion(self, offset: float = 0.0) -> Polynomials:
        """Return the prescribed motion over time (rad or m), plus ``offset``. Raises TypeError for a torque
        or force.
        """
        raise TypeError(f"{type(self).__name__} prescribes no motion")

    def effort(self) -> Polynomials:
        """Return the torque (N m) or force (N). Raises TypeError for a prescribed motion."""
        raise TypeError(f"{type(self).__name__} is neither a torque nor a force")

    @property
    def argument(self) -> Literal["time", "speed", "angle"]:
        """Argument of the effort: time (s), angular speed of the body (rad/s), or its angle from the start
        (rad).
        """
        return "time"

    @property
    def steady(self) -> bool:
        """Whether the effort is independent of time."""
        return True

    @property
    def largest_speed(self) -> float:
        """Largest prescribed speed (rad/s or m/s)."""
        return 0.0

    def crank_turns(self, turn: float, begin: float, duration: float) -> float | None:
        """Return the turns (1) that the body makes within a ``duration`` (s) from the time ``begin`` (s) on,
        if it runs up then, its ``turn`` at the largest speed taking so long (s); None for all other motions.
        """
        return None

    @property
    def steady_speed(self) -> float | None:
        """Prescribed speed (rad/s or m/s) if constant, else None."""
        return None

    def in_rpm(self, speed: float) -> str:
        """Return a rotational speed (rad/s) in parentheses in rpm; nothing for a driver along a line."""
        return "" if self.is_linear else f" ({in_rpm(speed)})"

    @property
    def end(self) -> float | None:
        """Time (s) at which the table of its motion ends; None for other motions, which have no end."""
        return None

    @property
    def unit(self) -> str:
        """Unit of the prescribed motion."""
        return "m" if self.is_linear else "rad"

    @property
    def words(self) -> str:
        """Description for readers."""
        return self.kind
