"""Hu and Guo 2015: for the whole range of restitution."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class HuGuo(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 3 (1 - c_e)/(2 c_e), K as Hertz'."""

    name = "hu-guo"
    source = (
        "Hu, Guo: A dissipative contact force model for impact analysis in multibody dynamics. Multibody"
        " System Dynamics 35 (2015) 131-151"
    )
    formula = "F = K d^1.5 (1 + 3 (1 - e)/(2 e) d'/d'0)"
