"""Wear: what rubs where, by Archard's law, and the shape of surfaces that are worn.

The volume that a surface loses is its coefficient times the normal force times the sliding distance (Archard
1953). A step keeps that product and the direction between the centres in which it was done; what is made of
it where is said by the analysis, output by output.

A worn surface is round no more: where the centres lie e apart, n pointing at angle psi, the penetration is

    delta = e - c - h_B(psi - theta_B) - h_J(psi - theta_J)

with the depths h of bearing and journal there, each a sum of cosines and sines. The force is F grad(delta):
it leans from n by the slope of the profiles and turns the bodies by it, so that what a contact without
damping and friction takes it gives back, to the last of it.
"""

import math

from .arrays import CONTACT, CONTACT_INDEX, HARMONIC, PARTICLE, WEAR
from .central_difference import larger


def profile(S, first, count, body, nx, ny):
    """Depth (m) of a worn profile of a body in the direction n, and its derivative by the angle (m/rad); the
    profile turns with the body.
    """
    c_body = S[body + PARTICLE.c]
    s_body = S[body + PARTICLE.s]
    c = c_body * nx + s_body * ny
    s = c_body * ny - s_body * nx
    depth = S[first + HARMONIC.cosine]
    slope = 0.0
    c_order = c  # cosine and sine of as many times the angle
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
    """Penetration, normal, and levers of the profiles on bearing and journal of contact r, which was met as
    if it were round.

    The normal is of length one; ``stretch`` is that of grad(delta), by which the law's force is larger and
    its rate faster than along n. The slope counts on half the clearance at the least, where nothing touches.
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
    """Adds what contact j rubs in a step to record w: force times distance, and the same by direction."""
    rubbed = span * (S[j + CONTACT.normal_force] * abs(slip))
    S[w + WEAR.work] += rubbed
    S[w + WEAR.x] += rubbed * S[w + WEAR.nx]
    S[w + WEAR.y] += rubbed * S[w + WEAR.ny]
