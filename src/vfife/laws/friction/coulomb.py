"""Coulomb 1785: set-valued dry friction, without any regularisation."""

from dataclasses import dataclass
from typing import ClassVar

from ..law import FrictionLaw, Pair, quantity


@dataclass(frozen=True, kw_only=True)
class Coulomb(FrictionLaw):
    """F_T = -mu F_N sign(v_T) while the surfaces slide; any force up to mu F_N that keeps them from it while
    they stick.
    """

    name: ClassVar[str] = "coulomb"
    source: ClassVar[str] = (
        "Coulomb: Theorie des machines simples. Memoires de Mathematique et de Physique de l'Academie des"
        " Sciences 10 (1785) 161-331"
    )
    formula: ClassVar[str] = "F = -mu N sign(v), |F| <= mu N where v = 0"
    slots: ClassVar[tuple[str, ...]] = ("coefficient",)
    set_valued: ClassVar[bool] = True

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

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 for sticking, 1 or -1 for sliding.

        sliding_velocity: in m/s, 0 for sticking
        p: the parameters of the law
        """
        return 1.0 if sliding_velocity > 0.0 else -1.0 if sliding_velocity < 0.0 else 0.0
