"""Base of all loads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from ...errors import Fault
from ...schema import Text, described
from ..geometry.polynomials import Polynomials, constant
from ..joints import Joint
from ..kind import Kind

Argument = Literal["time", "angle", "travel", "speed"]
Triple = tuple[float, float, float]
# Argument of a table, by the field with its places.
ARGUMENTS: dict[str, Argument] = {"times": "time", "angles": "angle", "travels": "travel", "speeds": "speed"}


@dataclass(frozen=True)
class Push:
    """Force (N, N) and moment (N m) of a load whose function is 1, on ``body`` at its ``pin``, or on the body
    as a whole if ``pin`` is empty.

    With ``follow`` the force turns with the body, else it is fixed in space. ``aligned`` names another body
    in whose frame at the start the direction is given; the force then turns with the loaded body.
    """

    body: str
    pin: str
    acts: Triple
    follow: bool = False
    aligned: str = ""


@dataclass(frozen=True, kw_only=True)
class Load(Kind):
    """Base of all loads with a unique ``name``: forces and moments on bodies, multiplied by a function of
    time, of an angle, or of the travel or speed along a guide.
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
        """Description for readers."""
        return self.kind

    @property
    def place(self) -> str:
        """Where it acts: a pin, "body.pin", or the joint along whose guide it acts."""
        return self.slider

    @property
    def measured(self) -> tuple[str, str]:
        """Unit and meaning of its function."""
        return "1", "what multiplies the load"

    def pushes(self, joints: Mapping[str, Joint]) -> tuple[Push, ...]:
        """Return the forces and moments for a function value of 1; ``joints`` are those of the mechanism, by
        name.
        """
        raise NotImplementedError

    tabled: ClassVar[bool] = True  # a model file may have its table in a CSV file beside it
    on_guide: ClassVar[bool] = False  # whether it acts along the guide of a joint; else at a pin

    @property
    def keys(self) -> tuple[str, ...]:
        """Field names of its values and of the values of the return stroke."""
        return ()

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for each pair of values that contradict each other; unknown values (None) are
        skipped.
        """
        yield from ()

    def cautions(self) -> tuple[str, ...]:
        """Return the sentences on values that are unusual but possible."""
        return ()

    @property
    def argument(self) -> Argument:
        """Argument of its function: time (s), angle (rad), travel (m) or speed (m/s)."""
        return "time"

    @property
    def steady(self) -> bool:
        """Whether it is independent of time."""
        return True

    def course(self) -> tuple[Polynomials, float]:
        """Return the function that multiplies forces and moments, and the gap (m) by which the part for the
        return stroke lies before that for the forward stroke.
        """
        return constant(1.0), 0.0
