"""Gonthier, McPhee, Lange and Piedboeuf 2004."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class Gonthier(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = d/c_e with the authors' estimate d = 1 - c_e^2, K
    as Hertz'.
    """

    name = "gonthier"
    source = (
        "Gonthier, McPhee, Lange, Piedboeuf: A regularized contact model with asymmetric damping and"
        " dwell-time dependent friction. Multibody System Dynamics 11 (2004) 209-233"
    )
    formula = "F = K d^1.5 (1 + (1 - e^2)/e d'/d'0)"
