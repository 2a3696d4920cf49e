"""Stribeck 1902, as Bo and Pavelescu 1982 write it: friction that falls from its static to its kinetic value
as sliding begins.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...errors import Fault
from ...kernels.elementary import approach, power
from ..law import FrictionLaw, Pair, quantity
from .order import not_below


@dataclass(frozen=True, kw_only=True)
class Stribeck(FrictionLaw):
    """F_T = -F_N {[mu_c + (mu_s - mu_c) exp(-|v/v_S|^d)] sign(v) + sigma_v v}, and any force up to mu_s F_N
    that keeps the surfaces at rest.

    Viscous friction is given per unit of normal force (s/m), so that it goes with it. A curve that falls with
    the velocity has several solutions within one step once (mu_s - mu_c) F_N mobility > 1.17 v_S (d = 2). The
    falling part is therefore taken at the speed at t_n that the last two half-step velocities extrapolate to
    (second order); sign and viscous part are solved with the velocity that they cause.
    """

    name: ClassVar[str] = "stribeck"
    source: ClassVar[str] = (
        "Stribeck: Die wesentlichen Eigenschaften der Gleit- und Rollenlager. Zeitschrift des Vereines"
        " deutscher Ingenieure 46 (1902); exponential form: Bo, Pavelescu: The friction-speed relation and"
        " its influence on the critical velocity of stick-slip motion. Wear 82 (1982) 277-289"
    )
    formula: ClassVar[str] = (
        "F = -N ([mu_c + (mu_s - mu_c) exp(-|v/vS|^d)] sign(v) + sv v), |F| <= mu_s N where v = 0"
    )
    slots: ClassVar[tuple[str, ...]] = ("coefficient", "excess", "inverse_speed", "shape", "viscous")
    memory: ClassVar[tuple[str, ...]] = (
        "sliding velocity at n - 1/2 (m/s)",
        "sliding velocity at n - 3/2 (m/s)",
    )
    set_valued: ClassVar[bool] = True

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s", 0.15, low=0.0)
    stribeck_speed: float = quantity("m/s", "Stribeck speed v_S", 1e-3, above=0.0)
    shape: float = quantity("1", "exponent d of the Stribeck curve", 2.0, low=0.1, high=4.0)
    viscous: float = quantity("s/m", "viscous friction per unit of normal force", 0.0, low=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where static friction is weaker than kinetic friction."""
        return not_below(self.static_coefficient, self.coefficient)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c and mu_s - mu_c (1), 1/v_S (s/m), d (1), sigma_v (s/m)."""
        return (
            self.coefficient,
            self.static_coefficient - self.coefficient,
            1.0 / self.stribeck_speed,
            self.shape,
            self.viscous,
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
        coefficient, excess, inverse_speed, shape, viscous = p
        last, before = memory
        ratio = abs(1.5 * last - 0.5 * before) * inverse_speed
        ratio = 1e6 if ratio > 1e6 else ratio
        share = coefficient + excess * (1.0 - approach(power(ratio, shape)))
        half = 0.5 * viscous * normal_force
        left = free_velocity - mobility * half * last
        limit = share * normal_force
        reach = abs(left) - mobility * limit
        speed = reach / (1.0 + mobility * half)
        speed = -speed if left < 0.0 else speed
        slides = reach > 0.0
        rubbing = limit if left > 0.0 else -limit
        holding = free_velocity / (abs(mobility) + 1e-300)
        force = rubbing + half * (last + speed) if slides else holding
        return -force, (speed if slides else 0.0, last)

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 for sticking, 1 or -1 for sliding.

        sliding_velocity: in m/s, 0 for sticking
        p: the parameters of the law
        """
        return 1.0 if sliding_velocity > 0.0 else -1.0 if sliding_velocity < 0.0 else 0.0
