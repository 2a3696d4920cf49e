"""Hunt and Crossley 1975: the first hysteresis damping."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class HuntCrossley(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 3/2 (1 - c_e), K as Hertz'."""

    name = "hunt-crossley"
    source = (
        "Hunt, Crossley: Coefficient of restitution interpreted as damping in vibroimpact. Journal of Applied"
        " Mechanics 42 (1975) 440-445"
    )
    formula = "F = K d^1.5 (1 + 3/2 (1 - e) d'/d'0)"
