"""Pereira, Ramalho and Ambrosio 2011: the enhanced cylindrical contact force, internal contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ...kernels.elementary import power
from ..law import ContactLaw, Pair, quantity
from .damping import lankarani_nikravesh


@dataclass(frozen=True)
class Pereira(ContactLaw):
    """F_N = (a dR + b) L E*/dR delta^n [1 + 3 (1 - c_e^2)/4 * rate/impact_speed], Eq. 26-28 of the VFIFE paper.

    The law is written for mm, MPa and N (dR, delta and L in mm); in metres, with n kept, the stiffness is multiplied by 10^(3n).
    a = 0.965, b = 0.0965, n = Y dR^-0.005, Y = 1.51 [ln(1000 dR)]^-0.151 below dR = 0.34954 mm and 0.0151 dR + 1.151 from there.
    """

    name: ClassVar[str] = "pereira"
    source: ClassVar[str] = (
        "Pereira, Ramalho, Ambrosio: An enhanced cylindrical contact force model. Multibody System Dynamics 35 (2015) 277-298; "
        "coefficients from Pereira, Ramalho, Ambrosio: A critical overview of internal and external cylinder contact force models. "
        "Nonlinear Dynamics 63 (2011) 681-697"
    )
    formula: ClassVar[str] = "F = (a dR + b) L E*/dR d^n (1 + 3/4 (1 - e^2) d'/d'0), mm, MPa, N"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "exponent_beyond_1", "damping_factor")

    restitution: float = quantity("1", "restitution coefficient c_e", 0.9, above=0.0, high=1.0)

    def exponent(self, pair: Pair) -> float:
        """Exponent n for the clearance (Eq. 27c, d)."""
        gap = 1e3 * pair.clearance
        y = 1.51 * math.log(1000.0 * gap) ** -0.151 if gap < 0.34954 else 0.0151 * gap + 1.151
        return y * gap**-0.005

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^n), n - 1 (1) and damping factor (1)."""
        gap, length, modulus = 1e3 * pair.clearance, 1e3 * pair.axial_length, 1e-6 * pair.composite_modulus
        n = self.exponent(pair)
        stiffness = (0.965 * gap + 0.0965) * length * modulus / gap * 10.0 ** (3.0 * n)
        return stiffness, n - 1.0, lankarani_nikravesh(self.restitution)

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, exponent_beyond_1, damping_factor = p
        elastic = stiffness * penetration * power(penetration, exponent_beyond_1)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """K delta^(n + 1)/(n + 1) (J)."""
        return p[0] * penetration ** (p[1] + 2.0) / (p[1] + 2.0)
