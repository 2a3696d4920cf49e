"""Contact along the line of two cylinders, delta = alpha F ln(beta/F): the classical laws, which are implicit
in the force.

With w = ln(beta/F) the relation reads w exp(-w) = delta/(alpha beta), so F = delta/(alpha w), where w - ln w
= ln(alpha beta/delta): one function of one number serves all of them, without an iteration in the step. The
relation has a largest penetration, alpha beta/e at w = 1, where the stiffness becomes infinite; from w = 1.1
on, at 0.9953 of it, the force goes on along its tangent, 1/[alpha (w - 1)] = 10/alpha.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ...kernels.elementary import log, logarithmic
from ...numerics.scalar import exp
from ..law import Pair
from .cylinder import Cylinder

LAST = 1.1  # w at which the tangent begins


@dataclass(frozen=True, kw_only=True)
class LineContact(Cylinder):
    """F_N = F_e(delta) [1 + chi rate/impact_speed], delta = alpha F_e ln(beta/F_e)."""

    slots: ClassVar[tuple[str, ...]] = (
        "compliance",
        "scale",
        "last_penetration",
        "tangent",
        "damping_factor",
    )

    def relation(self, pair: Pair) -> tuple[float, float]:
        """Return alpha (m/N) and beta (N) of the relation for the surfaces ``pair``. Raises ValueError for
        surfaces outside its range.
        """
        raise NotImplementedError

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """alpha (m/N), 1/(alpha beta) (1/m), penetration from which the tangent is followed (m), its slope
        (N/m), damping factor (1).
        """
        alpha, beta = self.relation(pair)
        return (
            alpha,
            1.0 / (alpha * beta),
            alpha * beta * LAST * exp(-LAST),
            1.0 / (alpha * (LAST - 1.0)),
            self.damping_factor,
        )

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        alpha, scale, last, tangent, damping_factor = p
        beyond = penetration > last
        depth = last if beyond else penetration
        high, below = logarithmic(-log(depth * scale))
        elastic = depth * below / (alpha * high) + tangent * (penetration - depth)
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """alpha F^2 (w/2 - 1/4) (J), which is F delta minus the integral of alpha F ln(beta/F); the tangent's
        share beyond.
        """
        import numpy as np

        force = np.vectorize(lambda depth: self.force(float(depth), 0.0, p)[0], otypes=[float])
        depth = np.minimum(penetration, p[2])
        beyond, held = np.asarray(penetration) - depth, force(depth)
        stored = 0.5 * held * depth - 0.25 * p[0] * (held * held) + (held + 0.5 * p[3] * beyond) * beyond
        return stored if np.ndim(penetration) else float(stored)

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Beside the restitution: penetrations beyond which the relation has no force."""
        cautions = super().cautions(pair, penetration, impact_speed)
        alpha, beta = self.relation(pair)
        fold = alpha * beta / math.e
        if penetration is None or penetration <= LAST * exp(1.0 - LAST) * fold:
            return cautions
        share = f"{fold / pair.radius_difference:.4f} dR" if not pair.external else "its largest penetration"
        return (
            *cautions,
            (
                f"a penetration of {1e6 * penetration:.4g} µm reaches {share} = {1e6 * fold:.4g} µm, beyond"
                " which the relation has no force; from 0.9953 of it on, the force follows its tangent"
            ),
        )
