"""Goldsmith 1960: two cylinders."""

import math
from dataclasses import dataclass

from ..law import Pair
from .forms import OVERVIEW, LineContact


@dataclass(frozen=True, kw_only=True)
class Goldsmith(LineContact):
    """F_N = F_e [1 + chi rate/impact_speed], delta = F_e s/L [ln(L/(F_e R s)) + 1], s = (sigma_i +
    sigma_j)/pi, sigma = (1 - nu^2)/E.

    The argument of the logarithm has a unit, 1/m^2, so the law depends on the units it is written in: here m
    and N, R = R_i R_j/(R_i - R_j).
    """

    name = "goldsmith"
    source = (
        "Goldsmith: Impact, the theory and physical behaviour of colliding solids. Edward Arnold (1960); as"
        f" in {OVERVIEW}"
    )
    formula = "F = F_e (1 + chi d'/d'0), d = F_e s/L (ln(L/(F_e R s)) + 1), s = 1/(pi E*), m, N"

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N)."""
        self.require_inside(pair)
        s = 1.0 / (math.pi * pair.composite_modulus)
        return s / pair.axial_length, math.e * pair.axial_length / (pair.relative_radius * s)
