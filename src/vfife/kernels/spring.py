"""Springs and dampers between two bodies; each axis is solved for the velocity at t_n in closed form, as
contacts are.

A damper depends on the velocity at t_n, which a central difference computes only after the forces. The
velocity expected from the last acceleration contains the effect of the last resistance; the change of the
resistance enters through the mobility of the two bodies. A stiff damper is therefore stable. The mobility is
that of the two bodies alone: where they are pinned to others it is an upper bound, which errs on the stable
side.
"""

import math
from typing import NamedTuple

from .arrays import HEADER, PARTICLE, SPRING, SPRING_INDEX, SYSTEM
from .central_difference import Central, larger
from .constraint import Row, lever
from .contact import expected_velocity
from .geometry import arm, unlikely
from .topology import BUSHING, LINEAR, STOP


class Ends(NamedTuple):
    """A spring: its row g, the particles i and j of its first and second body, their arms to its pins, and
    the second pin seen from the first (m).
    """

    g: int
    i: int
    j: int
    ix: float
    iy: float
    jx: float
    jy: float
    ex: float
    ey: float


def resist(S, ends: Ends, axis, row: Row, x, central: Central):
    """Return the resistance (N, N m) along one axis to its lengthening, the elastic part of it, and the rate
    (m/s, rad/s).

    ``axis`` is 0 or 1 for forces and 2 for a moment; ``x`` (m, rad) is the lengthening of the spring.
    """
    g = ends.g
    i = ends.i
    j = ends.j
    iu, iv, iw = expected_velocity(S, i, central)
    ju, jv, jw = expected_velocity(S, j, central)
    straight = (row.nx * row.nx + row.ny * row.ny) * (
        S[j + PARTICLE.inverse_mass] + S[i + PARTICLE.inverse_mass]
    )
    inverse = (
        straight
        + row.jk * row.jk * S[j + PARTICLE.inverse_inertia]
        + row.jb * row.jb * S[i + PARTICLE.inverse_inertia]
    )
    mobility = central.p * central.h * inverse
    damping = S[g + SPRING.damping + axis]
    elastic = S[g + SPRING.stiffness + axis] * x
    # The rate without this spring: the expected rate holds the last resistance, which is taken out. The
    # second line solves rate' = rate - mobility (elastic + damping rate').
    rate = (
        row.nx * (ju - iu)
        + row.ny * (jv - iv)
        + row.jk * jw
        - row.jb * iw
        + mobility * S[g + SPRING.resistance + axis]
    )
    rate = (rate - mobility * elastic) / (1.0 + mobility * damping)
    return elastic + damping * rate, elastic, rate


def add(S, ends: Ends, axis, row: Row, force):
    """Apply a resistance (N, N m) along one axis to both bodies, and store it for the next step."""
    i = ends.i
    j = ends.j
    S[ends.g + SPRING.resistance + axis] = force
    S[j + PARTICLE.fx] -= force * row.nx
    S[j + PARTICLE.fy] -= force * row.ny
    S[j + PARTICLE.mz] -= force * row.jk
    S[i + PARTICLE.fx] += force * row.nx
    S[i + PARTICLE.fy] += force * row.ny
    S[i + PARTICLE.mz] += force * row.jb


def springs(S, I, span, central: Central):
    """Add the forces of all springs, dampers, stops and bushings at t_n."""
    for r in range(I[HEADER.spring], I[HEADER.spring_end], SPRING_INDEX.SIZE):
        g = I[r + SPRING_INDEX.row]
        power = spring(
            S, g, I[r + SPRING_INDEX.first], I[r + SPRING_INDEX.second], I[r + SPRING_INDEX.kind], central
        )
        S[g + SPRING.damping_power] = power
        S[g + SPRING.damping_work] += span * power
        squared = S[g + SPRING.fx] * S[g + SPRING.fx] + S[g + SPRING.fy] * S[g + SPRING.fy]
        S[g + SPRING.force_squared_max] = larger(S[g + SPRING.force_squared_max], squared)


def spring(S, g, i, j, kind, central: Central):
    """Add the force of the spring in row g to its bodies i and j; return the power lost in it (W).

    With ``central.h`` = 0 the velocities in the state count as those at t_n: so in step 0, and for the
    reactions of :mod:`vfife.kinematics.forces`.
    """
    ix, iy = arm(S[i + PARTICLE.c], S[i + PARTICLE.s], S[g + SPRING.first_x], S[g + SPRING.first_y])
    jx, jy = arm(S[j + PARTICLE.c], S[j + PARTICLE.s], S[g + SPRING.second_x], S[g + SPRING.second_y])
    ex = (S[j + PARTICLE.x] + jx) - (S[i + PARTICLE.x] + ix)
    ey = (S[j + PARTICLE.y] + jy) - (S[i + PARTICLE.y] + iy)
    ends = Ends(g, i, j, ix, iy, jx, jy, ex, ey)
    angle = S[j + PARTICLE.theta] - S[i + PARTICLE.theta]
    if kind == LINEAR:
        power = stretch(S, ends, central)
    elif kind == BUSHING:
        power = bush(S, ends, angle - S[g + SPRING.free], central)
    else:
        power = twist(S, ends, kind == STOP, angle, central)
    if kind == STOP:
        engage(S, g, angle)
    return power


