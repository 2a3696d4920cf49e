"""Forces of contacts on their two bodies, and normal forces that are solved simultaneously; names as in
:mod:`~vfife.kernels.contact`.

Contacts of rounds and corners that share a body and may begin in the same step are solved together, so that
the result does not depend on their order. Solved one after the other, the first of two corners that hit a
wall would feel the last step's force of the second, the second the new force of the first, and a block that
should stay upright would turn. Here all contacts of a sweep use the same velocities, and the sweep is
repeated (Jacobi's iteration). Each body's mobility is multiplied by the number c of contacts that press on
it. Then no sweep overshoots, because sum_ij x_i g_i g_j x_j <= c sum_i (g_i x_i)^2 (Cauchy and Schwarz), and
the sweeps converge to the common solution from any start. Joints whose bodies are held by ideal joints, and
bearings around journals, are solved one after the other.

An oil film acts in free flight and adds to the contact force in contact. Its force is linear in the
velocities at t_n; its law provides the coefficients at the present eccentricity. Film and contact therefore
have one closed-form solution: the force along t is eliminated, and what remains is the scalar equation of a
dry contact.
"""

from typing import Any

from .arrays import CONTACT, CONTACT_INDEX, HEADER, PARTICLE
from .geometry import normal_force

film_law: Any = None  # written by the compiler (compiler/trace/source.py) for the laws of a mechanism


def film_coefficients(S, contact, j, b, k):
    """Store the coefficients of a film's force, which is linear in the velocities at t_n.

    The wedge of oil turns with the sign of e (w_J + w_B) - 2 v_t, where e is the eccentricity and v_t the
    velocity along t between the centres; friction has no arms in a joint with a film, so that v_t is the
    joint's sliding velocity. Only this sign is taken from the half-step velocities that are known already;
    everything else is solved at t_n.
    """
    nx = S[j + CONTACT.nx]
    ny = S[j + CONTACT.ny]
    bw = S[b + PARTICLE.w]
    kw = S[k + PARTICLE.w]
    slide = (
        nx * (S[k + PARTICLE.v] - S[b + PARTICLE.v])
        - ny * (S[k + PARTICLE.u] - S[b + PARTICLE.u])
        + S[j + CONTACT.jt] * kw
        - S[j + CONTACT.bt] * bw
    )
    turning = (S[j + CONTACT.penetration] + S[j + CONTACT.size]) * (kw + bw)
    sense = 1.0 if turning > 2.0 * slide else -1.0
    radial, across, damping, tangential, cross = film_law(
        contact, S[j + CONTACT.penetration], turning, sense, S, j + CONTACT.slots
    )
    S[j + CONTACT.film_radial] = radial
    S[j + CONTACT.film_across] = across
    S[j + CONTACT.damping_coefficient] += damping
    S[j + CONTACT.film_damping] = tangential
    S[j + CONTACT.film_cross] = cross


def eliminate_film(S, j, slip, gt):
    """Return the normal force at zero rate (N) and the damping coefficient (N s/m) of a joint with a film,
    after elimination of the force along t.

    The two equations are F_N = radial + D_n v_n - X v_t and F_T = across + X v_n - D_t v_t, with
    v_t = slip + gt F_T. The damping coefficient that remains is positive because X^2 < D_n D_t.
    """
    # F_T (1 + gt D_t) = across + X v_n - D_t slip is put into the equation of F_N. The slip is that under
    # the forces so far; what a change of F_N adds to it by the coupling gm enters only the force along t.
    share = 1.0 / (1.0 + gt * S[j + CONTACT.film_damping])
    cross = S[j + CONTACT.film_cross]
    push = (
        S[j + CONTACT.elastic]
        + S[j + CONTACT.film_radial]
        - cross * share * (slip + gt * S[j + CONTACT.film_across])
    )
    return push, S[j + CONTACT.damping_coefficient] - cross * cross * gt * share


def film_force(S, j, rate, slip, gt):
    """Return the force of the film along t (N) at the solved rate along n (m/s)."""
    return (
        S[j + CONTACT.film_across] + S[j + CONTACT.film_cross] * rate - S[j + CONTACT.film_damping] * slip
    ) / (1.0 + gt * S[j + CONTACT.film_damping])


# Sweeps over all contacts that are solved simultaneously. The last step's forces are a good start, so the
# number may be fixed: lanes need no common test of convergence.
SWEEPS = 6


def apply_contact_force(S, j, b, k, normal, friction):
    """Add a normal and a friction force (N) of joint j to the forces on its two particles."""
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


