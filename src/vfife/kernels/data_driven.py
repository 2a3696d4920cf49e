"""The data-driven loop as the driver sees it: steps of one lane, and the change of the step size."""

from .arrays import (
    ACTUATOR,
    CONSTRAINT,
    CONSTRAINT_INDEX,
    CONTACT,
    CONTACT_INDEX,
    DRIVEN,
    DRIVEN_INDEX,
    FUNCTION,
    FUNCTION_INDEX,
    HEADER,
    JOINT_INDEX,
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

# Steps between two copies of the state in the data-driven loop. A copy before every step would take a seventh
# of the time of a small mechanism's step. Instead, up to seven steps since the last copy are repeated before
# an event, with the same bits.
COPY_EVERY = 8


def copy_lane(to, source, rows, stride, w):
    """Copy lane w of a state."""
    for q in range(rows):
        to[q * stride + w] = source[q * stride + w]


def fast_steps(S, R, T, I, n, count, watching):
    """Take up to ``count`` steps of one lane from step n and return how many were taken; if ``watching``,
    undo a step with an event and stop before it.

    The data-driven loop has no separate fast step without unlikely branches: it takes full steps and goes
    back if one had an event.
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
        since = since + 1 if since + 1 < COPY_EVERY else 0
    return count


def full_step(S, T, I, n):
    """Take step n with all branches; n = 0 is the start."""
    functions(S, T, I, n)
    step(S, I, n, n == 0)


def resize(S, I, C):
    """Change the state of one lane to the step size C[0] (s) and phase C[1], and add C[2] to its number of
    repeated steps.
    """
    change_step(S, I, C[0], C[1], C[2])


def change_step(S, I, size, shift, repeated):
    """Change the state after step n to another step size (s): velocities and works to t_n + size/2, the
    reactions before to t_n - size.

    Positions, velocities and accelerations are known at t_n, so the change is exact up to one error: ideal
    joints would open by the third order of the step, and are closed again. With ``size`` equal to the old
    step it changes the state by rounding only.
    """
    old = S[SYSTEM.step]
    zeta = S[SYSTEM.damping] if I[HEADER.damped] != 0 else 0.0
    for q in range(I[HEADER.bound], I[HEADER.bound_end]):
        retime(S, I[q], old, size, zeta)
    for i in range(I[HEADER.plain], I[HEADER.plain_end], PLAIN):
        retime(S, i, old, size, zeta)
    # Works are integrated up to half a step after t_n: add or take off the difference at the power of t_n.
    longer = 0.5 * (size - old)
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        j = I[r + CONTACT_INDEX.row]
        S[j + CONTACT.damping_work] += longer * S[j + CONTACT.damping_power]
        S[j + CONTACT.friction_work] += longer * S[j + CONTACT.friction_power]
    for r in range(I[HEADER.spring], I[HEADER.spring_end], SPRING_INDEX.SIZE):
        g = I[r + SPRING_INDEX.row]
        S[g + SPRING.damping_work] += longer * S[g + SPRING.damping_power]
    for r in range(I[HEADER.driven], I[HEADER.driven_end], DRIVEN_INDEX.SIZE):
        row = I[r + DRIVEN_INDEX.row]
        S[row + DRIVEN.work] += longer * S[row + DRIVEN.power]
    for r in range(I[HEADER.joint], I[HEADER.joint_end], JOINT_INDEX.SIZE):
        row = I[r + JOINT_INDEX.actuator]
        if row != 0:
            S[row + ACTUATOR.work] += longer * S[row + ACTUATOR.power]
    S[SYSTEM.damping_work] += longer * S[SYSTEM.damping_power]
    S[SYSTEM.external_work] += longer * S[SYSTEM.external_power]
    # What is extrapolated through two steps (reactions, products of pivots) keeps its slope.
    for r in range(I[HEADER.constraint], I[HEADER.constraint_end], CONSTRAINT_INDEX.SIZE):
        q = I[r + CONSTRAINT_INDEX.row]
        S[q + CONSTRAINT.before] = S[q + CONSTRAINT.force] - (
            S[q + CONSTRAINT.force] - S[q + CONSTRAINT.before]
        ) * (size / old)
    S[SYSTEM.pivots_before] = S[SYSTEM.pivots] - (S[SYSTEM.pivots] - S[SYSTEM.pivots_before]) * (size / old)
    for r in range(I[HEADER.function], I[HEADER.function_end], FUNCTION_INDEX.SIZE):
        f = I[r + FUNCTION_INDEX.row]
        if I[r + FUNCTION_INDEX.argument] == TIME:
            S[f + FUNCTION.next] = S[f + FUNCTION.value] + size * (
                S[f + FUNCTION.rate] + 0.5 * size * S[f + FUNCTION.acceleration]
            )
    if I[HEADER.joint_count] > 0:
        close_velocities(S, I, size)
    S[SYSTEM.step] = size
    S[SYSTEM.shift] = shift
    S[SYSTEM.repeated] += repeated


def retime(S, i, old, size, zeta):
    """Change the half-step velocity of particle i from the step ``old`` to ``size`` (s), with the
    coefficient ``zeta`` (1/s) of mass-proportional damping.
    """
    S[i + PARTICLE.u] = resized(S[i + PARTICLE.u], S[i + PARTICLE.ax], old, size, zeta)
    S[i + PARTICLE.v] = resized(S[i + PARTICLE.v], S[i + PARTICLE.ay], old, size, zeta)
    S[i + PARTICLE.w] = resized(S[i + PARTICLE.w], S[i + PARTICLE.aw], old, size, zeta)
