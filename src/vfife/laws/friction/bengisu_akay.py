"""Bengisu and Akay 1994: a parabola up to static friction, an exponential down to kinetic friction."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...errors import Fault
from ...kernels.elementary import approach
from ..law import FrictionLaw, Pair, quantity
from .order import not_below
from .tangent import force_on_tangent, foreseen


@dataclass(frozen=True, kw_only=True)
class BengisuAkay(FrictionLaw):
    """F_T = -F_N mu_s [1 - (|v|/v_0 - 1)^2] sign(v) up to |v| = v_0, -F_N {mu_c + (mu_s - mu_c) exp[-xi (|v|
    - v_0)]} sign(v) beyond.

    Taken from the account of Marques et al. (2016), not from the original: F_S - F_S/v_0^2 (|v| - v_0)^2 and
    F_C + (F_S - F_C) exp[...].

    Solved along the tangent at the speed that the last two steps foresee, the falling part at that speed:
    second order in the step.
    """

    name: ClassVar[str] = "bengisu-akay"
    source: ClassVar[str] = (
        "Bengisu, Akay: Stability of friction-induced vibrations in multi-degree-of-freedom systems. Journal"
        " of Sound and Vibration 171 (1994) 557-570; as given in Marques, Flores, Claro, Lankarani: A survey"
        " and comparison of several friction force models for dynamic analysis of multibody mechanical"
        " systems. Nonlinear Dynamics 86 (2016) 1407-1443"
    )
    formula: ClassVar[str] = (
        "F = -N mu_s (1 - (|v|/v0 - 1)^2) sign(v), from v0 on -N (mu_c + (mu_s - mu_c) exp(-xi (|v| - v0)))"
        " sign(v)"
    )
    slots: ClassVar[tuple[str, ...]] = ("static_coefficient", "excess", "inverse_speed", "decay")
    memory: ClassVar[tuple[str, ...]] = ("sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s", 0.15, low=0.0)
    v0: float = quantity("m/s", "speed of the peak", 1e-3, above=0.0)
    decay: float = quantity("s/m", "rate xi of the fall from static to kinetic friction", 1e3, low=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where static friction is weaker than kinetic friction."""
        return not_below(self.static_coefficient, self.coefficient)

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
        last, before = memory
        unit = mobility * normal_force
        speed = foreseen(free_velocity, unit * static, last, before)
        beyond = speed * inverse_speed - 1.0
        rises = beyond < 0.0
        past = decay * beyond
        past = past if past > 0.0 else 0.0
        share = static * (1.0 - beyond * beyond) if rises else static - excess * approach(past)
        slope = -2.0 * static * inverse_speed * beyond if rises else 0.0
        force = normal_force * force_on_tangent(free_velocity, unit, speed, share, slope, static)
        force = -force if free_velocity > 0.0 else force
        return force, (free_velocity + mobility * force, last)

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 on the rise to the peak, 1 or -1 beyond it.

        sliding_velocity: in m/s
        p: the parameters of the law
        """
        falls = abs(sliding_velocity) * p[2] > 1.0
        return (1.0 if sliding_velocity > 0.0 else -1.0) if falls else 0.0
