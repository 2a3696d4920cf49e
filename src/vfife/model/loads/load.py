"""What all loads share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Text, described
from ..kind import Kind
from ..polynomials import Polynomials, constant


@dataclass(frozen=True, kw_only=True)
class Load(Kind):
    """A force and a moment at ``at`` = ``body.pin``, both multiplied by a function of time."""

    name: str
    at: str = described(Text("pin"), 'where it acts, "body.pin"')

    registry: ClassVar[dict[str, type[Load]]] = {}

    @property
    def acts(self) -> tuple[float, float, float]:
        """Force (N, N) and moment (N m) where its function is 1."""
        raise NotImplementedError

    @property
    def follows(self) -> bool:
        """Whether the force turns with the body; else it is fixed in space."""
        return False

    @property
    def steady(self) -> bool:
        """Whether it is the same at all times."""
        return True

    def factor(self) -> Polynomials:
        """What force and moment are multiplied by over time (s)."""
        return constant(1.0)
