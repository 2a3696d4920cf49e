"""Contact in a point: Hertz' elastic force of two spheres, which the field uses for journals as well, with
any hysteresis damping.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ..law import Pair, quantity
from .damping import Damped

PLASTIC = (
    1e-3  # of the same: from some 5 m/s on steel flows in full (Johnson, Contact Mechanics, 1985, Table 11.1)
)
# of sqrt(E/rho): the fastest impact of Hertz' quasi-static theory (Love, Mathematical Theory of Elasticity,
# 1944)
SLOWEST_WAVE = 1e-5


@dataclass(frozen=True, kw_only=True)
class PointContact(Damped):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed].

    K = 4 E*/3 sqrt(R_B R_J/(R_B -+ R_J)) unless given, minus for a journal in a bearing, plus for two rounds
    side by side.
    """

    slots: ClassVar[tuple[str, ...]] = ("stiffness", "damping_factor")

    stiffness: float | None = quantity(
        "N/m^1.5", "generalised stiffness K; from radii and materials if left out", None, above=0.0
    )

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^1.5) and damping factor (1)."""
        stiffness = self.stiffness
        if stiffness is None:
            stiffness = 4.0 / 3.0 * pair.composite_modulus * math.sqrt(pair.relative_radius)
        return float(stiffness), self.damping_factor

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, damping_factor = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """2/5 K delta^2.5 (J)."""
        from ...numerics.elementwise import sqrt

        return 0.4 * p[0] * (penetration * penetration * sqrt(penetration))

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Beside the restitution: impacts so fast that metals flow, a hundred times faster than Hertz' theory
        allows.
        """
        cautions = super().cautions(pair, penetration, impact_speed)
        limit = PLASTIC * pair.wave_speed
        if impact_speed is None or impact_speed <= limit:
            return cautions
        return (
            *cautions,
            (
                f"impacts of up to {impact_speed:.3g} m/s are faster than 1e-3 sqrt(E/rho) = {limit:.3g} m/s,"
                " from where on metals yield all round the contact and keep a dent: an elastic force is too"
                " large there, and too short"
            ),
        )

    def usual(self, pair: Pair) -> tuple[float, float]:
        """From the 1e-5 sqrt(E/rho) of Hertz' quasi-static theory, 5 cm/s for steel, to the 1e-3 sqrt(E/rho)
        from which metals flow in full.
        """
        return SLOWEST_WAVE * pair.wave_speed, PLASTIC * pair.wave_speed
