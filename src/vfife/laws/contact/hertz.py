"""Hertz 1882: two elastic spheres, without dissipation or with the damping factor of another law."""

from dataclasses import dataclass

from ..law import quantity
from .damping import DAMPING
from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class Hertz(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 0 unless a damping factor is named; the
    restitution matters only then.
    """

    name = "hertz"
    source = (
        "Hertz: Über die Berührung fester elastischer Körper. Journal für die reine und angewandte Mathematik"
        " 92 (1882) 156-171"
    )
    formula = "F = K d^1.5"

    damping: str = quantity("1", "damping factor: the name of its law, or none", "none", choices=DAMPING)
