"""Bristles: what Dahl's and the LuGre law share, the step of a deflection solved with the velocity that it
causes.
"""


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
    deflection, last, before = memory
    y = abs(1.5 * last - 0.5 * before) * dt * inverse
    bow = 1.0 + 0.5 * y
    fade = 1.0 / (1.0 + y * bow)
    rise = 0.5 * dt * bow * fade  # z+ = start + rise v
    start = deflection * fade + rise * last
    most = abs(deflection)
    most = most if most > stretch else stretch
    press = mobility * normal_force
    drag = damping / dt
    total = stiffness + drag
    damped = drag * deflection
    viscid = 1.0 + press * viscous
    over = free_velocity - press * (total * start - damped)
    under = viscid + press * total * rise
    after = start * under + rise * over
    full = most * under
    down = after > full
    up = after < -full
    over = free_velocity - press * (total * most - damped) if down else over
    over = free_velocity + press * (total * most + damped) if up else over
    velocity = over / (viscid if down or up else under)
    bent = start + rise * velocity
    bent = most if down else bent
    bent = -most if up else bent
    return -normal_force * (total * bent - damped + viscous * velocity), (bent, velocity, last)
