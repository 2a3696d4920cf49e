"""IMPACT: the contact force of Adams and its relatives, with damping that grows with the penetration."""

from dataclasses import dataclass
from typing import Any

from ...kernels.elementary import power
from ...numerics import elementwise
from ..law import ContactLaw, Pair, quantity


@dataclass(frozen=True, kw_only=True)
class Impact(ContactLaw):
    """F_N = k delta^e + STEP(delta, 0, 0, d, c) rate, cut where it would pull.

    STEP rises by a cubic from 0 at delta = 0 to the full damping c at delta = d: c x^2 (3 - 2 x), x =
    delta/d.
    """

    name = "impact"
    source = "MSC Software: Adams/Solver help, IMPACT and STEP functions (2022)"
    formula = "F = k d^e + c x^2 (3 - 2 x) d', x = min(d/depth, 1)"
    slots = ("stiffness", "exponent_beyond_1", "damping_coefficient", "inverse_full_damping_depth")

    stiffness: float = quantity("N/m^e", "stiffness k; from N/mm^e multiply by 10^(3 e)", above=0.0)
    exponent: float = quantity("1", "force exponent e", low=1.0, high=3.0)
    damping_coefficient: float = quantity("N s/m", "full damping c", low=0.0)
    full_damping_depth: float = quantity("m", "penetration d from which the damping is full", above=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """k (N/m^e), e - 1 (1), c (N s/m) and 1/d (1/m)."""
        return self.stiffness, self.exponent - 1.0, self.damping_coefficient, 1.0 / self.full_damping_depth

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, exponent_beyond_1, damping, inverse_depth = p
        x = penetration * inverse_depth
        x = 1.0 if x > 1.0 else x
        return stiffness * penetration * power(penetration, exponent_beyond_1), damping * (
            x * x * (3.0 - 2.0 * x)
        )

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """k delta^(e + 1)/(e + 1) (J)."""
        return p[0] * elementwise.power(penetration, p[1] + 2.0) / (p[1] + 2.0)
