"""Steps one after the other: those in which something begins are taken again as smaller ones, and lanes may be out of phase.

A central difference takes the force at the end of a step for all of it. Where a contact begins, friction changes its regime or a load has a kink,
that is an error of first order; eight steps of an eighth leave a sixty-fourth of it, for as many steps more as there are such events.

What was before such a step has to be known. To copy the state before every step takes a seventh of a small one's time, so it is kept before every
eighth, and the few steps since then are taken again: they have the same bits.
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

KEPT = 8  # steps from one copy of the state to the next


def resize(S, I, size, shift, repeated):
    """The state after step n as steps of another size (s) have it: velocities and works up to t_n + size/2, reactions before at t_n - size.

    At t_n positions, velocities and accelerations are all known, so nothing is lost there, but that ideal joints would open by a third order
    of the step: they are closed. For one size this changes nothing but rounding.
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
        S[q + CONSTRAINT.before] = S[q + CONSTRAINT.force] - (S[q + CONSTRAINT.force] - S[q + CONSTRAINT.before]) * (size / old)
    S[SYSTEM.pivots_before] = S[SYSTEM.pivots] - (S[SYSTEM.pivots] - S[SYSTEM.pivots_before]) * (size / old)
    for m in range(I[HEADER.function_count]):
        f = I[I[HEADER.function] + FUNCTION_INDEX.SIZE * m + FUNCTION_INDEX.row]
        if I[I[HEADER.function] + FUNCTION_INDEX.SIZE * m + FUNCTION_INDEX.argument] == TIME:
            S[f + FUNCTION.next] = S[f + FUNCTION.value] + size * (S[f + FUNCTION.rate] + 0.5 * size * S[f + FUNCTION.acceleration])
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


def again(S, K, T, I, tables, n, before, parts, rows):
    """Step n once more, as so many smaller ones; K is the state after step n - 1 - ``before``."""
    for q in range(rows):
        S[q] = K[q]
    for i in range(n - before, n):
        functions(S, T, I, tables, i)
        step(S, I, i, i == 0)
    dt = S[SYSTEM.step]
    shift = S[SYSTEM.shift]
    functions(S, T, I, tables, n - 1)
    resize(S, I, dt / parts, shift * parts, 1.0)
    for i in range((n - 1) * parts + 1, n * parts + 1):
        functions(S, T, I, tables, i)
        step(S, I, i, i == 0)  # the kinds that the first call has: another literal would be compiled anew
    resize(S, I, dt, shift, 0.0)


def displace(S, T, I, tables, n, share):
    """After the start, a first step of a share of one, as step n = 1: all that follow are out of phase with those of a simulation without it."""
    dt = S[SYSTEM.step]
    resize(S, I, share * dt, 0.0, 0.0)
    functions(S, T, I, tables, n)
    step(S, I, n, n == 0)
    resize(S, I, dt, share, 0.0)


def watch(S, w, lanes, kept, limited, limits, broken, n):
    """Lane w breaks after n steps: a number among the rows ``kept`` is not finite, or one in a row of ``limited`` not between its two ``limits``.

    What is not at zero in ``broken`` has broken before, or nobody looks at it.
    """
    if broken[w] == 0.0:
        nothing = 0.0
        for q in kept:
            nothing += S[q] * 0.0
        within = nothing == 0.0
        for q in range(len(limited)):
            x = S[limited[q]]
            within = within and x >= limits[2 * q * lanes + w] and x <= limits[(2 * q + 1) * lanes + w]
        if not within:
            broken[w] = n


def advance(S, K, T, I, wide, rows, lanes, n0, count, parts, shares, out, kept, extremes, look, limited, limits, broken):
    """Lane by lane: fills ``out[m, :, lane]`` with the rows ``kept`` after ``count`` steps more; ``extremes`` start anew before them.

    ``wide`` holds the states, rows by lanes; S and K are scratch for one of them. T holds the tables of all lanes, one after the other.
    A step in which something begins, ends or changes its regime is taken again in ``parts``. The first step of lane w is ``shares[w]`` of one,
    where that is not zero, beside those that are counted. Wherever ``look`` divides the number of steps made, a lane is watched, and one that
    breaks is left there; rows of ``out`` after that mean nothing.
    """
    watched = parts > 1 and I[HEADER.watched] != 0
    for w in range(lanes):
        tables = w * (len(T) // lanes)
        for q in range(rows):
            S[q] = wide[q * lanes + w]
        until = look - n0 % look
        for m in range(out.shape[0]):
            if broken[w] > 0.0:
                break
            for q in extremes:
                S[q] = 0.0
            since = 0  # steps since the state was kept in K
            for n in range(n0 + m * count, n0 + (m + 1) * count):
                if watched and since == 0:
                    for q in range(rows):
                        K[q] = S[q]
                functions(S, T, I, tables, n)
                step(S, I, n, n == 0)
                if watched and n > 0 and S[SYSTEM.event] > 0.0:
                    again(S, K, T, I, tables, n, since, parts, rows)
                    since = KEPT
                since = since + 1 if n > 0 and since + 1 < KEPT else 0
                if n == 0 and shares[w] > 0.0:
                    displace(S, T, I, tables, n + 1, shares[w])
                until -= 1
                if until == 0:
                    until = look
                    watch(S, w, lanes, kept, limited, limits, broken, n + 1)
                    if broken[w] > 0.0:
                        break
            for q in range(out.shape[1]):
                out[m, q, w] = S[kept[q]]
        for q in range(rows):
            wide[q * lanes + w] = S[q]
