"""Dahl 1968: bristles that bend before they slide."""

from dataclasses import dataclass

from ..law import FrictionLaw, Pair, quantity
from .forms import bend, regime_of_bristles


@dataclass(frozen=True, kw_only=True)
class Dahl(FrictionLaw):
    """dz/dt = v - sigma_0 |v| z/mu_c, F_T = -F_N sigma_0 z; sigma_0 in 1/m, the stiffness of the bristles per
    unit of normal force.
    """

    name = "dahl"
    source = (
        "Dahl: A solid friction model. Report TOR-0158(3107-18)-1, The Aerospace Corporation, El Segundo"
        " (1968); solid friction damping of mechanical vibrations. AIAA Journal 14 (1976) 1675-1682"
    )
    formula = "F = -N s0 z, z' = v - s0 |v| z/mu_c"
    slots = ("stretch", "inverse_stretch", "bristle_stiffness")
    memory = ("bristle deflection (m)", "sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")
    regime = staticmethod(regime_of_bristles)

    coefficient: float = quantity("1", "friction coefficient mu_c", 0.1, above=0.0)
    bristle_stiffness: float = quantity(
        "1/m", "stiffness sigma_0 of the bristles per unit of normal force", 1e4, above=0.0
    )

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c/sigma_0 (m), its inverse and sigma_0 (1/m)."""
        return (
            self.coefficient / self.bristle_stiffness,
            self.bristle_stiffness / self.coefficient,
            self.bristle_stiffness,
        )

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
        stretch, inverse, stiffness = p
        return bend(normal_force, free_velocity, mobility, memory, dt, stretch, inverse, stiffness, 0.0, 0.0)
