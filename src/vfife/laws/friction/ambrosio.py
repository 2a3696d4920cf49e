"""Ambrosio 2003: Coulomb friction with a ramp between two speeds (the VFIFE paper's modified Coulomb law, Eq.
32-33).
"""

from collections.abc import Iterator
from dataclasses import dataclass

from ...errors import Fault
from ..law import FrictionLaw, Pair, quantity


@dataclass(frozen=True, kw_only=True)
class Ambrosio(FrictionLaw):
    """F_T = -c_f c_d F_N sign(v_T), c_d = 0 below v_0, (|v_T| - v_0)/(v_1 - v_0) to v_1, 1 beyond."""

    name = "ambrosio"
    source = (
        "Ambrosio: Impact of rigid and flexible multibody systems: deformation description and contact"
        " models. In: Virtual Nonlinear Multibody Systems, NATO Science Series 103 (2003) 57-81"
    )
    formula = "F = -f c_d N sign(v), c_d a ramp from 0 at v0 to 1 at v1"
    common = True
    slots = ("coefficient", "v0", "ramp")

    coefficient: float = quantity("1", "friction coefficient c_f", 0.1, low=0.0)
    v0: float = quantity("m/s", "speed below which there is no friction", 1e-4, low=0.0)
    v1: float = quantity("m/s", "speed above which friction is full", 1e-2, low=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where the ramp does not rise."""
        if self.v1 <= self.v0:
            yield Fault(
                "v1",
                "friction would have no ramp between v0 and v1",
                f"{self.v1:g}",
                f"above v0 = {self.v0:g} m/s",
                "raise v1 or lower v0",
            )

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Coefficient (1), v_0 and v_1 - v_0 (m/s)."""
        return self.coefficient, self.v0, self.v1 - self.v0

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: float,
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, float]:
        """Friction force (N), solved with the velocity it causes.

        On the ramp |v| = free - m limit c_d and c_d = (|v| - v_0)/(v_1 - v_0) give c_d = (free - v_0)/(v_1 -
        v_0 + m limit); beyond either end the same quotient lies below 0 or above 1.
        """
        coefficient, v0, ramp = p
        limit = coefficient * normal_force
        share = (abs(free_velocity) - v0) / (ramp + mobility * limit)
        share = 0.0 if share < 0.0 else share
        share = 1.0 if share > 1.0 else share
        force = limit * share
        return -force if free_velocity > 0.0 else force, memory

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 on the ramps and the flat between them, 1 or -1 with full friction.

        sliding_velocity: in m/s
        p: the parameters of the law
        """
        full = abs(sliding_velocity) > p[1] + p[2]
        return (1.0 if sliding_velocity > 0.0 else -1.0) if full else 0.0
