"""Flores, Machado, Silva and Martins 2011: for the whole range of restitution."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class Flores(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 8 (1 - c_e)/(5 c_e), K as Hertz'."""

    name = "flores"
    source = (
        "Flores, Machado, Silva, Martins: On the continuous contact force models for soft materials in"
        " multibody dynamics. Multibody System Dynamics 25 (2011) 357-375"
    )
    formula = "F = K d^1.5 (1 + 8 (1 - e)/(5 e) d'/d'0)"
