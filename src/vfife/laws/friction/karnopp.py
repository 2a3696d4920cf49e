"""Karnopp 1985: stick within a small band of velocities, static friction to leave it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...errors import Fault
from ..law import FrictionLaw, Pair, quantity
from .order import not_below


@dataclass(frozen=True, kw_only=True)
class Karnopp(FrictionLaw):
    """F_T = -mu_c F_N sign(v_T) for |v_T| > D_v; inside the band the surfaces count as at rest and any force
    up to mu_s F_N holds them.

    The source takes the velocity for zero inside the band and lets friction cancel what else acts there. Here
    the force is the one that makes it zero: whatever would be left in the band by kinetic friction is
    stopped, with no more than mu_s F_N.
    """

    name: ClassVar[str] = "karnopp"
    source: ClassVar[str] = (
        "Karnopp: Computer simulation of stick-slip friction in mechanical dynamic systems. "
        "Journal of Dynamic Systems, Measurement, and Control 107 (1985) 100-103"
    )
    formula: ClassVar[str] = "F = -mu_c N sign(v) for |v| > Dv; |F| <= mu_s N to stop within"
    slots: ClassVar[tuple[str, ...]] = ("coefficient", "static_coefficient", "band")
    set_valued: ClassVar[bool] = True

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s", 0.15, low=0.0)
    band: float = quantity("m/s", "speed D_v up to which the surfaces count as at rest", 1e-3, low=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where static friction is weaker than kinetic friction."""
        return not_below(self.static_coefficient, self.coefficient)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Coefficients (1) and D_v (m/s)."""
        return self.coefficient, self.static_coefficient, self.band

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: float,
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, float]:
        """Friction force (N)."""
        coefficient, static_coefficient, band = p
        kinetic = coefficient * normal_force
        static = static_coefficient * normal_force
        speed = abs(free_velocity)
        force = speed / (abs(mobility) + 1e-300)
        force = static if force > static else force
        force = kinetic if speed - mobility * kinetic > band else force
        return -force if free_velocity > 0.0 else force, memory

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 for sticking, 1 or -1 for sliding.

        sliding_velocity: in m/s, 0 for sticking
        p: the parameters of the law
        """
        return 1.0 if sliding_velocity > 0.0 else -1.0 if sliding_velocity < 0.0 else 0.0
