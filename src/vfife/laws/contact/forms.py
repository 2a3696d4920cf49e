"""Forms of the elastic force that several contact laws share.

They are a linear spring, Hertz' power for contact in a point, and, for contact along the line of two
cylinders, a power or the relation delta = alpha F ln(beta/F), which is implicit in the force. With w =
ln(beta/F) this relation reads w exp(-w) = delta/(alpha beta), so F = delta/(alpha w), where w - ln w =
ln(alpha beta/delta): one function of one number serves all laws of this form, without an iteration in the
step. The relation has a largest penetration, alpha beta/e at w = 1, where the stiffness becomes infinite;
from w = 1.1 on, at 0.9953 of it, the force continues along its tangent, 1/[alpha (w - 1)] = 10/alpha.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kernels.elementary import log, logarithmic, power
from ...numerics import elementwise
from ...numerics.scalar import exp
from ..law import ContactLaw, Pair, quantity
from .damping import DAMPING, Damped

OVERVIEW = (
    "Pereira, Ramalho, Ambrosio: A critical overview of internal and external cylinder contact force models."
    " Nonlinear Dynamics 63 (2011) 681-697"
)
LAST = 1.1  # w at which the tangent begins
# Speeds over sqrt(E/rho): that of the fastest impact of Hertz' quasi-static theory (Love, Mathematical Theory
# of Elasticity, 1944), and that from which metals flow in full, some 5 m/s for steel (Johnson, Contact
# Mechanics, 1985, Table 11.1).
QUASI_STATIC = 1e-5
PLASTIC = 1e-3
MISFIT = 1e3  # ratio of stiffnesses: beyond it one is of other materials, or in another unit
MILLIMETRES = 1e3 * math.sqrt(1e3)  # N/m^1.5 of one N/mm^1.5


@dataclass(frozen=True, kw_only=True)
class Linear(ContactLaw):
    """F_N = k delta + c rate while the surfaces touch.

    The force begins with a jump, c times the impact speed, and would pull before they part: it ends where it
    comes down to zero.
    """

    slots = ("stiffness", "damping_coefficient")

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, damping = p
        return stiffness * penetration, damping if penetration > 0.0 else 0.0

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """k delta^2/2 (J)."""
        return 0.5 * p[0] * (penetration * penetration)


@dataclass(frozen=True, kw_only=True)
class PointContact(Damped):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed].

    K = 4 E*/3 sqrt(R_B R_J/(R_B -+ R_J)) unless given, minus for a journal in a bearing, plus for two rounds
    side by side.
    """

    slots = ("stiffness", "damping_factor")

    stiffness: float | None = quantity(
        "N/m^1.5", "generalised stiffness K; from radii and materials if left out", None, above=0.0
    )

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^1.5) and damping factor (1)."""
        stiffness = pair.hertz_stiffness if self.stiffness is None else self.stiffness
        return float(stiffness), self.damping_factor

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, damping_factor = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """2/5 K delta^2.5 (J)."""
        return 0.4 * p[0] * (penetration * penetration * elementwise.sqrt(penetration))

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Beside the restitution: a stiffness that does not fit the materials, and impacts so fast that
        metals flow, a hundred times faster than Hertz' theory allows.
        """
        cautions = super().cautions(pair, penetration, impact_speed)
        if penetration is None and (misfit := self.misfit(pair)):
            cautions += (misfit,)
        limit = PLASTIC * pair.wave_speed
        if impact_speed is None or impact_speed <= limit:
            return cautions
        return (
            *cautions,
            (
                f"impacts of up to {impact_speed:.3g} m/s are faster than 1e-3 sqrt(E/rho) = {limit:.3g} m/s,"
                " above which metals yield all around the contact and keep a dent: an elastic force is then"
                " too large and too short"
            ),
        )

    def misfit(self, pair: Pair) -> str:
        """By how much a given K differs from 4 E*/3 sqrt(R), more than a thousandfold, and the unit that it
        may have.
        """
        if self.stiffness is None:
            return ""
        ratio = self.stiffness / pair.hertz_stiffness
        if 1.0 / MISFIT <= ratio <= MISFIT:
            return ""
        factor = float(f"{max(ratio, 1.0 / ratio):.2g}")
        times = f"{factor:,.0f} times {'larger' if ratio > 1.0 else 'smaller'} than"
        text = (
            f"the stiffness given, {self.stiffness:.4g} N/m^1.5, is {times} the"
            f" {pair.hertz_stiffness:.3g} N/m^1.5 of its materials and radii"
        )
        converted = MILLIMETRES * self.stiffness
        if ratio < 1.0 and converted / pair.hertz_stiffness > 1.0 / MISFIT:
            return (
                f"{text}: is it in N/mm^1.5? {self.stiffness:.4g} N/mm^1.5 are {converted:.4g} N/m^1.5;"
                " without a stiffness, that of materials and radii is taken"
            )
        return f"{text}: check its unit, or leave it out for that of materials and radii"

    def usual(self, pair: Pair) -> tuple[float, float]:
        """From the 1e-5 sqrt(E/rho) of Hertz' quasi-static theory, 5 cm/s for steel, to the 1e-3 sqrt(E/rho)
        from which metals flow in full.
        """
        return QUASI_STATIC * pair.wave_speed, PLASTIC * pair.wave_speed


