"""Oil film between journal and bearing: it acts in free flight and adds to the contact force in contact.

The force of a film is linear in the velocities at t_n. Its law provides the coefficients at the present
eccentricity. Film and contact therefore have one closed-form solution: the force along t is eliminated, and
what remains is the scalar equation of a dry contact. Names as in :mod:`~vfife.kernels.contact`.
"""

from typing import Any

from .arrays import CONTACT, PARTICLE

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
    radial, across, damping, along, cross = film_law(
        contact, S[j + CONTACT.penetration], turning, sense, S, j + CONTACT.slots
    )
    S[j + CONTACT.film_radial] = radial
    S[j + CONTACT.film_across] = across
    S[j + CONTACT.damping_coefficient] += damping
    S[j + CONTACT.film_damping] = along
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
