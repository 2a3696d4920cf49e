"""No friction."""

from dataclasses import dataclass

from ..law import FrictionLaw, Pair


@dataclass(frozen=True, kw_only=True)
class Frictionless(FrictionLaw):
    """F_T = 0."""

    name = "none"
    source = "definition"
    formula = "F = 0"
    common = True

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Nothing."""
        return ()

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: float,
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, float]:
        """Zero; the memory stays as it is."""
        return 0.0, memory
