"""Karnopp 1985: stick within a small band of velocities, static friction to leave it."""

from dataclasses import dataclass

from ..law import Pair, quantity
from .forms import StaticFriction, regime_of_sticking


@dataclass(frozen=True, kw_only=True)
class Karnopp(StaticFriction):
    """F_T = -mu_c F_N sign(v_T) for |v_T| > D_v; inside the band the surfaces count as at rest and any force
    up to mu_s F_N holds them.

    The source takes the velocity for zero inside the band and lets friction cancel what else acts there. Here
    the force is the one that makes it zero: whatever would be left in the band by kinetic friction is
    stopped, with no more than mu_s F_N.
    """

    name = "karnopp"
    source = (
        "Karnopp: Computer simulation of stick-slip friction in mechanical dynamic systems. "
        "Journal of Dynamic Systems, Measurement, and Control 107 (1985) 100-103"
    )
    formula = "F = -mu_c N sign(v) for |v| > Dv; |F| <= mu_s N to stop within"
    slots = ("coefficient", "static_coefficient", "band")
    set_valued = True
    regime = staticmethod(regime_of_sticking)

    band: float = quantity("m/s", "speed D_v up to which the surfaces count as at rest", 1e-3, low=0.0)

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
