"""What the driver calls in the data-driven loop: steps of one lane, and the change from steps of one size to
another.
"""

from .arrays import (
    CONSTRAINT,
    CONSTRAINT_INDEX,
    CONTACT,
    CONTACT_INDEX,
    DRIVEN,
    DRIVEN_INDEX,
    FUNCTION,
    FUNCTION_INDEX,
    HEADER,
    PARTICLE,
    PLAIN,
    SPRING,
    SPRING_INDEX,
    SYSTEM,
)
from .central_difference import resized
from .closing import close_velocities
from .step import functions, step
from .topology import TIME

# Steps between two copies of the state in the data-driven loop. A copy before every step takes a seventh of a
# small step's time; the few steps
# since the last copy are taken again instead, with the same bits.
KEPT = 8


def copy_lane(to, source, rows, stride, w):
    """Copy one lane of a state."""
    for q in range(rows):
        to[q * stride + w] = source[q * stride + w]


def lean(S, R, T, I, n, count, watching):
    """Steps of the data-driven loop, one lane: up to ``count`` from step n; where ``watching``, one with an
    event is undone and is the last.
    """
    watched = watching and I[HEADER.watched] != 0
    since = 0  # steps since the state was copied to R
    for k in range(n, n + count):
        if watched and since == 0:
            copy_lane(R, S, I[HEADER.rows], 1, 0)
        functions(S, T, I, k)
        step(S, I, k, False)
        if watched and S[SYSTEM.event] > 0.0:
            copy_lane(S, R, I[HEADER.rows], 1, 0)
            for i in range(k - since, k):
                functions(S, T, I, i)
                step(S, I, i, False)
            return k - n
        since = since + 1 if since + 1 < KEPT else 0
    return count


def whole(S, T, I, n):
    """Step n of the data-driven loop."""
    functions(S, T, I, n)
    step(S, I, n, n == 0)


def resize(S, I, C):
    """The state of the data-driven loop for steps of another size."""
    change_step(S, I, C[0], C[1], C[2])


def change_step(S, I, size, shift, repeated):
    """Change the state after step n to what steps of another size (s) have: velocities and works up to t_n +
    size/2, reactions before at t_n - size.

    At t_n positions, velocities and accelerations are all known, so nothing is lost there, but that ideal
    joints would open by a third order of the step: they are closed. For one size this changes nothing but
    rounding.
    """
    old = S[SYSTEM.step]
    zeta = S[SYSTEM.damping] if I[HEADER.damped] != 0 else 0.0
    for q in range(I[HEADER.bound_count]):
        retime(S, I[I[HEADER.bound] + q], old, size, zeta)
    for q in range(I[HEADER.plain_count]):
        retime(S, I[HEADER.plain] + PLAIN * q, old, size, zeta)
    more = 0.5 * (size - old)
    for m in range(I[HEADER.contact_count]):
        j = I[I[HEADER.contact] + CONTACT_INDEX.SIZE * m]
        S[j + CONTACT.damping_work] += more * S[j + CONTACT.damping_power]
        S[j + CONTACT.friction_work] += more * S[j + CONTACT.friction_power]
    for m in range(I[HEADER.spring_count]):
        g = I[I[HEADER.spring] + SPRING_INDEX.SIZE * m]
        S[g + SPRING.damping_work] += more * S[g + SPRING.damping_power]
    for m in range(I[HEADER.driven_count]):
        k = I[I[HEADER.driven] + DRIVEN_INDEX.SIZE * m]
        S[k + DRIVEN.work] += more * S[k + DRIVEN.power]
    S[SYSTEM.damping_work] += more * S[SYSTEM.damping_power]
    S[SYSTEM.external_work] += more * S[SYSTEM.external_power]
    for m in range(I[HEADER.constraint_count]):
        q = I[I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m]
        S[q + CONSTRAINT.before] = S[q + CONSTRAINT.force] - (
            S[q + CONSTRAINT.force] - S[q + CONSTRAINT.before]
        ) * (size / old)
    S[SYSTEM.pivots_before] = S[SYSTEM.pivots] - (S[SYSTEM.pivots] - S[SYSTEM.pivots_before]) * (size / old)
    for m in range(I[HEADER.function_count]):
        f = I[I[HEADER.function] + FUNCTION_INDEX.SIZE * m + FUNCTION_INDEX.row]
        if I[I[HEADER.function] + FUNCTION_INDEX.SIZE * m + FUNCTION_INDEX.argument] == TIME:
            S[f + FUNCTION.next] = S[f + FUNCTION.value] + size * (
                S[f + FUNCTION.rate] + 0.5 * size * S[f + FUNCTION.acceleration]
            )
    if I[HEADER.joint_count] > 0:
        close_velocities(S, I, size)
    S[SYSTEM.step] = size
    S[SYSTEM.shift] = shift
    S[SYSTEM.repeated] += repeated


def retime(S, i, old, size, zeta):
    """The half-step velocity of a free particle for a step of another size."""
    S[i + PARTICLE.u] = resized(S[i + PARTICLE.u], S[i + PARTICLE.ax], old, size, zeta)
    S[i + PARTICLE.v] = resized(S[i + PARTICLE.v], S[i + PARTICLE.ay], old, size, zeta)
    S[i + PARTICLE.w] = resized(S[i + PARTICLE.w], S[i + PARTICLE.aw], old, size, zeta)