def update_velocities(S, j, b, k, h, normal, friction):
    """Change the velocities at t_n of the two particles of joint j by the effect of a change of its normal
    and friction force (N).
    """
    nx = S[j + CONTACT.nx]
    ny = S[j + CONTACT.ny]
    px = normal * nx + friction * ny
    py = friction * nx - normal * ny
    hk = h * S[k + PARTICLE.inverse_mass]
    hb = h * S[b + PARTICLE.inverse_mass]
    S[k + PARTICLE.vu] -= hk * px
    S[k + PARTICLE.vv] += hk * py
    S[k + PARTICLE.vw] += (
        h * S[k + PARTICLE.inverse_inertia] * (friction * S[j + CONTACT.jt] - normal * S[j + CONTACT.jn])
    )
    S[b + PARTICLE.vu] += hb * px
    S[b + PARTICLE.vv] -= hb * py
    S[b + PARTICLE.vw] -= (
        h * S[b + PARTICLE.inverse_inertia] * (friction * S[j + CONTACT.bt] - normal * S[j + CONTACT.bn])
    )


def approach_rate(S, j, b, k):
    """Return the rate of the penetration (m/s) from the velocities at t_n."""
    ru = S[k + PARTICLE.vu] - S[b + PARTICLE.vu]
    rv = S[k + PARTICLE.vv] - S[b + PARTICLE.vv]
    return (
        S[j + CONTACT.nx] * ru
        + S[j + CONTACT.ny] * rv
        + S[j + CONTACT.jn] * S[k + PARTICLE.vw]
        - S[j + CONTACT.bn] * S[b + PARTICLE.vw]
    )


def sliding_rate(S, j, b, k):
    """Return the sliding velocity along t (m/s) from the velocities at t_n, the journal's surface against
    the bearing's.
    """
    ru = S[k + PARTICLE.vu] - S[b + PARTICLE.vu]
    rv = S[k + PARTICLE.vv] - S[b + PARTICLE.vv]
    return (
        S[j + CONTACT.nx] * rv
        - S[j + CONTACT.ny] * ru
        + S[j + CONTACT.jt] * S[k + PARTICLE.vw]
        - S[j + CONTACT.bt] * S[b + PARTICLE.vw]
    )


def solve_simultaneous(S, I, h):
    """Solve the normal forces of contacts that may begin in the same step, by Jacobi's sweeps; the
    docstring of this file says why.
    """
    # First count the contacts that press on each body: its mobility is multiplied by that in force_change.
    for q in range(I[HEADER.jointed], I[HEADER.jointed_end]):
        S[I[q] + PARTICLE.touches] = 0.0
    for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
        if I[r + CONTACT_INDEX.simultaneous] != 0:
            touching = 1.0 if S[I[r + CONTACT_INDEX.row] + CONTACT.penetration] > 0.0 else 0.0
            S[I[r + CONTACT_INDEX.bearing] + PARTICLE.touches] += touching
            S[I[r + CONTACT_INDEX.journal] + PARTICLE.touches] += touching
    # All changes of a sweep follow from the velocities before it; only then are they applied.
    for _ in range(SWEEPS):
        for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
            if I[r + CONTACT_INDEX.simultaneous] != 0:
                force_change(
                    S, I[r + CONTACT_INDEX.row], I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal], h
                )
        for r in range(I[HEADER.contact], I[HEADER.contact_end], CONTACT_INDEX.SIZE):
            if I[r + CONTACT_INDEX.simultaneous] != 0:
                j = I[r + CONTACT_INDEX.row]
                apply_contact_force(
                    S,
                    j,
                    I[r + CONTACT_INDEX.bearing],
                    I[r + CONTACT_INDEX.journal],
                    S[j + CONTACT.change],
                    0.0,
                )
                update_velocities(
                    S,
                    j,
                    I[r + CONTACT_INDEX.bearing],
                    I[r + CONTACT_INDEX.journal],
                    h,
                    S[j + CONTACT.change],
                    0.0,
                )
                S[j + CONTACT.normal] += S[j + CONTACT.change]


def force_change(S, j, b, k, h):
    """Store the change of a contact's normal force (N) at the present velocities, with the mobility of each
    body multiplied by the number of contacts that press on it.
    """
    jn = S[j + CONTACT.jn]
    bn = S[j + CONTACT.bn]
    on_journal = S[k + PARTICLE.touches] * (
        S[k + PARTICLE.inverse_mass] + jn * jn * S[k + PARTICLE.inverse_inertia]
    )
    on_bearing = S[b + PARTICLE.touches] * (
        S[b + PARTICLE.inverse_mass] + bn * bn * S[b + PARTICLE.inverse_inertia]
    )
    g = h * (on_journal + on_bearing)
    former = S[j + CONTACT.normal]
    # The rate holds the former force already: g times it is added, so that the law is solved for the whole
    # force and not for its change.
    normal, _ = normal_force(
        S[j + CONTACT.elastic], S[j + CONTACT.damping_coefficient], approach_rate(S, j, b, k) + g * former, g
    )
    S[j + CONTACT.change] = normal - former
