"""Contacts that share a body and may begin in the same step: their normal forces are solved together, whatever their order.

Solved in turn, the first of two corners that meet a wall feels the last step's force of the second, the second the new one of the first, and a
block that should stay upright turns. Here every contact answers to the same velocities, several times over. With the force of a pair of bodies
counted as often as contacts press on each of them, no such sweep overshoots: sum_ij x_i g_i g_j x_j <= c sum_i (g_i x_i)^2 for c contacts on a
body (Cauchy and Schwarz), so the sweeps approach the common solution from any start. Joints whose bodies hang in ideal joints, and bearings
around journals, are solved in turn.
"""

from .arrays import CONTACT, CONTACT_INDEX, HEADER, PARTICLE
from .geometry import normal_force

SWEEPS = 6


def press(S, j, b, k, normal, friction):
    """Adds a normal and a friction force of joint j to the forces on its two particles."""
    nx = S[j + CONTACT.nx]
    ny = S[j + CONTACT.ny]
    px = normal * nx + friction * ny
    py = friction * nx - normal * ny
    S[k + PARTICLE.fx] -= px
    S[k + PARTICLE.fy] += py
    S[k + PARTICLE.mz] += friction * S[j + CONTACT.jt] - normal * S[j + CONTACT.jn]
    S[b + PARTICLE.fx] += px
    S[b + PARTICLE.fy] -= py
    S[b + PARTICLE.mz] -= friction * S[j + CONTACT.bt] - normal * S[j + CONTACT.bn]


def shove(S, j, b, k, h, normal, friction):
    """Velocities at t_n of the two bodies of joint j under a change of its force."""
    nx = S[j + CONTACT.nx]
    ny = S[j + CONTACT.ny]
    px = normal * nx + friction * ny
    py = friction * nx - normal * ny
    hk = h * S[k + PARTICLE.inverse_mass]
    hb = h * S[b + PARTICLE.inverse_mass]
    S[k + PARTICLE.vu] -= hk * px
    S[k + PARTICLE.vv] += hk * py
    S[k + PARTICLE.vw] += h * S[k + PARTICLE.inverse_inertia] * (friction * S[j + CONTACT.jt] - normal * S[j + CONTACT.jn])
    S[b + PARTICLE.vu] += hb * px
    S[b + PARTICLE.vv] -= hb * py
    S[b + PARTICLE.vw] -= h * S[b + PARTICLE.inverse_inertia] * (friction * S[j + CONTACT.bt] - normal * S[j + CONTACT.bn])


def approach_rate(S, j, b, k):
    """Rate of the penetration at the velocities of t_n."""
    ru = S[k + PARTICLE.vu] - S[b + PARTICLE.vu]
    rv = S[k + PARTICLE.vv] - S[b + PARTICLE.vv]
    return S[j + CONTACT.nx] * ru + S[j + CONTACT.ny] * rv + S[j + CONTACT.jn] * S[k + PARTICLE.vw] - S[j + CONTACT.bn] * S[b + PARTICLE.vw]


def press_together(S, I, h):
    """Normal forces of contacts that are solved together."""
    for q in range(I[HEADER.jointed_count]):
        S[I[I[HEADER.jointed] + q] + PARTICLE.touches] = 0.0
    for m in range(I[HEADER.contact_count]):
        r = I[HEADER.contact] + CONTACT_INDEX.SIZE * m
        if I[r + CONTACT_INDEX.together] != 0:
            touching = 1.0 if S[I[r + CONTACT_INDEX.row] + CONTACT.penetration] > 0.0 else 0.0
            S[I[r + CONTACT_INDEX.bearing] + PARTICLE.touches] += touching
            S[I[r + CONTACT_INDEX.journal] + PARTICLE.touches] += touching
    for _ in range(SWEEPS):
        for m in range(I[HEADER.contact_count]):
            r = I[HEADER.contact] + CONTACT_INDEX.SIZE * m
            if I[r + CONTACT_INDEX.together] != 0:
                answer(S, I[r + CONTACT_INDEX.row], I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], h)
        for m in range(I[HEADER.contact_count]):
            r = I[HEADER.contact] + CONTACT_INDEX.SIZE * m
            if I[r + CONTACT_INDEX.together] != 0:
                j = I[r + CONTACT_INDEX.row]
                press(S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], S[j + CONTACT.more], 0.0)
                shove(S, j, I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], h, S[j + CONTACT.more], 0.0)
                S[j + CONTACT.normal] += S[j + CONTACT.more]


def answer(S, j, b, k, h):
    """By how much the normal force of a contact changes at the present velocities, its mobility counted for all contacts on its bodies."""
    jn = S[j + CONTACT.jn]
    bn = S[j + CONTACT.bn]
    on_journal = S[k + PARTICLE.touches] * (S[k + PARTICLE.inverse_mass] + jn * jn * S[k + PARTICLE.inverse_inertia])
    on_bearing = S[b + PARTICLE.touches] * (S[b + PARTICLE.inverse_mass] + bn * bn * S[b + PARTICLE.inverse_inertia])
    g = h * (on_journal + on_bearing)
    old = S[j + CONTACT.normal]
    normal, _ = normal_force(S[j + CONTACT.elastic], S[j + CONTACT.damping_coefficient], approach_rate(S, j, b, k) + g * old, g)
    S[j + CONTACT.more] = normal - old
