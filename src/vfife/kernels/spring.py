"""Springs and dampers between two bodies, each axis solved for the velocity at t_n in closed form, as
contacts are.

A damper acts on the velocity at t_n, which a central difference does not know yet. The velocity expected from
the last step's acceleration holds the last resistance already; the change of the resistance enters through
the mobility of the two bodies, so a stiff damper is stable.
"""

import math

from .arrays import HEADER, PARTICLE, SPRING, SPRING_INDEX, SYSTEM
from .central_difference import larger
from .contact import expected
from .geometry import arm, seldom
from .topology import BUSHING, LINEAR, STOP


def resist(S, g, axis, b, k, n, x, p, h):
    """Force (N, N m) along one axis, against its lengthening; returned with its elastic part and the rate.

    ``n`` is (nx, ny, jb, jk): direction and levers on the two bodies; ``x`` the elastic lengthening of a
    stiffness at ``SPRING.stiffness + axis``.
    """
    nx, ny, jb, jk = n
    bu, bv, bw = expected(S, b, p, h)
    ku, kv, kw = expected(S, k, p, h)
    both = (nx * nx + ny * ny) * (S[k + PARTICLE.inverse_mass] + S[b + PARTICLE.inverse_mass])
    mobility = (
        p * h * (both + jk * jk * S[k + PARTICLE.inverse_inertia] + jb * jb * S[b + PARTICLE.inverse_inertia])
    )
    c = S[g + SPRING.damping + axis]
    elastic = S[g + SPRING.stiffness + axis] * x
    rate = nx * (ku - bu) + ny * (kv - bv) + jk * kw - jb * bw + mobility * S[g + SPRING.resistance + axis]
    rate = (rate - mobility * elastic) / (1.0 + mobility * c)
    return elastic + c * rate, elastic, rate


def add(S, g, axis, b, k, n, force):
    """Puts a resistance on both bodies."""
    nx, ny, jb, jk = n
    S[g + SPRING.resistance + axis] = force
    S[k + PARTICLE.fx] -= force * nx
    S[k + PARTICLE.fy] -= force * ny
    S[k + PARTICLE.mz] -= force * jk
    S[b + PARTICLE.fx] += force * nx
    S[b + PARTICLE.fy] += force * ny
    S[b + PARTICLE.mz] += force * jb


def springs(S, I, span, p, h):
    """Forces of all springs, dampers, stops and bushings at t_n."""
    for m in range(I[HEADER.spring_count]):
        r = I[HEADER.spring] + SPRING_INDEX.SIZE * m
        g = I[r + SPRING_INDEX.row]
        power = spring(
            S, g, I[r + SPRING_INDEX.first], I[r + SPRING_INDEX.second], I[r + SPRING_INDEX.kind], p, h
        )
        S[g + SPRING.damping_power] = power
        S[g + SPRING.damping_work] += span * power
        at = g + SPRING.force_squared_max
        S[at] = larger(S[at], S[g + SPRING.fx] * S[g + SPRING.fx] + S[g + SPRING.fy] * S[g + SPRING.fy])


def spring(S, g, b, k, kind, p, h):
    """Force of one of them on its two bodies; returned: power lost. With h = 0 the velocities are those at
    t_n, as they stand.
    """
    bx, by = arm(S[b + PARTICLE.c], S[b + PARTICLE.s], S[g + SPRING.first_x], S[g + SPRING.first_y])
    kx, ky = arm(S[k + PARTICLE.c], S[k + PARTICLE.s], S[g + SPRING.second_x], S[g + SPRING.second_y])
    ex = (S[k + PARTICLE.x] + kx) - (S[b + PARTICLE.x] + bx)
    ey = (S[k + PARTICLE.y] + ky) - (S[b + PARTICLE.y] + by)
    angle = S[k + PARTICLE.theta] - S[b + PARTICLE.theta]
    if kind == LINEAR:
        power = stretch(S, g, b, k, (bx, by, kx, ky), ex, ey, p, h)
    elif kind == BUSHING:
        power = bush(S, g, b, k, (kx, ky), (bx + ex, by + ey), ex, ey, angle - S[g + SPRING.free], p, h)
    else:
        power = twist(S, g, b, k, kind == STOP, angle, p, h)
    if kind == STOP:
        engage(S, g, angle)
    return power