def stretch(S, ends: Ends, central: Central):
    """Add the force of a spring along the line between two pins; return the power lost (W)."""
    g = ends.g
    length = math.sqrt(ends.ex * ends.ex + ends.ey * ends.ey)
    inverse = 1.0 / (length + 1e-300)
    nx = ends.ex * inverse
    ny = ends.ey * inverse
    row = Row(nx, ny, lever(ends.ix, ends.iy, nx, ny), lever(ends.jx, ends.jy, nx, ny))
    x = length - S[g + SPRING.free]
    force, elastic, rate = resist(S, ends, 0, row, x, central)
    add(S, ends, 0, row, force)
    S[g + SPRING.fx] = -force * nx
    S[g + SPRING.fy] = -force * ny
    S[g + SPRING.energy] = 0.5 * elastic * x
    return (force - elastic) * rate


def twist(S, ends: Ends, stop, angle, central: Central):
    """Add the moment of a torsional spring, or of a stop beyond one of its limits; return the power lost (W).

    A stop never pulls back. Where its damper would make it pull, the moment is zero, and the stop relaxes by
    itself: the energy that it still stores is dissipated in its damper as the angle returns.
    """
    g = ends.g
    row = Row(0.0, 0.0, 1.0, 1.0)
    past_low = angle - S[g + SPRING.free]
    past_high = angle - S[g + SPRING.high]
    x = (past_low if past_low < 0.0 else past_high if past_high > 0.0 else 0.0) if stop else past_low
    moment, elastic, rate = resist(S, ends, 2, row, x, central)
    pushes = moment * x > 0.0 if stop else True
    inverse = S[ends.j + PARTICLE.inverse_inertia] + S[ends.i + PARTICLE.inverse_inertia]
    force = stop_with_jump(moment, S, g, x, rate, inverse, central) if stop else moment
    rate = rate if pushes else rate + central.p * central.h * inverse * moment
    add(S, ends, 2, row, force)
    S[g + SPRING.moment] = -force
    S[g + SPRING.energy] = 0.5 * S[g + SPRING.stiffness + 2] * x * x
    return (force - elastic) * rate


def stop_with_jump(moment, S, g, x, rate, inverse, central: Central):
    """Return the moment (N m) of a stop: that of its spring and damper, zero where it would pull.

    Derivatives that follow a small difference add :func:`~vfife.kernels.jumps.stop_jump` times the slope of
    ``x`` and :func:`~vfife.kernels.jumps.stop_share` times that of ``moment`` (compiler/trace/jumps.py).
    """
    return moment if moment * x > 0.0 else 0.0


def engage(S, g, angle):
    """Report an event if a stop was touched or left since the last step."""
    low = angle < S[g + SPRING.free]
    high = angle > S[g + SPRING.high]
    regime = -1.0 if low else 1.0 if high else 0.0
    if unlikely(regime != S[g + SPRING.regime]):
        S[SYSTEM.event] = 1.0
        S[g + SPRING.regime] = regime


def bush(S, ends: Ends, angle, central: Central):
    """Add the force and moment of a bushing along the axes of its first body; return the power lost (W)."""
    g = ends.g
    c = S[ends.i + PARTICLE.c]
    s = S[ends.i + PARTICLE.s]
    # Both bodies feel the force at the second pin: a bushing of three stiffnesses has no moment of its own
    # there.
    px = ends.ix + ends.ex
    py = ends.iy + ends.ey
    axis_x = Row(c, s, lever(px, py, c, s), lever(ends.jx, ends.jy, c, s))
    axis_y = Row(-s, c, px * c + py * s, ends.jx * c + ends.jy * s)
    axis_z = Row(0.0, 0.0, 1.0, 1.0)
    x = ends.ex * c + ends.ey * s
    y = ends.ey * c - ends.ex * s
    fx, elastic_x, rate_x = resist(S, ends, 0, axis_x, x, central)
    fy, elastic_y, rate_y = resist(S, ends, 1, axis_y, y, central)
    moment, elastic_m, rate_m = resist(S, ends, 2, axis_z, angle, central)
    add(S, ends, 0, axis_x, fx)
    add(S, ends, 1, axis_y, fy)
    add(S, ends, 2, axis_z, moment)
    S[g + SPRING.fx] = fy * s - fx * c
    S[g + SPRING.fy] = -fx * s - fy * c
    S[g + SPRING.moment] = -moment
    S[g + SPRING.energy] = 0.5 * (elastic_x * x + elastic_y * y + elastic_m * angle)
    return (fx - elastic_x) * rate_x + (fy - elastic_y) * rate_y + (moment - elastic_m) * rate_m
