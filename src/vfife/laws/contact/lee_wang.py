"""Lee and Wang 1983."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class LeeWang(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 3/4 (1 - c_e), K as Hertz'."""

    name = "lee-wang"
    source = (
        "Lee, Wang: On the dynamics of intermittent-motion mechanisms. Part 1: Dynamic model and response. "
        "Journal of Mechanisms, Transmissions, and Automation in Design 105 (1983) 534-540"
    )
    formula = "F = K d^1.5 (1 + 3/4 (1 - e) d'/d'0)"
