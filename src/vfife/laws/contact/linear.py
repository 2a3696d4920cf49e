"""A spring and a damper side by side, for laws that are linear."""

from dataclasses import dataclass
from typing import Any, ClassVar

from ..law import ContactLaw


@dataclass(frozen=True, kw_only=True)
class Linear(ContactLaw):
    """F_N = k delta + c rate while the surfaces touch.

    The force begins with a jump, c times the impact speed, and would pull before they part: it ends where it
    comes down to zero.
    """

    slots: ClassVar[tuple[str, ...]] = ("stiffness", "damping_coefficient")

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, damping = p
        return stiffness * penetration, damping if penetration > 0.0 else 0.0

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """k delta^2/2 (J)."""
        return 0.5 * p[0] * (penetration * penetration)