@dataclass(frozen=True, kw_only=True)
class Cylinder(Damped):
    """Two cylinders, with a damping factor to choose."""

    damping: str = quantity(
        "1", "damping factor: the name of its law, or none", "lankarani-nikravesh", choices=DAMPING
    )


@dataclass(frozen=True, kw_only=True)
class PowerLaw(Cylinder):
    """F_N = K delta^n [1 + chi rate/impact_speed]."""

    slots = ("stiffness", "exponent_beyond_1", "damping_factor")

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, exponent_beyond_1, damping_factor = p
        elastic = stiffness * penetration * power(penetration, exponent_beyond_1)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """K delta^(n + 1)/(n + 1) (J)."""
        return p[0] * elementwise.power(penetration, p[1] + 2.0) / (p[1] + 2.0)


@dataclass(frozen=True, kw_only=True)
class LineContact(Cylinder):
    """F_N = F_e(delta) [1 + chi rate/impact_speed], delta = alpha F_e ln(beta/F_e)."""

    slots = ("compliance", "scale", "last_penetration", "tangent", "damping_factor")

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N) of the relation for the surfaces ``pair``. Raises ValueError for
        surfaces outside its range.
        """
        raise NotImplementedError

    def finite_difference(self, pair: Pair) -> float:
        """Return dR (m) of the two rounds ``pair``. Raises ValueError for a cylinder on a plane."""
        if math.isinf(pair.radius_difference):
            raise ValueError(
                f'the law "{self.name}" needs two finite radii: a cylinder on a plane sinks without limit in'
                " plane strain"
            )
        return pair.radius_difference

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """alpha (m/N), 1/(alpha beta) (1/m), penetration from which the tangent is followed (m), its slope
        (N/m), damping factor (1).
        """
        alpha, beta = self.relation(pair)
        return (
            alpha,
            1.0 / (alpha * beta),
            alpha * beta * LAST * exp(-LAST),
            1.0 / (alpha * (LAST - 1.0)),
            self.damping_factor,
        )

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        alpha, scale, last, tangent, damping_factor = p
        on_tangent = penetration > last
        depth = last if on_tangent else penetration
        numerator, denominator = logarithmic(-log(depth * scale))
        elastic = depth * denominator / (alpha * numerator) + tangent * (penetration - depth)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """alpha F^2 (w/2 - 1/4) (J), which is F delta minus the integral of alpha F ln(beta/F); the tangent's
        share beyond.
        """
        force = np.vectorize(lambda depth: self.force(float(depth), 0.0, p)[0], otypes=[float])
        depth = np.minimum(penetration, p[2])
        excess, force_at_depth = np.asarray(penetration) - depth, force(depth)
        stored = (
            0.5 * force_at_depth * depth
            - 0.25 * p[0] * (force_at_depth * force_at_depth)
            + (force_at_depth + 0.5 * p[3] * excess) * excess
        )
        return stored if np.ndim(penetration) else float(stored)

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Beside the restitution: penetrations beyond which the relation has no force."""
        cautions = super().cautions(pair, penetration, impact_speed)
        alpha, beta = self.relation(pair)
        fold = alpha * beta / math.e
        if penetration is None or penetration <= LAST * exp(1.0 - LAST) * fold:
            return cautions
        share = f"{fold / pair.radius_difference:.4f} dR" if not pair.external else "its largest penetration"
        return (
            *cautions,
            (
                f"a penetration of {1e6 * penetration:.4g} µm reaches {share} = {1e6 * fold:.4g} µm, beyond"
                " which the relation has no force; from 0.9953 of it on, the force follows its tangent"
            ),
        )
