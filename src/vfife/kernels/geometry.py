"""Revolute joints: where the two centres are, how the journal meets the bearing, and the force that answers (paper Eq. 14-31).

Both bodies of a joint are particles with mass and inertia; on a rigid body the centre sits on an arm, on an elastic link the arm is zero.
n points from the bearing centre to the journal centre, t is n turned anticlockwise. Forces are those on the journal: -F_N n + F_T t.
"""

import math


def arm(c, s, px, py):
    """A point (px, py) of the body's frame, seen from the particle, in the global frame (m)."""
    return c * px - s * py, s * px + c * py


def eccentricity(ex, ey, clearance):
    """Signed penetration e - c (m) and the normal, Eq. 20-24; the normal of two coincident centres is zero."""
    e = math.sqrt(ex * ex + ey * ey)
    inverse = 1.0 / (e + 1e-300)
    return e - clearance, ex * inverse, ey * inverse


def onset_speed(penetration, before, rate, dt):
    """Penetration rate (m/s) at the sign change of the penetration (Eq. 29), located inside the step.

    The parabola through the penetration before, the penetration now and the rate now crosses zero with the speed
    sqrt(rate^2 - 2 b penetration), b its curvature. Second order, where the chord of Eq. 30 is first; the rate at the end of the step, which
    a plain loop takes, is what leads a near-grazing impact to the wrong branch.
    """
    curvature = 2.0 * (rate - (penetration - before) / dt) / dt
    square = rate * rate - 2.0 * curvature * penetration
    return math.sqrt(square if square > 0.0 else 0.0)


def seldom(condition):
    """Marks a branch that is taken in few steps: straight-line code leaves it out and hands such a step to the data-driven loop."""
    return condition


def normal_force(elastic, damping, rate, mobility):
    """F_N (N) and penetration rate (m/s) at step n, solved together: F = elastic + damping r, r = rate - mobility F.

    ``rate`` is the rate without this force, ``mobility`` (m/s/N) half a step times the joint's inverse mass. Never attractive.
    """
    solved = (rate - mobility * elastic) / (1.0 + mobility * damping)
    force = elastic + damping * solved
    pushes = force > 0.0
    return force if pushes else 0.0, solved if pushes else rate


def coupling(im, ii, rix, riy, rkx, rky):
    """Velocity at arm i for a unit force at arm k of the same body: entries xx, xy, yx, yy of its 2 x 2 block (1/kg)."""
    return im + ii * riy * rky, -ii * riy * rkx, -ii * rix * rky, im + ii * rix * rkx
