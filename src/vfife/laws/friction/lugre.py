"""LuGre, Canudas de Wit, Olsson, Astrom and Lischinsky 1995: bristles with damping and a Stribeck curve."""

from dataclasses import dataclass

from ...kernels.elementary import approach
from ..law import Pair, quantity
from .forms import StaticFriction, bend, regime_of_bristles


@dataclass(frozen=True, kw_only=True)
class LuGre(StaticFriction):
    """dz/dt = v - sigma_0 |v| z/g, g = mu_c + (mu_s - mu_c) exp(-(v/v_S)^2), F_T = -F_N (sigma_0 z + sigma_1
    dz/dt + sigma_2 v).

    All per unit of normal force, as for tyres (Canudas de Wit and Tsiotras 1999): sigma_0 in 1/m, sigma_1 and
    sigma_2 in s/m. So the bristles' deflection in steady sliding, g/sigma_0, is a property of the surfaces
    and stays when the normal force changes. The defaults are Table 1 of the source (F_C = 1 N, F_S = 1.5 N,
    1e5 N/m, sqrt(1e5) and 0.4 N s/m) at the normal force of 10 N that makes F_C a coefficient of 0.1.

    g is taken at the speed that the last two sliding velocities extrapolate to in the middle of the step:
    second order, and no second solution where g falls steeply.
    """

    name = "lugre"
    source = (
        "Canudas de Wit, Olsson, Astrom, Lischinsky: A new model for control of systems with friction. IEEE"
        " Transactions on Automatic Control 40 (1995) 419-425; per unit of normal force: Canudas de Wit,"
        " Tsiotras: Dynamic tire friction models for vehicle traction control. 38th IEEE Conference on"
        " Decision and Control (1999) 3746-3751"
    )
    formula = "F = -N (s0 z + s1 z' + s2 v), z' = v - s0 |v| z/g, g = mu_c + (mu_s - mu_c) exp(-(v/vS)^2)"
    slots = (
        "coefficient",
        "excess",
        "inverse_speed",
        "compliance",
        "bristle_stiffness",
        "bristle_damping",
        "viscous",
    )
    memory = ("bristle deflection (m)", "sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")
    regime = staticmethod(regime_of_bristles)

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, above=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s", 0.15, above=0.0)
    stribeck_speed: float = quantity("m/s", "Stribeck speed v_S", 1e-3, above=0.0)
    bristle_stiffness: float = quantity(
        "1/m", "stiffness sigma_0 of the bristles per unit of normal force", 1e4, above=0.0
    )
    bristle_damping: float = quantity(
        "s/m", "damping sigma_1 of the bristles per unit of normal force", 31.6, low=0.0
    )
    viscous: float = quantity("s/m", "viscous friction sigma_2 per unit of normal force", 0.04, low=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c and mu_s - mu_c (1), 1/v_S (s/m), 1/sigma_0 (m), sigma_0 (1/m), sigma_1 and sigma_2 (s/m)."""
        excess = self.static_coefficient - self.coefficient
        bristles = (1.0 / self.bristle_stiffness, self.bristle_stiffness, self.bristle_damping, self.viscous)
        return self.coefficient, excess, 1.0 / self.stribeck_speed, *bristles

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: tuple[float, float, float],
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, tuple[float, float, float]]:
        """Friction force (N), deflection (m) and the last two sliding velocities (m/s)."""
        coefficient, excess, inverse_speed, compliance, stiffness, damping, viscous = p
        ratio = (1.5 * memory[1] - 0.5 * memory[2]) * inverse_speed
        capacity = coefficient + excess * (1.0 - approach(ratio * ratio))
        return bend(
            normal_force,
            free_velocity,
            mobility,
            memory,
            dt,
            capacity * compliance,
            stiffness / capacity,
            stiffness,
            damping,
            viscous,
        )
