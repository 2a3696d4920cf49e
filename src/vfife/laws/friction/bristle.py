"""Bristles: what Dahl's and the LuGre law share, the exact step of a deflection solved with the velocity that it causes."""

from __future__ import annotations

from ...kernels.elementary import approach, relaxed


def bend(
    normal_force: float, free_velocity: float, mobility: float, deflection: float, last: float, dt: float,
    capacity: float, stiffness: float, damping: float, viscous: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Force (N), new deflection (m) and sliding velocity (m/s) of bristles that carry ``capacity`` times the normal force in steady sliding.

    dz/dt = v - stiffness |v| z/capacity, F = -F_N (stiffness z + damping dz/dt + viscous v).

    Over a step v is the mean of its two ends, for which the deflection has the exact step z+ = z e^(-y) + (capacity/stiffness)(1 - e^(-y)),
    y = stiffness |v| dt/capacity. dz/dt is (z+ - z)/dt, with which F falls as v rises, whatever the damping: one solution at any mobility.
    In w = stiffness z/capacity the relation is A y + B w = C, that is y + beta (1 - e^(-y)) = rho. Stiffness in 1/m, damping and viscous in
    s/m are per unit of normal force.

    A deflection above what the bristles carry (they were bent at a lower speed) is cut where a step is too long to follow its relaxation,
    beta < -1/2: there the relation would have several solutions.
    """
    press = mobility * normal_force
    drag = 1.0 + press * viscous
    unit = capacity / (stiffness * dt)
    extra = damping / (stiffness * dt)
    a = 2.0 * unit * drag
    b = press * capacity * (1.0 + extra)
    most = 1.0 + 0.5 * a / (b + 1e-300)
    w = stiffness * deflection / capacity
    w = most if w > most else w
    w = -most if w < -most else w
    driven = free_velocity + drag * last - press * capacity * w
    sign = 1.0 if driven > 0.0 else -1.0
    inverse = 1.0 / a
    y = relaxed(b * inverse * (1.0 - sign * w), abs(driven) * inverse)
    bent = (sign - w) * approach(y)
    velocity = 2.0 * unit * sign * y - last
    force = -normal_force * (capacity * (w + bent + extra * bent) + viscous * velocity)
    return force, capacity * (w + bent) / stiffness, velocity
