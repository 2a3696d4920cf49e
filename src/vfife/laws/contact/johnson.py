"""Johnson 1985: two cylinders in line contact."""

import math
from dataclasses import dataclass

from ..law import Pair
from .forms import OVERVIEW, LineContact


@dataclass(frozen=True, kw_only=True)
class Johnson(LineContact):
    """F_N = F_e [1 + chi rate/impact_speed], delta = F_e/(pi E* L) [ln(4 pi E* L dR/F_e) - 1].

    dR = R_i - R_j inside, R_i + R_j side by side. Inside, nothing deeper than 4 dR/e^2 = 0.5413 dR has a
    force.
    """

    name = "johnson"
    source = f"Johnson: Contact Mechanics. Cambridge University Press (1985); as in {OVERVIEW}"
    formula = "F = F_e (1 + chi d'/d'0), d = F_e/(pi E* L) (ln(4 pi E* L dR/F_e) - 1)"

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N). Raises ValueError for a cylinder on a plane."""
        difference = self.finite_difference(pair)
        line = math.pi * pair.composite_modulus * pair.axial_length
        return 1.0 / line, 4.0 * line * difference / math.e
