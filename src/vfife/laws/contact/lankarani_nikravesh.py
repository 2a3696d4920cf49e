"""Lankarani and Nikravesh 1990: Hertz' elastic force with hysteresis damping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ..law import ContactLaw, Pair, quantity
from .damping import lankarani_nikravesh


@dataclass(frozen=True)
class LankaraniNikravesh(ContactLaw):
    """F_N = K delta^1.5 [1 + 3 (1 - c_e^2)/4 * rate/impact_speed].

    K = 4 E*/3 sqrt(R_B R_J/(R_B - R_J)) unless given: two spheres, one inside the other, as the literature uses it for journals.
    """

    name: ClassVar[str] = "lankarani-nikravesh"
    source: ClassVar[str] = (
        "Lankarani, Nikravesh: A contact force model with hysteresis damping for impact analysis of multibody systems. "
        "Journal of Mechanical Design 112 (1990) 369-376"
    )
    formula: ClassVar[str] = "F = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'0)"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "damping_factor")

    restitution: float = quantity("1", "restitution coefficient c_e", 0.9, above=0.0, high=1.0)
    stiffness: float | None = quantity("N/m^1.5", "generalised stiffness K; from radii and materials if left out", None, above=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^1.5) and damping factor (1)."""
        stiffness = self.stiffness
        if stiffness is None:
            stiffness = 4.0 / 3.0 * pair.composite_modulus * math.sqrt(pair.bearing_radius * pair.journal_radius / pair.clearance)
        return float(stiffness), lankarani_nikravesh(self.restitution)

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, damping_factor = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """2/5 K delta^2.5 (J)."""
        return 0.4 * p[0] * penetration**2.5
