"""Karnopp 1985: stick within a small band of velocities, static friction to leave it."""

from dataclasses import dataclass

from ..law import Pair, quantity
from .forms import StaticFriction


@dataclass(frozen=True, kw_only=True)
class Karnopp(StaticFriction):
    """F_T = -mu_c F_N sign(v_T) for |v_T| > D_v; inside the band the surfaces count as at rest and any force
    up to mu_s F_N holds them.

    The source takes the velocity for zero inside the band and lets friction cancel what else acts there. Here
    the force is the one that makes it zero. Within one step the law has two solutions where mu_s F_N would
    leave the velocity in the band and mu_c F_N outside it. The last two velocities decide: mu_c F_N resists
    what slid that way beyond the band in both, mu_s F_N the rest. So mu_s F_N of one contact holds for any
    band and step, also where the sliding turns round, and slow sliding meets mu_c F_N. Two, because the
    contacts of a body are solved in turn: a jump of its load passes the first, for a step, until the next
    ones take their share.
    """

    name = "karnopp"
    source = (
        "Karnopp: Computer simulation of stick-slip friction in mechanical dynamic systems. "
        "Journal of Dynamic Systems, Measurement, and Control 107 (1985) 100-103"
    )
    formula = "F = -mu_c N sign(v) for |v| > Dv; |F| <= mu_s N to stop within"
    slots = ("coefficient", "static_coefficient", "band")
    memory = (
        "sliding velocity at n - 1/2, 0 within the band (m/s)",
        "sliding velocity at n - 3/2, 0 within the band (m/s)",
    )
    set_valued = True

    band: float = quantity("m/s", "speed D_v up to which the surfaces count as at rest", 1e-3, low=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Coefficients (1) and D_v (m/s)."""
        return self.coefficient, self.static_coefficient, self.band

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: tuple[float, float],
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, tuple[float, float]]:
        """Friction force (N) and the last two sliding velocities (m/s), 0 within the band."""
        coefficient, static_coefficient, band = p
        kinetic = coefficient * normal_force
        static = static_coefficient * normal_force
        speed = abs(free_velocity)
        last, earlier = memory
        sign = 1.0 if free_velocity > 0.0 else -1.0
        slower = sign * (last if sign * last < sign * earlier else earlier)
        limit = kinetic if slower > band else static
        slides = speed - mobility * limit > band
        force = speed / (abs(mobility) + 1e-300)
        force = static if force > static else force
        force = limit if slides else force
        force = -force if free_velocity > 0.0 else force
        return force, (free_velocity + mobility * force if slides else 0.0, last)

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 within the band, 1 or -1 beyond it.

        sliding_velocity: in m/s, 0 for sticking
        p: the parameters of the law
        """
        slides = abs(sliding_velocity) > p[2]
        return (1.0 if sliding_velocity > 0.0 else -1.0) if slides else 0.0
