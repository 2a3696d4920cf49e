"""Radzimovsky 1953: two rolling cylinders."""

import math
from dataclasses import dataclass

from ...numerics.scalar import exp
from ..law import Pair
from .forms import OVERVIEW, LineContact


@dataclass(frozen=True, kw_only=True)
class Radzimovsky(LineContact):
    """F_N = F_e [1 + chi rate/impact_speed], delta = F_e/(pi E* L) [2/3 + ln(4 R_i/b) + ln(4 R_j/b)], b =
    1.60 sqrt(F_e R/(L E*)).

    R = R_i R_j/dR, so R_i R_j/b^2 = L E* dR/(1.60^2 F_e); dR = R_i - R_j inside, R_i + R_j side by side.
    """

    name = "radzimovsky"
    source = (
        "Radzimovsky: Stress distribution and strength conditions of two rolling cylinders. University of "
        f"Illinois Engineering Experiment Station, Bulletin 408 (1953); as in {OVERVIEW}"
    )
    formula = (
        "F = F_e (1 + chi d'/d'0), d = F_e/(pi E* L) (2/3 + ln(4 Ri/b) + ln(4 Rj/b)), b = 1.60 sqrt(F_e R/(L"
        " E*))"
    )

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N). Raises ValueError for a cylinder on a plane."""
        difference = self.finite_difference(pair)
        line = pair.composite_modulus * pair.axial_length
        return 1.0 / (math.pi * line), 16.0 / (1.60 * 1.60) * exp(2.0 / 3.0) * line * difference
