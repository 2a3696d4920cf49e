"""Pereira, Ramalho and Ambrosio 2011: the enhanced cylindrical contact force."""

from dataclasses import dataclass

from ...numerics.scalar import log, power
from ..law import Pair
from .forms import OVERVIEW, PowerLaw

SMALLEST, LARGEST = 0.005, 10.0  # mm, the clearances of the fit inside a bearing


@dataclass(frozen=True, kw_only=True)
class Pereira(PowerLaw):
    """F_N = (a dR + b) L E*/dR delta^n [1 + chi rate/impact_speed], Eq. 26-28 of the VFIFE paper.

    The law is written for mm, MPa and N (dR, delta and L in mm); in metres, with n kept, the stiffness is
    multiplied by 10^(3n). Inside a bearing dR = R_i - R_j, a = 0.965, b = 0.0965, n = Y dR^-0.005, Y = 1.51
    [ln(1000 dR)]^-0.151 below dR = 0.34954 mm and
    0.0151 dR + 1.151 from there; side by side dR = R_i + R_j, a = 0.39, b = 0.85, n = 1.094. chi = 3/4 (1 -
       c_e^2) unless another is named.
    """

    name = "pereira"
    source = (
        "Pereira, Ramalho, Ambrosio: An enhanced cylindrical contact force model. Multibody System Dynamics"
        f" 35 (2015) 277-298; coefficients from {OVERVIEW}"
    )
    formula = "F = (a dR + b) L E*/dR d^n (1 + 3/4 (1 - e^2) d'/d'0), mm, MPa, N"
    common = True

    def exponent(self, pair: Pair) -> float:
        """Return the exponent n for the clearance of ``pair`` (Eq. 27c, d). Raises ValueError for a clearance
        below the range of the fit.
        """
        gap = 1e3 * pair.radius_difference
        if pair.external:
            return 1.094
        if gap <= 1e-3:
            raise ValueError(
                f'the law "pereira" has no exponent for a clearance of {pair.clearance:.4g} m; its fit begins'
                " at 5e-06 m"
            )
        y = 1.51 * power(log(1000.0 * gap), -0.151) if gap < 0.34954 else 0.0151 * gap + 1.151
        return y * power(gap, -0.005)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^n), n - 1 (1) and damping factor (1)."""
        gap, length, modulus = (
            1e3 * pair.radius_difference,
            1e3 * pair.axial_length,
            1e-6 * pair.composite_modulus,
        )
        a, b = (0.39, 0.85) if pair.external else (0.965, 0.0965)
        n = self.exponent(pair)
        return (a + b / gap) * length * modulus * power(10.0, 3.0 * n), n - 1.0, self.damping_factor

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Beside the restitution: clearances outside the fit."""
        gap, cautions = 1e3 * pair.clearance, super().cautions(pair, penetration, impact_speed)
        if pair.external or SMALLEST <= gap <= LARGEST:
            return cautions
        speed_text = (
            f"the clearance of {gap:.4g} mm is outside the {SMALLEST:g} to {LARGEST:g} mm of the fit, whose"
            " formula is used all the same"
        )
        return (*cautions, speed_text)
