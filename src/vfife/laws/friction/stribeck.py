"""Stribeck 1902, as Bo and Pavelescu 1982 write it: friction that falls from its static to its kinetic value
as sliding begins.
"""

from dataclasses import dataclass

from ...kernels.elementary import approach, power
from ..law import Pair, quantity
from .forms import StaticFriction, regime_of_sticking


@dataclass(frozen=True, kw_only=True)
class Stribeck(StaticFriction):
    """F_T = -F_N {[mu_c + (mu_s - mu_c) exp(-|v/v_S|^d)] sign(v) + sigma_v v}, and any force up to mu_s F_N
    that keeps the surfaces at rest.

    Viscous friction is given per unit of normal force (s/m), so that it goes with it. A curve that falls with
    the velocity has several solutions within one step once (mu_s - mu_c) F_N mobility > 1.17 v_S (d = 2). The
    falling part is therefore taken at the speed at t_n that the last two half-step velocities extrapolate to
    (second order); sign and viscous part are solved with the velocity that they cause. What stopped or turned
    round in the step before has static friction.
    """

    name = "stribeck"
    source = (
        "Stribeck: Die wesentlichen Eigenschaften der Gleit- und Rollenlager. Zeitschrift des Vereines"
        " deutscher Ingenieure 46 (1902); exponential form: Bo, Pavelescu: The friction-speed relation and"
        " its influence on the critical velocity of stick-slip motion. Wear 82 (1982) 277-289"
    )
    formula = "F = -N ([mu_c + (mu_s - mu_c) exp(-|v/vS|^d)] sign(v) + sv v), |F| <= mu_s N where v = 0"
    slots = ("coefficient", "excess", "inverse_speed", "shape", "viscous")
    memory = ("sliding velocity at n - 1/2 (m/s)", "sliding velocity at n - 3/2 (m/s)")
    set_valued = True
    regime = staticmethod(regime_of_sticking)

    stribeck_speed: float = quantity("m/s", "Stribeck speed v_S", 1e-3, above=0.0)
    shape: float = quantity("1", "exponent d of the Stribeck curve", 2.0, low=0.1, high=4.0)
    viscous: float = quantity("s/m", "viscous friction per unit of normal force", 0.0, low=0.0)

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
        last, earlier = memory
        half = 0.5 * viscous * normal_force
        left = free_velocity - mobility * half * last
        sign = 1.0 if left > 0.0 else -1.0
        ratio = sign * (1.5 * last - 0.5 * earlier) * inverse_speed if sign * last > 0.0 else 0.0
        ratio = 1e6 if ratio > 1e6 else ratio
        ratio = 0.0 if ratio < 0.0 else ratio
        share = coefficient + excess * (1.0 - approach(power(ratio, shape)))
        limit = share * normal_force
        reach = abs(left) - mobility * limit
        speed = reach / (1.0 + mobility * half)
        speed = -speed if left < 0.0 else speed
        slides = reach > 0.0
        rubbing = limit if left > 0.0 else -limit
        holding = free_velocity / (abs(mobility) + 1e-300)
        force = rubbing + half * (last + speed) if slides else holding
        return -force, (speed if slides else 0.0, last)