def stretch(S, g, b, k, arms, ex, ey, p, h):
    """Spring along the line between two pins; returned: power lost."""
    bx, by, kx, ky = arms
    length = math.sqrt(ex * ex + ey * ey)
    inverse = 1.0 / (length + 1e-300)
    nx = ex * inverse
    ny = ey * inverse
    n = (nx, ny, bx * ny - by * nx, kx * ny - ky * nx)
    x = length - S[g + SPRING.free]
    force, elastic, rate = resist(S, g, 0, b, k, n, x, p, h)
    add(S, g, 0, b, k, n, force)
    S[g + SPRING.fx] = -force * nx
    S[g + SPRING.fy] = -force * ny
    S[g + SPRING.energy] = 0.5 * elastic * x
    return (force - elastic) * rate


def twist(S, g, b, k, stop, angle, p, h):
    """Torsional spring, or a stop beyond one of its limits, which never pulls back; returned: power lost.

    A stop that does not push any more relaxes by itself: what it has stored goes into its damper as the angle
    comes back.
    """
    n = (0.0, 0.0, 1.0, 1.0)
    over = angle - S[g + SPRING.free]
    beyond = angle - S[g + SPRING.high]
    x = (over if over < 0.0 else beyond if beyond > 0.0 else 0.0) if stop else over
    moment, elastic, rate = resist(S, g, 2, b, k, n, x, p, h)
    pushes = moment * x > 0.0 if stop else True
    rate = (
        rate
        if pushes
        else rate + p * h * (S[k + PARTICLE.inverse_inertia] + S[b + PARTICLE.inverse_inertia]) * moment
    )
    moment = moment if pushes else 0.0
    add(S, g, 2, b, k, n, moment)
    S[g + SPRING.moment] = -moment
    S[g + SPRING.energy] = 0.5 * S[g + SPRING.stiffness + 2] * x * x
    return (moment - elastic) * rate


def engage(S, g, angle):
    """Tells where a stop is met or left."""
    low = angle < S[g + SPRING.free]
    high = angle > S[g + SPRING.high]
    regime = -1.0 if low else 1.0 if high else 0.0
    if seldom(regime != S[g + SPRING.regime]):
        S[SYSTEM.event] = 1.0
        S[g + SPRING.regime] = regime


def bush(S, g, b, k, arm_k, arm_b, ex, ey, angle, p, h):
    """Bushing along the axes of the first body and about the axis of the plane; returned: power lost."""
    kx, ky = arm_k
    bx, by = arm_b
    c = S[b + PARTICLE.c]
    s = S[b + PARTICLE.s]
    along = (c, s, bx * s - by * c, kx * s - ky * c)
    across = (-s, c, bx * c + by * s, kx * c + ky * s)
    about = (0.0, 0.0, 1.0, 1.0)
    x = ex * c + ey * s
    y = ey * c - ex * s
    fx, elastic_x, rate_x = resist(S, g, 0, b, k, along, x, p, h)
    fy, elastic_y, rate_y = resist(S, g, 1, b, k, across, y, p, h)
    moment, elastic_m, rate_m = resist(S, g, 2, b, k, about, angle, p, h)
    add(S, g, 0, b, k, along, fx)
    add(S, g, 1, b, k, across, fy)
    add(S, g, 2, b, k, about, moment)
    S[g + SPRING.fx] = fy * s - fx * c
    S[g + SPRING.fy] = -fx * s - fy * c
    S[g + SPRING.moment] = -moment
    S[g + SPRING.energy] = 0.5 * (elastic_x * x + elastic_y * y + elastic_m * angle)
    return (fx - elastic_x) * rate_x + (fy - elastic_y) * rate_y + (moment - elastic_m) * rate_m
