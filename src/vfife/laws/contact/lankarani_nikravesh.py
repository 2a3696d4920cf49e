"""Lankarani and Nikravesh 1990: Hertz' elastic force with hysteresis damping."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class LankaraniNikravesh(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 3/4 (1 - c_e^2), K as Hertz'."""

    name = "lankarani-nikravesh"
    source = (
        "Lankarani, Nikravesh: A contact force model with hysteresis damping for impact analysis of multibody"
        " systems. Journal of Mechanical Design 112 (1990) 369-376"
    )
    formula = "F = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'0)"
    common = True
