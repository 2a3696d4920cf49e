"""Gonthier, McPhee, Lange and Piedboeuf 2004: bristles whose stiction depends on how long the surfaces have
dwelt.
"""

from dataclasses import dataclass

from ...kernels.elementary import approach
from ..law import Pair, quantity
from .forms import StaticFriction, regime_of_bristles


@dataclass(frozen=True, kw_only=True)
class GonthierFriction(StaticFriction):
    """F_T = -F_N {sat(sigma_0 z + sigma_1 dz/dt, f_max) + sigma_2 v}, f_max = mu_c + (mu_s - mu_c) s_dw,

    dz/dt = s v + (1 - s)[mu_c sign(v) - sigma_0 z]/sigma_1, s = exp(-(v/v_S)^2),
    ds_dw/dt = (s - s_dw)/tau, tau = tau_dw while s >= s_dw and sigma_1/sigma_0, the bristles' own time, while
    it falls.

    Taken from the account of Marques et al. (2016), not from the original. All per unit of normal force, as
    for ``lugre``: sigma_0 in 1/m, sigma_1 and sigma_2 in s/m.

    With dz/dt put in, sigma_0 z + sigma_1 dz/dt = s (sigma_0 z + sigma_1 v) + (1 - s) mu_c sign(v). s and
    sign(v)/|v| are taken at the velocity that the bristles' present force would leave; z, s_dw and the rest
    are implicit, and linear in the velocity that the force causes: first order in the step, and stable for
    any.
    """

    name = "gonthier"
    source = (
        "Gonthier, McPhee, Lange, Piedboeuf: A regularized contact model with asymmetric damping and"
        " dwell-time dependent friction. Multibody System Dynamics 11 (2004) 209-233; as given in Marques,"
        " Flores, Claro, Lankarani: A survey and comparison of several friction force models for dynamic"
        " analysis of multibody mechanical systems. Nonlinear Dynamics 86 (2016) 1407-1443"
    )
    formula = (
        "F = -N (sat(s0 z + s1 z', mu_c + (mu_s - mu_c) s_dw) + s2 v), z' = s v + (1 - s) (mu_c sign(v) - s0"
        " z)/s1"
    )
    slots = (
        "coefficient", "excess", "inverse_speed", "bristle_stiffness", "bristle_damping", "viscous",
        "inverse_damping", "dwell_time",
    )  # fmt: skip
    memory = ("bristle deflection (m)", "dwell s_dw (1)")
    regime = staticmethod(regime_of_bristles)

    stribeck_speed: float = quantity("m/s", "Stribeck speed v_S", 1e-3, above=0.0)
    bristle_stiffness: float = quantity(
        "1/m", "stiffness sigma_0 of the bristles per unit of normal force", 1e4, above=0.0
    )
    bristle_damping: float = quantity(
        "s/m", "damping sigma_1 of the bristles per unit of normal force", 31.6, above=0.0
    )
    viscous: float = quantity("s/m", "viscous friction sigma_2 per unit of normal force", 0.04, low=0.0)
    dwell_time: float = quantity("s", "time constant tau_dw with which stiction grows", 1.0, above=0.0)

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """mu_c and mu_s - mu_c (1), 1/v_S (s/m), sigma_0 (1/m), sigma_1 and sigma_2 (s/m), 1/sigma_1 (m/s),
        tau_dw (s).
        """
        s0, s1 = self.bristle_stiffness, self.bristle_damping
        excess = self.static_coefficient - self.coefficient
        return (
            self.coefficient,
            excess,
            1.0 / self.stribeck_speed,
            s0,
            s1,
            self.viscous,
            1.0 / s1,
            self.dwell_time,
        )

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: tuple[float, float],
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, tuple[float, float]]:
        """Friction force (N), deflection (m) and dwell (1)."""
        coefficient, excess, inverse_speed, stiffness, damping, viscous, inverse_damping, dwell_time = p
        deflection, dwelt = memory
        unit = mobility * normal_force
        largest = coefficient + excess
        elastic = stiffness * deflection
        elastic = largest if elastic > largest else elastic
        elastic = -largest if elastic < -largest else elastic
        ahead = free_velocity - unit * elastic
        ratio = ahead * inverse_speed
        slides = approach(ratio * ratio)
        sticks = 1.0 - slides
        growing = sticks >= dwelt
        pace = dt * stiffness * inverse_damping  # of the bristles: dt sigma_0/sigma_1
        dwelt = dwelt + (sticks - dwelt) * (
            (dt if growing else pace) / (dt + dwell_time if growing else 1.0 + pace)
        )
        limit = coefficient + excess * dwelt
        fade = 1.0 / (1.0 + pace * slides)
        inverse = 1.0 / (abs(ahead) + 1e-300)
        kinetic = slides * coefficient
        rub = kinetic * inverse
        static_force = sticks * stiffness * fade * deflection  # the force at v = 0, and its slope
        slope = sticks * (stiffness * fade * dt * (sticks + rub * inverse_damping) + damping) + rub
        denominator = 1.0 + unit * (slope + viscous)
        numerator = free_velocity - unit * static_force
        push = static_force * denominator + slope * numerator
        down = push > limit * denominator
        up = push < -limit * denominator
        numerator = free_velocity - unit * limit if down else numerator
        numerator = free_velocity + unit * limit if up else numerator
        velocity = numerator / (1.0 + unit * viscous if down or up else denominator)
        force = static_force + slope * velocity
        force = limit if down else force
        force = -limit if up else force
        share = velocity * inverse
        share = 1.0 if share > 1.0 else share
        share = -1.0 if share < -1.0 else share
        bent = fade * (deflection + dt * (sticks * velocity + kinetic * share * inverse_damping))
        return -normal_force * (force + viscous * velocity), (bent, dwelt)
