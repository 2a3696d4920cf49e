"""Liu, Zhang and Yang 2007: a journal inside a bearing, explicit in the penetration."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ...numerics.quadrature import gauss
from ..law import Pair
from .forms import Cylinder


@dataclass(frozen=True, kw_only=True)
class Liu(Cylinder):
    """F_N = pi/2 delta E* L sqrt{delta/[2 (dR + delta)]} [1 + chi rate/impact_speed], dR = R_i - R_j."""

    name = "liu"
    source = (
        "Liu, Zhang, Yang: The FEM analysis and approximate model for cylindrical joints with clearances. "
        "Mechanism and Machine Theory 42 (2007) 183-197"
    )
    formula = "F = pi/2 d E* L sqrt(d/(2 (dR + d))) (1 + chi d'/d'0)"
    slots = ("stiffness", "clearance", "damping_factor")

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """pi E* L/sqrt(8) (N/m), dR (m) and damping factor (1)."""
        self.require_inside(pair)
        return (
            math.pi / math.sqrt(8.0) * pair.composite_modulus * pair.axial_length,
            pair.clearance,
            self.damping_factor,
        )

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m)."""
        stiffness, clearance, damping_factor = p
        elastic = stiffness * penetration * math.sqrt(penetration / (clearance + penetration))
        return elastic, elastic * damping_factor * slowness

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """K times the integral of sqrt(x^3/(dR + x)) (J): by Gauss' rule of 20 nodes in the root of x, exact
        to rounding.
        """
        nodes, weights = _rule()
        depth = np.asarray(penetration, dtype=float)[..., None]
        u = 0.5 * (1.0 + nodes)
        stored = p[0] * (
            weights * u * u * (u * u) * (depth * depth * np.sqrt(depth)) / np.sqrt(p[1] + depth * u * u)
        ).sum(axis=-1)
        return stored if np.ndim(penetration) else float(stored)


@lru_cache(maxsize=1)
def _rule() -> Any:
    """Gauss' rule of 20 nodes."""
    return tuple(np.array(values) for values in gauss(20))
