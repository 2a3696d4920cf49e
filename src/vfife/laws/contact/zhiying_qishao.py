"""Zhiying and Qishao 2006."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class ZhiyingQishao(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 3/4 (1 - c_e^2) exp[2 (1 - c_e)], K as Hertz'."""

    name = "zhiying-qishao"
    source = (
        "Zhiying, Qishao: Analysis of non-linear damping models for collisions of multibody systems. "
        "Chinese Journal of Computational Mechanics 23 (2006)"
    )
    formula = "F = K d^1.5 (1 + 3/4 (1 - e^2) exp(2 (1 - e)) d'/d'0)"
