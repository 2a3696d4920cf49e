"""Contact along the line of two cylinders, F_e = K delta^n with any hysteresis damping, for laws that are a
power of the penetration.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

from ...kernels.elementary import power
from ..law import Pair, quantity
from .damping import DAMPING, Damped

OVERVIEW = (
    "Pereira, Ramalho, Ambrosio: A critical overview of internal and external cylinder contact force models."
    " Nonlinear Dynamics 63 (2011) 681-697"
)


@dataclass(frozen=True, kw_only=True)
class Cylinder(Damped):
    """Two cylinders, with a damping factor to choose."""

    damping: str = quantity(
        "1", "damping factor: the name of its law, or none", "lankarani-nikravesh", choices=DAMPING
    )

    def inside(self, pair: Pair) -> None:
        """Raise ValueError if the surfaces ``pair`` are two cylinders side by side, for laws without such a
        form.
        """
        if pair.external:
            raise ValueError(
                f'the law "{self.name}" is for a journal inside a bearing; for two rounds side by side take'
                ' "pereira" or "johnson"'
            )


@dataclass(frozen=True, kw_only=True)
class PowerLaw(Cylinder):
    """F_N = K delta^n [1 + chi rate/impact_speed]."""

    slots: ClassVar[tuple[str, ...]] = ("stiffness", "exponent_beyond_1", "damping_factor")

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, exponent_beyond_1, damping_factor = p
        elastic = stiffness * penetration * power(penetration, exponent_beyond_1)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """K delta^(n + 1)/(n + 1) (J)."""
        from ...numerics.elementwise import power as power_of

        return p[0] * power_of(penetration, p[1] + 2.0) / (p[1] + 2.0)
