"""Anagnostopoulos 1988: a linear spring, and a linear damper that follows from the restitution."""

import math
from dataclasses import dataclass

from ...numerics.scalar import atan2, exp, hypot, log
from ..law import Pair, quantity
from .forms import Linear


@dataclass(frozen=True, kw_only=True)
class Anagnostopoulos(Linear):
    """F_N = k delta + c rate, c = 2 xi sqrt(k m), xi = -ln c_e/sqrt(pi^2 + ln^2 c_e), m the effective mass of
    the two bodies.

    The source lets the force pull until the surfaces part, and delivers c_e exactly then. Here it never
    pulls, so somewhat more is given back: exp[-xi/sqrt(1 - xi^2) (pi - arctan2(2 xi sqrt(1 - xi^2), 1 - 2
    xi^2))].
    """

    name = "anagnostopoulos"
    source = (
        "Anagnostopoulos: Pounding of buildings in series during earthquakes. Earthquake Engineering and"
        " Structural Dynamics 16 (1988) 443-456"
    )
    formula = "F = k d + 2 xi sqrt(k m) d', xi = -ln e/sqrt(pi^2 + ln^2 e)"

    stiffness: float = quantity("N/m", "stiffness k", above=0.0)
    restitution: float = quantity("1", "restitution coefficient c_e", 0.9, above=0.0, high=1.0)
    effective_mass: float | None = quantity(
        "kg", "m_i m_j/(m_i + m_j); from the two bodies if left out", None, above=0.0
    )

    @property
    def damping_ratio(self) -> float:
        """xi."""
        logarithm = log(self.restitution)
        return -logarithm / hypot(math.pi, logarithm)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """k (N/m) and c (N s/m)."""
        mass = pair.effective_mass if self.effective_mass is None else self.effective_mass
        if mass is None:
            raise ValueError(
                'the law "anagnostopoulos" needs the effective mass of the two bodies, which is not known'
                " here; give its effective_mass"
            )
        return self.stiffness, 2.0 * self.damping_ratio * math.sqrt(self.stiffness * mass)

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Where never pulling changes the restitution noticeably."""
        xi = self.damping_ratio
        root = math.sqrt(1.0 - xi * xi)
        rebound = exp(-xi / root * (math.pi - atan2(2.0 * xi * root, 1.0 - 2.0 * xi * xi)))
        if rebound - self.restitution <= 0.05:
            return ()
        return (
            (
                f"a restitution of {self.restitution:.4g} is set, but a free impact rebounds with"
                " {rebound:.4g}, because the force does not pull"
            ),
        )
