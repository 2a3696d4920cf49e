"""ESDU 78035, 1978: the tribology data item of the Engineering Sciences Data Unit."""

import math
from dataclasses import dataclass

from ..law import Pair
from .forms import OVERVIEW, LineContact


@dataclass(frozen=True, kw_only=True)
class Esdu78035(LineContact):
    """F_N = F_e [1 + chi rate/impact_speed], delta = F_e s/L [ln(4 L dR/(F_e s)) + 1], s = (sigma_i +
    sigma_j)/pi, sigma = (1 - nu^2)/E.
    """

    name = "esdu-78035"
    source = (
        "ESDU 78035: Contact phenomena I: stresses, deflections and contact dimensions for normally-loaded "
        f"unlubricated elastic components. Engineering Sciences Data Unit (1978); as in {OVERVIEW}"
    )
    formula = "F = F_e (1 + chi d'/d'0), d = F_e s/L (ln(4 L dR/(F_e s)) + 1), s = 1/(pi E*)"

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N)."""
        self.require_inside(pair)
        s = 1.0 / (math.pi * pair.composite_modulus)
        return s / pair.axial_length, 4.0 * math.e * pair.axial_length * pair.clearance / s
