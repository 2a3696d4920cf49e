"""Fields, regimes and solutions that several friction laws share."""

from collections.abc import Iterator
from dataclasses import dataclass

from ...errors import Fault
from ..law import FrictionLaw, quantity


@dataclass(frozen=True, kw_only=True)
class StaticFriction(FrictionLaw):
    """Base of laws with a static coefficient of friction, which is not below the kinetic one."""

    coefficient: float = quantity("1", "kinetic friction coefficient mu_c", 0.1, low=0.0)
    static_coefficient: float = quantity("1", "static friction coefficient mu_s", 0.15, low=0.0)

    def disagreements(self) -> Iterator[Fault]:
        """Yield a fault where static friction is weaker than kinetic friction."""
        if self.static_coefficient < self.coefficient:
            yield Fault(
                "static_coefficient",
                f"below coefficient = {self.coefficient:g}",
                f"{self.static_coefficient:g}",
                f"at least {self.coefficient:g}",
                "raise the one or lower the other",
            )


def regime_of_sticking(sliding_velocity: float, p: tuple[float, ...]) -> float:
    """Return the regime of a set-valued law: 0 for sticking, 1 or -1 for sliding.

    sliding_velocity: in m/s, 0 for sticking
    p: the parameters of the law
    """
    return 1.0 if sliding_velocity > 0.0 else -1.0 if sliding_velocity < 0.0 else 0.0


def regime_of_bristles(sliding_velocity: float, p: tuple[float, ...]) -> float:
    """Return the regime of a law of bristles: 1 or -1, the direction in which they are bent.

    sliding_velocity: in m/s
    p: the parameters of the law
    """
    return 1.0 if sliding_velocity > 0.0 else -1.0


def regime_of_peak(sliding_velocity: float, p: tuple[float, ...]) -> float:
    """Return the regime of a curve that rises to a peak or to full friction: 0 on the rise, 1 or -1 beyond.

    sliding_velocity: in m/s
    p: the parameters of the law; the third one is the inverse of the speed (m/s) at which the rise ends
    """
    beyond_rise = abs(sliding_velocity) * p[2] > 1.0
    return (1.0 if sliding_velocity > 0.0 else -1.0) if beyond_rise else 0.0


def foreseen(free_velocity: float, reach: float, last: float, earlier: float) -> float:
    """Speed (m/s), in the direction of ``free_velocity``, that the last two sliding velocities extrapolate
    to.

    Kept between |free_velocity| and what is left of it where friction takes all it can, ``reach`` (m/s): a
    contact that begins needs no past.
    """
    speed = abs(free_velocity)
    ahead = 2.0 * last - earlier
    ahead = ahead if free_velocity > 0.0 else -ahead
    low = speed - reach
    low = low if low > 0.0 else 0.0
    ahead = ahead if ahead > low else low
    return ahead if ahead < speed else speed


def force_on_tangent(
    free_velocity: float, unit: float, speed: float, share: float, slope: float, top: float
) -> float:
    """Friction force per normal force, not negative, from the value and slope (s/m) of the curve at the
    foreseen ``speed`` (m/s).

    With v = |free_velocity| - unit f, unit = mobility F_N, the tangent f = share + slope (v - speed) gives
    f = [share + slope (|free_velocity| - speed)]/(1 + unit slope). A falling curve is to be given with slope
    0: it has one solution then, and the foreseen speed makes it second order in the step all the same. What
    would turn the sliding round stops it; ``top`` is the most.
    """
    free_speed = abs(free_velocity)
    stops = free_speed < unit * (share - slope * speed)
    numerator = free_speed if stops else share + slope * (free_speed - speed)
    denominator = unit if stops else 1.0 + unit * slope
    force = numerator / denominator
    return top if force > top else force


def bend(
    normal_force: float, free_velocity: float, mobility: float, memory: tuple[float, float, float], dt: float,
    stretch: float, inverse: float, stiffness: float, damping: float, viscous: float,
) -> tuple[float, tuple[float, float, float]]:  # fmt: skip
    """Force (N), new deflection (m) and the last two sliding velocities (m/s) of bristles that are bent by
    ``stretch`` (m) in steady sliding.

    dz/dt = v - |v| z/stretch, F = -F_N (stiffness z + damping dz/dt + viscous v).

    Over a step v is the mean of its two ends and |v| what the last two velocities extrapolate to in its
    middle, so that the relation is linear in the velocity that the force causes. With y = |v| dt/stretch the
    deflection fades by 1/(1 + y + y^2/2): second order, of any step, and the deflection of steady sliding is
    kept exactly. dz/dt is (z+ - z)/dt. Nothing bends bristles further than ``stretch`` but what they were
    bent before at a lower speed. Stiffness in 1/m, damping and viscous in s/m are per unit of normal force;
    ``inverse`` is 1/stretch.
    """
    deflection, last, earlier = memory
    y = abs(1.5 * last - 0.5 * earlier) * dt * inverse
    bow = 1.0 + 0.5 * y
    fade = 1.0 / (1.0 + y * bow)
    rise = 0.5 * dt * bow * fade  # z+ = start + rise v
    start = deflection * fade + rise * last
    largest = abs(deflection)
    largest = largest if largest > stretch else stretch
    press = mobility * normal_force
    drag = damping / dt
    total = stiffness + drag
    damped = drag * deflection
    viscid = 1.0 + press * viscous
    numerator = free_velocity - press * (total * start - damped)
    denominator = viscid + press * total * rise
    scaled_bend = start * denominator + rise * numerator
    full = largest * denominator
    down = scaled_bend > full
    up = scaled_bend < -full
    numerator = free_velocity - press * (total * largest - damped) if down else numerator
    numerator = free_velocity + press * (total * largest + damped) if up else numerator
    velocity = numerator / (viscid if down or up else denominator)
    bent = start + rise * velocity
    bent = largest if down else bent
    bent = -largest if up else bent
    return -normal_force * (total * bent - damped + viscous * velocity), (bent, velocity, last)
