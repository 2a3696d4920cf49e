"""Revolute joints: where the two centres are, how the journal meets the bearing, and the force that answers
(paper Eq. 14-31).

Both bodies of a joint are particles with mass and inertia; on a rigid body the centre sits on an arm, on an
elastic link the arm is zero. n points from the bearing centre to the journal centre, t is n turned
anticlockwise. Forces are those on the journal: -F_N n + F_T t.

Paths of pieces of constant curvature, straight or round, and how far a point is from one.

A piece begins at (x, y) along a unit vector t, with its normal n on its left, and bends to the left with a
curvature c. Of a point t . r along and n . r across from there, f = 2 n . r - c |r|^2 gives the signed
distance f/(1 + sqrt(1 - c f)), positive on the left: one formula for lines and arcs. A piece counts where the
foot of the point lies on it: past its begin and short of its end, where the path turns no corner. An arc
turns by 180 degrees at most, so that both are half planes. Where several pieces count, the nearest is taken.
"""

import math

from .arrays import PIECE

FAR = 1e300  # m


def arm(c, s, px, py):
    """A point (px, py) of the body's frame, seen from the particle, in the global frame (m)."""
    return c * px - s * py, s * px + c * py


def eccentricity(ex, ey, clearance):
    """Signed penetration e - c (m) and the normal, Eq. 20-24; that of coincident centres is zero."""
    e = math.sqrt(ex * ex + ey * ey)
    inverse = 1.0 / (e + 1e-300)
    return e - clearance, ex * inverse, ey * inverse


def onset_speed(penetration, before, rate, dt):
    """Penetration rate (m/s) at the sign change of the penetration (Eq. 29), located inside the step.

    The parabola through the penetration before, the penetration now and the rate now crosses zero with the
    speed sqrt(rate^2 - 2 b penetration), b its curvature. Second order, where the chord of Eq. 30 is first;
    the rate at the end of the step, which a plain loop takes, is what leads a near-grazing impact to the
    wrong branch.
    """
    curvature = 2.0 * (rate - (penetration - before) / dt) / dt
    square = rate * rate - 2.0 * curvature * penetration
    return math.sqrt(square if square > 0.0 else 0.0)


def unlikely(condition):
    """Mark a branch that few steps take: the fast step leaves it out and reports that the full step is needed
    (compiler/trace/straight_line.py).
    """
    return condition


def normal_force(elastic, damping, rate, mobility):
    """F_N (N) and penetration rate (m/s) at step n, solved together: F = elastic + damping r, r = rate -
    mobility F.

    ``rate`` is the rate without this force, ``mobility`` (m/s/N) half a step times the joint's inverse mass.
    Never attractive.
    """
    solved = (rate - mobility * elastic) / (1.0 + mobility * damping)
    force = elastic + damping * solved
    pushes = force > 0.0
    return force if pushes else 0.0, solved if pushes else rate


def from_piece(S, i, x, y):
    """Signed distance (m) of a point from the line or circle of a piece, the normal there, and whether the
    foot is on the piece.
    """
    c = S[i + PIECE.cosine]
    s = S[i + PIECE.sine]
    curvature = S[i + PIECE.curvature]
    rx = x - S[i + PIECE.x]
    ry = y - S[i + PIECE.y]
    along = c * rx + s * ry
    across = c * ry - s * rx
    f = 2.0 * across - curvature * (along * along + across * across)
    inside = 1.0 - curvature * f
    root = math.sqrt(inside if inside > 0.0 else 0.0)
    inverse = 1.0 / (root + 1e-300)
    nx, ny = arm(c, s, -curvature * along * inverse, (1.0 - curvature * across) * inverse)
    past = S[i + PIECE.opens] * along
    left = S[i + PIECE.end_cosine] * (x - S[i + PIECE.end_x]) + S[i + PIECE.end_sine] * (
        y - S[i + PIECE.end_y]
    )
    return f / (1.0 + root), nx, ny, past >= 0.0 and left <= 0.0


def from_path(S, first, count, x, y):
    """Signed distance (m) of a point from a path of ``count`` pieces, positive on its left, and the path's
    normal to the left at the foot.
    """
    distance, nx, ny, on = from_piece(S, first, x, y)
    if count > 1:
        nearest = abs(distance) if on else FAR
        for q in range(1, count):
            d, px, py, on = from_piece(S, first + PIECE.SIZE * q, x, y)
            near = on and abs(d) < nearest
            distance = d if near else distance
            nx = px if near else nx
            ny = py if near else ny
            nearest = abs(d) if near else nearest
    return distance, nx, ny


def in_slot(S, first, count, c, s, ex, ey):
    """Distance (m) of a pin from the middle of a slot and the direction of the nearer wall, in space; (c, s)
    is that of the slot's body.
    """
    away, px, py = from_path(S, first, count, c * ex + s * ey, c * ey - s * ex)
    side = 1.0 if away >= 0.0 else -1.0
    nx, ny = arm(c, s, side * px, side * py)
    return side * away, nx, ny
