"""Brown and McPhee 2016: one smooth curve with a peak at the transition speed."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...errors import Fault
from ...kernels.elementary import approach
from ..law import FrictionLaw, Pair, quantity
from .order import not_below
from .tangent import force_on_tangent, foreseen


@dataclass(frozen=True, kw_only=True)
class BrownMcPhee(FrictionLaw):
    """F_T = -F_N {mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2} sign(v), x = |v|/v_t; the source's
    viscous term is left out.

    Solved along the tangent at the speed that the last two steps foresee, the falling part at that speed:
    second order in the step, and stable however steep the curve is.
    """

    name: ClassVar[str] = "brown-mcphee"
    source: ClassVar[str] = (
        "Brown, McPhee: A continuous velocity-based friction model for dynamics and control with physically"
        " meaningful parameters. Journal of Computational and Nonlinear Dynamics 11 (2016) 054502"
    )
    formula: ClassVar[str] = "F = -N (mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2) sign(v), x = |v|/vt"
    slots: ClassVar[tuple[str, ...]] = ("coefficient", "excess", "inverse_speed")
    memory: ClassVar[tuple[str, ...]] = ("sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity(
        "1", "static friction coefficient mu_s, the height of the peak but for tanh 4", 0.15, low=0.0
    )
    transition_speed: float = quantity("m/s", "speed v_t of the peak", 1e-3, above=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where static friction is weaker than kinetic friction."""
        return not_below(self.static_coefficient, self.coefficient)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c and mu_s - mu_c (1), 1/v_t (s/m)."""
        return self.coefficient, self.static_coefficient - self.coefficient, 1.0 / self.transition_speed

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: tuple[float, float],
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, tuple[float, float]]:
        """Friction force (N) and the last two sliding velocities (m/s)."""
        coefficient, excess, inverse_speed = p
        last, before = memory
        unit = mobility * normal_force
        top = coefficient + excess
        speed = foreseen(free_velocity, unit * top, last, before)
        x = speed * inverse_speed
        decay = approach(8.0 * x)
        square = 0.25 * x * x + 0.75
        # tanh 4x = gone/(2 - gone) and 1/square from one division
        inverse = 1.0 / ((2.0 - decay) * square)
        tanh = decay * square * inverse
        fall = (2.0 - decay) * inverse
        bump = excess * fall * fall
        slope = inverse_speed * (4.0 * coefficient * (1.0 - tanh * tanh) + 0.75 * bump * fall * (1.0 - x * x))
        slope = slope if slope > 0.0 else 0.0
        force = normal_force * force_on_tangent(
            free_velocity, unit, speed, coefficient * tanh + bump * x, slope, top
        )
        force = -force if free_velocity > 0.0 else force
        return force, (free_velocity + mobility * force, last)

    @staticmethod
    def regime(sliding_velocity: float, p: tuple[float, ...]) -> float:
        """Return the regime: 0 on the rise to the peak, 1 or -1 beyond it. The curve is smooth and bends
        within the transition speed.

        sliding_velocity: in m/s
        p: the parameters of the law
        """
        beyond = abs(sliding_velocity) * p[2] > 1.0
        return (1.0 if sliding_velocity > 0.0 else -1.0) if beyond else 0.0
