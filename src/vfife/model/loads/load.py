"""What all loads share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...errors import Fault
from ...schema import Text, described
from ..geometry.polynomials import Polynomials, constant
from ..joints import Joint
from ..kind import Kind

Over = Literal["time", "angle", "travel", "speed"]
Triple = tuple[float, float, float]
OVER: dict[str, Over] = {
    "times": "time",
    "angles": "angle",
    "travels": "travel",
    "speeds": "speed",
}  # by the key of a table's places


@dataclass(frozen=True)
class Push:
    """Force (N, N) and moment (N m) on ``body`` at its ``pin``, or on the body itself where that is empty,
    where the load's function is 1.

    ``follow``: the force turns with the body; else it is fixed in space. ``aligned``: its direction is that
    of another body's frame at the start, and turns with this one.
    """

    body: str
    pin: str
    acts: Triple
    follow: bool = False
    aligned: str = ""


@dataclass(frozen=True, kw_only=True)
class Load(Kind):
    """Forces and moments on bodies, multiplied by a function of time, of an angle, of a travel along a guide
    or of its speed.
    """

    name: str
    crank: str = described(
        Text("body"), "body whose angle the load depends on; the driven one that revolves if left out", ""
    )
    slider: str = described(
        Text("joint"), "a joint with a guide, whose travel or speed the load depends on", ""
    )

    registry: ClassVar[dict[str, type[Load]]] = {}

    @property
    def words(self) -> str:
        """What it is, in a few words."""
        return self.kind

    @property
    def place(self) -> str:
        """Where it acts: a pin, "body.pin", or the joint along whose guide it does."""
        return self.slider

    @property
    def measured(self) -> tuple[str, str]:
        """The unit of its function, and what that is."""
        return "1", "what multiplies the load"

    def pushes(self, joints: Mapping[str, Joint]) -> tuple[Push, ...]:
        """On which bodies it acts, and how, where its function is 1."""
        raise NotImplementedError

    tabled: ClassVar[bool] = True  # a model file may have its table in a CSV file beside it
    along: ClassVar[bool] = False  # whether it acts along the guide of a joint; else at a pin

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of its values, and of those of the way back."""
        return ()

    def conflicts(self) -> Iterator[Fault]:
        """Sizes that do not go together; of what is not known (None) nothing is said."""
        yield from ()

    def cautions(self) -> tuple[str, ...]:
        """Sentences on what is strange in it, though it can be meant."""
        return ()

    @property
    def over(self) -> Over:
        """What its function depends on: time (s), an angle (rad), a travel (m) or the speed of that (m/s)."""
        return "time"

    @property
    def steady(self) -> bool:
        """Whether it does not depend on time."""
        return True

    def course(self) -> tuple[Polynomials, float]:
        """What forces and moments are multiplied by, and the gap (m) by which the part for the way back lies
        before that for the way out.
        """
        return constant(1.0), 0.0
