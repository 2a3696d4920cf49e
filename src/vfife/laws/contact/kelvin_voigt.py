"""Kelvin and Voigt: a linear spring and a linear damper side by side."""

from dataclasses import dataclass

from ..law import Pair, quantity
from .forms import Linear


@dataclass(frozen=True, kw_only=True)
class KelvinVoigt(Linear):
    """F_N = k delta + c rate, cut where it would pull."""

    name = "kelvin-voigt"
    source = "definition"
    formula = "F = k d + c d'"

    stiffness: float = quantity("N/m", "stiffness k: force over depth with another law", above=0.0)
    damping_coefficient: float = quantity("N s/m", "damping coefficient c, such as 1e-4 s x k", low=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """k (N/m) and c (N s/m)."""
        return self.stiffness, self.damping_coefficient
