"""Brown and McPhee 2016: one smooth curve with a peak at the transition speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ...kernels.elementary import approach
from ..law import FrictionLaw, Pair, quantity
from .order import not_below


@dataclass(frozen=True)
class BrownMcPhee(FrictionLaw):
    """F_T = -F_N {mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2} sign(v), x = |v|/v_t; the source's viscous term is left out.

    Smooth, so steep in place of set-valued: solved with the velocity that the force itself leaves, by five steps of Halley's method kept
    between two bounds, from where a parabola in place of tanh has it. In x the relation is x + beta_c tanh(4 x) + beta_d x/(x^2/4 + 3/4)^2 = rho
    with beta = mobility F_N mu/v_t. Beyond beta_d = 2.2 the falling part has several solutions in one step, and one of them is found.
    """

    name: ClassVar[str] = "brown-mcphee"
    source: ClassVar[str] = (
        "Brown, McPhee: A continuous velocity-based friction model for dynamics and control with physically meaningful parameters. "
        "Journal of Computational and Nonlinear Dynamics 11 (2016) 054502"
    )
    formula: ClassVar[str] = "F = -N (mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2) sign(v), x = |v|/vt"
    slots: ClassVar[tuple[str, ...]] = ("coefficient", "excess", "inverse_speed")

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s, the height of the peak but for tanh 4", 0.15, low=0.0)
    transition_speed: float = quantity("m/s", "speed v_t of the peak", 1e-3, above=0.0)

    def __post_init__(self) -> None:
        not_below(self.static_coefficient, self.coefficient)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c and mu_s - mu_c (1), 1/v_t (s/m)."""
        return self.coefficient, self.static_coefficient - self.coefficient, 1.0 / self.transition_speed

    @staticmethod
    def force(normal_force: float, free_velocity: float, mobility: float, memory: float, dt: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Friction force (N)."""
        coefficient, excess, inverse_speed = p
        unit = mobility * normal_force * inverse_speed
        kinetic = unit * coefficient
        peak = unit * excess
        rho = abs(free_velocity) * inverse_speed
        low = rho - kinetic - peak
        low = low if low > 0.0 else 0.0
        high = rho
        slope = 1.0 + 4.0 * kinetic + 1.7777777777777777 * peak
        square = slope * slope - 16.0 * kinetic * rho
        x = 2.0 * rho / (slope + math.sqrt(square if square > 0.0 else 0.0))
        far = low if low > 0.5 else 0.5
        x = x if square > 0.0 and x < 0.5 else far
        for _ in range(5):
            value, slope, bend = curve(x, kinetic, peak)
            error = x + value - rho
            low = x if error < 0.0 else low
            high = x if error > 0.0 else high
            inverse = 1.0 / (1.0 + slope)
            step = error * inverse
            turn = 0.5 * step * bend * inverse
            turn = turn if turn < 0.5 else 0.5
            turn = turn if turn > -0.5 else -0.5
            near = x - step / (1.0 - turn)
            inside = near >= low and near <= high
            x = near if inside else 0.5 * (low + high)
        force = normal_force * curve(x, coefficient, excess)[0]
        return -force if free_velocity > 0.0 else force, memory


def curve(x: float, kinetic: float, peak: float) -> tuple[float, float, float]:
    """kinetic tanh(4 x) + peak x/(x^2/4 + 3/4)^2 for x >= 0 with its first two derivatives."""
    gone = approach(8.0 * x)
    tanh = gone / (2.0 - gone)
    rise = 4.0 * kinetic * (1.0 - tanh * tanh)
    square = x * x
    inverse = 1.0 / (0.25 * square + 0.75)
    bump = peak * inverse * inverse
    fall = bump * inverse
    turn = fall * inverse * x * (1.125 * (square - 1.0) - 1.5 * (0.25 * square + 0.75))
    return kinetic * tanh + bump * x, rise + 0.75 * fall * (1.0 - square), turn - 8.0 * tanh * rise
