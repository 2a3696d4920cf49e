"""A force and a moment at a pin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...fields import SCALAR, Each, Many, Measure, Switch, described, quantity
from ..polynomials import Polynomials, clamped, constant
from .load import Load


@dataclass(frozen=True, kw_only=True)
class PointForce(Load):
    """Force (N) and moment (N m) at ``at`` = ``body.pin``; fixed in space, or turning with the body where it is to ``follow``.

    With ``times`` (s) and ``factors`` both are multiplied by a function of time, the factors joined by a natural cubic
    spline; before the first and after the last time they keep their end values.
    """

    kind: ClassVar[str] = "force"
    sample: ClassVar[dict[str, Any]] = {"force": (3.0, -2.0), "moment": 0.1}

    force: tuple[float, float] = described(Each((Measure("N"), Measure("N"))), "force", (0.0, 0.0))
    moment: float = quantity("N m", "moment", 0.0)
    follow: bool = described(Switch(), "true: the force turns with the body; false: it is fixed in space", False)
    times: tuple[float, ...] | None = described(Many(Measure("s")), "times of the factors, ascending", None)
    factors: tuple[float, ...] | None = described(Many(SCALAR), "what multiplies force and moment, at the times", None)

    @property
    def acts(self) -> tuple[float, float, float]:
        """Force (N, N) and moment (N m) where the factor is 1."""
        return (*self.force, self.moment)

    @property
    def follows(self) -> bool:
        """Whether the force turns with the body."""
        return self.follow

    @property
    def steady(self) -> bool:
        """Whether it is the same at all times."""
        return self.times is None or self.factors is None

    def factor(self) -> Polynomials:
        """What force and moment are multiplied by over time (s)."""
        return constant(1.0) if self.times is None or self.factors is None else clamped(self.times, self.factors)
