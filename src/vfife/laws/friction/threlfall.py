"""Threlfall 1978: Coulomb friction with an exponential rise up to a speed."""

from dataclasses import dataclass

from ...kernels.elementary import approach
from ...numerics.scalar import expm1
from ..law import FrictionLaw, Pair, quantity
from .forms import force_on_tangent, foreseen, regime_of_peak


@dataclass(frozen=True, kw_only=True)
class Threlfall(FrictionLaw):
    """F_T = -mu F_N (1 - exp(-3 |v|/v_1))/(1 - e^-3) sign(v) up to |v| = v_1, -mu F_N sign(v) beyond.

    Taken from the account of Marques et al. (2016), not from the original. It prints 0.95 for 1 - e^-3 =
    0.9502, which leaves a jump of 0.02 % at v_1; the exact number leaves none.

    Solved along the tangent at the speed that the last two steps foresee: second order in the step.
    """

    name = "threlfall"
    source = (
        "Threlfall: The inclusion of Coulomb friction in mechanisms programs with particular reference to"
        " DRAM. Mechanism and Machine Theory 13 (1978) 475-483; as given in Marques, Flores, Claro,"
        " Lankarani: A survey and comparison of several friction force models for dynamic analysis of"
        " multibody mechanical systems. Nonlinear Dynamics 86 (2016) 1407-1443"
    )
    formula = "F = -mu N (1 - exp(-3 |v|/v1))/(1 - exp(-3)) sign(v), full from v1 on"
    slots = ("coefficient", "scale", "inverse_speed")
    memory = ("sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")
    regime = staticmethod(regime_of_peak)

    coefficient: float = quantity("1", "friction coefficient mu", 0.1, low=0.0)
    v1: float = quantity("m/s", "speed above which friction is full", 1e-2, above=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu and mu/(1 - e^-3) (1), 1/v_1 (s/m)."""
        return self.coefficient, self.coefficient / -expm1(-3.0), 1.0 / self.v1

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: tuple[float, float],
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, tuple[float, float]]:
        """Friction force (N) and the last two sliding velocities (m/s)."""
        coefficient, scale, inverse_speed = p
        last, earlier = memory
        unit = mobility * normal_force
        speed = foreseen(free_velocity, unit * coefficient, last, earlier)
        rises = speed * inverse_speed < 1.0
        share = scale * approach(3.0 * speed * inverse_speed)
        slope = 3.0 * inverse_speed * (scale - share) if rises else 0.0
        force = normal_force * force_on_tangent(
            free_velocity, unit, speed, share if rises else coefficient, slope, coefficient
        )
        force = -force if free_velocity > 0.0 else force
        return force, (free_velocity + mobility * force, last)
