"""Bengisu and Akay 1994: a parabola up to static friction, an exponential down to kinetic friction."""

from dataclasses import dataclass

from ...kernels.elementary import approach
from ..law import Pair, quantity
from .forms import StaticFriction, force_on_tangent, foreseen, regime_of_peak


@dataclass(frozen=True, kw_only=True)
class BengisuAkay(StaticFriction):
    """F_T = -F_N mu_s [1 - (|v|/v_0 - 1)^2] sign(v) up to |v| = v_0, -F_N {mu_c + (mu_s - mu_c) exp[-xi (|v|
    - v_0)]} sign(v) beyond.

    Taken from the account of Marques et al. (2016), not from the original: F_S - F_S/v_0^2 (|v| - v_0)^2 and
    F_C + (F_S - F_C) exp[...].

    Solved along the tangent at the speed that the last two steps foresee, the falling part at that speed:
    second order in the step.
    """

    name = "bengisu-akay"
    source = (
        "Bengisu, Akay: Stability of friction-induced vibrations in multi-degree-of-freedom systems. Journal"
        " of Sound and Vibration 171 (1994) 557-570; as given in Marques, Flores, Claro, Lankarani: A survey"
        " and comparison of several friction force models for dynamic analysis of multibody mechanical"
        " systems. Nonlinear Dynamics 86 (2016) 1407-1443"
    )
    formula = (
        "F = -N mu_s (1 - (|v|/v0 - 1)^2) sign(v), from v0 on -N (mu_c + (mu_s - mu_c) exp(-xi (|v| - v0)))"
        " sign(v)"
    )
    slots = ("static_coefficient", "excess", "inverse_speed", "decay")
    memory = ("sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")
    regime = staticmethod(regime_of_peak)

    v0: float = quantity("m/s", "speed of the peak", 1e-3, above=0.0)
    decay: float = quantity("s/m", "rate xi of the fall from static to kinetic friction", 1e3, low=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_s and mu_s - mu_c (1), 1/v_0 (s/m), xi v_0 (1)."""
        return (
            self.static_coefficient,
            self.static_coefficient - self.coefficient,
            1.0 / self.v0,
            self.decay * self.v0,
        )

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
        static, excess, inverse_speed, decay = p
        last, earlier = memory
        unit = mobility * normal_force
        speed = foreseen(free_velocity, unit * static, last, earlier)
        excess_ratio = speed * inverse_speed - 1.0
        rises = excess_ratio < 0.0
        past = decay * excess_ratio
        past = past if past > 0.0 else 0.0
        share = static * (1.0 - excess_ratio * excess_ratio) if rises else static - excess * approach(past)
        slope = -2.0 * static * inverse_speed * excess_ratio if rises else 0.0
        force = normal_force * force_on_tangent(free_velocity, unit, speed, share, slope, static)
        force = -force if free_velocity > 0.0 else force
        return force, (free_velocity + mobility * force, last)
