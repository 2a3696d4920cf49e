"""Laws that are a curve of the speed, solved along its tangent: one evaluation a step, of any curve."""


def foreseen(free_velocity: float, reach: float, last: float, before: float) -> float:
    """Speed (m/s), in the direction of ``free_velocity``, that the last two sliding velocities extrapolate
    to.

    Kept between |free_velocity| and what is left of it where friction takes all it can, ``reach`` (m/s): a
    contact that begins needs no past.
    """
    speed = abs(free_velocity)
    ahead = 2.0 * last - before
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
    rest = abs(free_velocity)
    stops = rest < unit * (share - slope * speed)
    over = rest if stops else share + slope * (rest - speed)
    under = unit if stops else 1.0 + unit * slope
    force = over / under
    return top if force > top else force
