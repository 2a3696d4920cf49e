"""The force and moment at a pin."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics.scalar import hypot
from ...schema import SCALAR, FixedList, FreeList, Measure, Switch, Text, described, quantity
from ..joints import Joint
from .load import Load, Push, Values


@dataclass(frozen=True, kw_only=True)
class PointForce(Load):
    """A force (N), a moment (N m) or both at ``at`` = ``body.pin``, fixed in space or, with ``follow``,
    turning with the body.

    ``factors`` multiply both by a table over ``times`` (s), ``angles`` of a crank (rad), or ``travels`` (m)
    or ``speeds`` (m/s) along the guide of the joint ``slider``; ``factors_back`` apply on the return stroke.
    """

    kind = "force"
    keys = ("factors", "factors_back")
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {
        "force": (),
        "moment": (("force", "follow"), ("moment",)),
    }
    sample: ClassVar[dict[str, Any]] = {"at": "arm.end", "force": (3.0, -2.0), "moment": 0.1}

    at: str = described(Text("pin"), 'where it acts, "body.pin"')
    force: tuple[float, float] = described(FixedList((Measure("N"), Measure("N"))), "force", (0.0, 0.0))
    moment: float = quantity("N m", "moment", 0.0)
    follow: bool = described(
        Switch(), "true: the force turns with the body; false: it is fixed in space", False
    )
    factors: tuple[float, ...] | None = described(
        FreeList(SCALAR), "what multiplies force and moment: one for each place of the table", None
    )
    factors_back: tuple[float, ...] | None = described(
        FreeList(SCALAR), "the same on the way back, if different", None
    )

    @property
    def values(self) -> Values:
        """The factors; 1 without a table."""
        return 1.0 if self.factors is None else self.factors

    @property
    def values_back(self) -> Values:
        """The factors of the return stroke."""
        return self.factors_back

    @property
    def words(self) -> str:
        """Description for readers."""
        size = hypot(*self.force)
        parts = [f"force {size:.6g} N"] if size or not self.moment else []
        parts += [f"moment {self.moment:.6g} N m"] if self.moment else []
        return " and ".join(parts) + (", turning with the body" if self.follow and size else "") + self.by

    @property
    def place(self) -> str:
        """The pin, "body.pin"."""
        return self.at

    def pushes(self, joints: Mapping[str, Joint]) -> tuple[Push, ...]:
        """Return force and moment at the pin."""
        body, _, pin = self.at.partition(".")
        return (Push(body, pin, (*self.force, self.moment), self.follow),)
