"""Wear: the frictional contact work that Archard's law needs, and contact of worn surfaces.

The volume that a surface loses is a coefficient times the normal force times the sliding distance (Archard
1953). A step adds up that product and its direction; :mod:`vfife.tribology` turns it into depths, output by
output.

A worn surface is no longer round. If the centres are e apart and n points at the angle psi, the penetration
is

    delta = e - c - h_B(psi - theta_B) - h_J(psi - theta_J)

with the depths h of bearing and journal in that direction, each a sum of cosines and sines. The force is
F grad(delta): it is inclined against n by the slope of the profiles and has a moment about both centres.
Because it is the gradient of a potential, a contact without damping and friction conserves energy.
"""

import math

from .arrays import CONTACT, CONTACT_INDEX, HARMONIC, PARTICLE, WEAR
from .central_difference import larger


def profile(S, first, count, body, nx, ny):
    """Return the depth (m) of a worn profile in the direction n and its derivative by the angle (m/rad); the
    profile turns with ``body``.
    """
    c_body = S[body + PARTICLE.c]
    s_body = S[body + PARTICLE.s]
    c = c_body * nx + s_body * ny
    s = c_body * ny - s_body * nx
    # Cosine and sine of ``order`` times the angle, from those of the order before by the addition theorem.
    depth = S[first + HARMONIC.cosine]
    slope = 0.0
    c_order = c
    s_order = s
    for order in range(1, count):
        cosine = S[first + HARMONIC.SIZE * order + HARMONIC.cosine]
        sine = S[first + HARMONIC.SIZE * order + HARMONIC.sine]
        depth += cosine * c_order + sine * s_order
        slope += order * (sine * c_order - cosine * s_order)
        c_next = c_order * c - s_order * s
        s_order = s_order * c + c_order * s
        c_order = c_next
    return depth, slope


def profile_geometry(S, I, r, depth, nx, ny):
    """Return penetration (m), unit normal, levers of the profiles on bearing and journal (m), and stretch of
    contact r; ``depth`` (m) and n are those of round surfaces.

    The stretch is the length of grad(delta): the law's force and rate along the unit normal are larger by
    that factor. The slope is divided by at least half the clearance, which matters only in free flight.
    """
    w = I[r + CONTACT_INDEX.wear]
    size = S[I[r + CONTACT_INDEX.row] + CONTACT.size]
    inverse = 1.0 / larger(depth + size, 0.5 * size)
    on_bearing = 0.0
    on_journal = 0.0
    count = I[r + CONTACT_INDEX.bearing_count]
    if count != 0:
        bearing_depth, on_bearing = profile(
            S, I[r + CONTACT_INDEX.bearing_first], count, I[r + CONTACT_INDEX.bearing], nx, ny
        )
        depth -= bearing_depth
    count = I[r + CONTACT_INDEX.journal_count]
    if count != 0:
        journal_depth, on_journal = profile(
            S, I[r + CONTACT_INDEX.journal_first], count, I[r + CONTACT_INDEX.journal], nx, ny
        )
        depth -= journal_depth
        S[w + WEAR.journal] = journal_depth
    slope = inverse * (on_bearing + on_journal)
    stretch = math.sqrt(1.0 + slope * slope)
    share = 1.0 / stretch
    S[w + WEAR.stretch] = stretch
    return (
        depth,
        share * (nx + slope * ny),
        share * (ny - slope * nx),
        share * on_bearing,
        share * on_journal,
        stretch,
    )


def rub(S, w, j, span, slip):
    """Add normal force times sliding distance of contact j in this step (N m) to record w, as a sum and as a
    vector along the direction between the centres.
    """
    rubbed = span * (S[j + CONTACT.normal_force] * abs(slip))
    S[w + WEAR.work] += rubbed
    S[w + WEAR.x] += rubbed * S[w + WEAR.nx]
    S[w + WEAR.y] += rubbed * S[w + WEAR.ny]
