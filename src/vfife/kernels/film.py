"""A film of oil between journal and bearing, which acts while the surfaces are apart, too, beside their
contact.

Forces of a film depend linearly on the velocities at t_n, with coefficients that its law gives at the present
place; so film and contact are solved together in closed form, the force along t eliminated first. Names as in
:mod:`~vfife.kernels.contact`.
"""

from typing import Any

from .arrays import CONTACT, PARTICLE

film_law: Any = None  # written by the compiler (compiler/trace/source.py) for the laws of a mechanism


def film_coefficients(S, contact, j, b, k):
    """Store a film's forces at rest and their dependence on the velocities at t_n, of which only the sense is
    taken beforehand.

    What runs into the film is e (w_J + w_B) - 2 v_t, v_t along t between the centres; friction has no arms in
    a joint with a film.
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
    """Normal force at rest (N) and damping coefficient (N s/m) of a joint with a film, its force along t
    eliminated from the two equations.

    F_N = radial + D_n v_n - X v_t and F_T = across + X v_n - D_t v_t, with v_t = slip + gt F_T; X^2 < D_n D_t
    keeps the damping positive.
    """
    share = 1.0 / (1.0 + gt * S[j + CONTACT.film_damping])
    cross = S[j + CONTACT.film_cross]
    push = (
        S[j + CONTACT.elastic]
        + S[j + CONTACT.film_radial]
        - cross * share * (slip + gt * S[j + CONTACT.film_across])
    )
    return push, S[j + CONTACT.damping_coefficient] - cross * cross * gt * share


def film_force(S, j, rate, slip, gt):
    """Force of the film along t (N) for the rate along n that was solved."""
    return (
        S[j + CONTACT.film_across] + S[j + CONTACT.film_cross] * rate - S[j + CONTACT.film_damping] * slip
    ) / (1.0 + gt * S[j + CONTACT.film_damping])
