"""Dubowsky and Freudenstein 1971: a pin in a cylindrical bearing."""

import math
from dataclasses import dataclass

from ...numerics.scalar import integer_power
from ..law import Pair
from .forms import OVERVIEW, LineContact


@dataclass(frozen=True, kw_only=True)
class DubowskyFreudenstein(LineContact):
    """F_N = F_e [1 + chi rate/impact_speed], delta = F_e s/L [ln(L^3 dR/(F_e R_i R_j s)) + 1], s = (sigma_i +
    sigma_j)/pi, sigma = (1 - nu^2)/E.
    """

    name = "dubowsky-freudenstein"
    source = (
        "Dubowsky, Freudenstein: Dynamic analysis of mechanical systems with clearances. Part 1: Formation"
        f" of dynamic model. Journal of Engineering for Industry 93 (1971); as in {OVERVIEW}"
    )
    formula = "F = F_e (1 + chi d'/d'0), d = F_e s/L (ln(L^3 dR/(F_e Ri Rj s)) + 1), s = 1/(pi E*)"

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N)."""
        self.require_inside(pair)
        s = 1.0 / (math.pi * pair.composite_modulus)
        return s / pair.axial_length, math.e * integer_power(pair.axial_length, 3) / (
            pair.relative_radius * s
        )
