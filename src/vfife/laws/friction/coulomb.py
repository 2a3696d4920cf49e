"""Coulomb 1785: set-valued dry friction, without any regularisation."""

from dataclasses import dataclass

from ..law import FrictionLaw, Pair, quantity
from .forms import regime_of_sticking


@dataclass(frozen=True, kw_only=True)
class Coulomb(FrictionLaw):
    """F_T = -mu F_N sign(v_T) while the surfaces slide; any force up to mu F_N that keeps them from it while
    they stick.
    """

    name = "coulomb"
    source = (
        "Coulomb: Theorie des machines simples. Memoires de Mathematique et de Physique de l'Academie des"
        " Sciences 10 (1785) 161-331"
    )
    formula = "F = -mu N sign(v), |F| <= mu N where v = 0"
    slots = ("coefficient",)
    set_valued = True
    regime = staticmethod(regime_of_sticking)

    coefficient: float = quantity("1", "friction coefficient mu", 0.1, low=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Coefficient (1)."""
        return (self.coefficient,)

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: float,
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, float]:
        """Friction force (N): the one that stops the sliding, -free_velocity/mobility, cut at the limit."""
        limit = p[0] * normal_force
        force = abs(free_velocity) / (
            abs(mobility) + 1e-300
        )  # nothing to stop and nothing to move is no force; what is driven rounds below 0
        force = limit if force > limit else force
        return -force if free_velocity > 0.0 else force, memory
