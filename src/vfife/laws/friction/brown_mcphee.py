"""Brown and McPhee 2016: one smooth curve with a peak at the transition speed."""

from dataclasses import dataclass

from ...kernels.elementary import approach
from ..law import Pair, quantity
from .forms import StaticFriction, force_on_tangent, foreseen, regime_of_peak


@dataclass(frozen=True, kw_only=True)
class BrownMcPhee(StaticFriction):
    """F_T = -F_N {mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2} sign(v), x = |v|/v_t; the source's
    viscous term is left out.

    Solved along the tangent at the speed that the last two steps foresee, the falling part at that speed:
    second order in the step, and stable however steep the curve is.
    """

    name = "brown-mcphee"
    source = (
        "Brown, McPhee: A continuous velocity-based friction model for dynamics and control with physically"
        " meaningful parameters. Journal of Computational and Nonlinear Dynamics 11 (2016) 054502"
    )
    formula = "F = -N (mu_c tanh(4 x) + (mu_s - mu_c) x/(x^2/4 + 3/4)^2) sign(v), x = |v|/vt"
    slots = ("coefficient", "excess", "inverse_speed")
    memory = ("sliding velocity at n - 1 (m/s)", "sliding velocity at n - 2 (m/s)")
    regime = staticmethod(regime_of_peak)

    static_coefficient: float = quantity(
        "1", "static friction coefficient mu_s, the height of the peak but for tanh 4", 0.15, low=0.0
    )
    transition_speed: float = quantity("m/s", "speed v_t of the peak", 1e-3, above=0.0)

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
        last, earlier = memory
        unit = mobility * normal_force
        top = coefficient + excess
        speed = foreseen(free_velocity, unit * top, last, earlier)
        x = speed * inverse_speed
        decay = approach(8.0 * x)
        square = 0.25 * x * x + 0.75
        # tanh 4x = decay/(2 - decay) and 1/square from one division
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
