"""Herbert and McWhannell 1977."""

from dataclasses import dataclass

from .forms import PointContact


@dataclass(frozen=True, kw_only=True)
class HerbertMcWhannell(PointContact):
    """F_N = K delta^1.5 [1 + chi rate/impact_speed], chi = 6 (1 - c_e)/[(2 c_e - 1)^2 + 3], K as Hertz'."""

    name = "herbert-mcwhannell"
    source = (
        "Herbert, McWhannell: Shape and frequency composition of pulses from an impact pair. Journal of"
        " Engineering for Industry 99 (1977) 513-518"
    )
    formula = "F = K d^1.5 (1 + 6 (1 - e)/((2 e - 1)^2 + 3) d'/d'0)"
