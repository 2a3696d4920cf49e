"""Geometry of contact: eccentricity, impact speed, the normal force in closed form (paper Eq. 18-31), and the
distance of a point from a path.

Both bodies of a joint are particles with mass and inertia. On a rigid body the centre of a bearing or journal
sits on an arm; on an elastic link the arm is zero. n points from the bearing's centre to the journal's, t is
n turned anticlockwise, and the force on the journal is -F_N n + F_T t.

A piece begins at (x, y) along a unit vector t, with its normal n on its left, and bends to the left with a
curvature c. Of a point t . r along and n . r across from there, f = 2 n . r - c |r|^2 gives the signed
distance f/(1 + sqrt(1 - c f)), positive on the left: one formula for lines and arcs. A piece counts where the
foot of the point lies on it: past its begin and short of its end, where the path turns no corner. An arc
turns by 180 degrees at most, so that both are half planes. Where several pieces count, the nearest is taken.
"""

import math

from .arrays import PIECE

INFINITE = 1e300  # m: farther than any point of a path


def arm(c, s, px, py):
    """Return the point (px, py) of a body's frame (m) in global directions, seen from the body's particle;
    (c, s) are cosine and sine of its rotation.
    """
    return c * px - s * py, s * px + c * py


def eccentricity(ex, ey, clearance):
    """Return the signed penetration e - c (m) and the normal, Eq. 20-24; the normal of coincident centres is
    the zero vector.
    """
    # 1e-300 prevents 0/0 and changes no other quotient.
    e = math.sqrt(ex * ex + ey * ey)
    inverse = 1.0 / (e + 1e-300)
    return e - clearance, ex * inverse, ey * inverse


def onset_speed(penetration, last_penetration, rate, dt):
    """Return the penetration rate (m/s) where the penetration passes zero (Eq. 29), inside the step ``dt``.

    A parabola through the last penetration, the present one and the present rate passes zero with the speed
    sqrt(rate^2 - 2 b penetration), where b is its second derivative. The error is of second order; that of
    the chord of Eq. 30 is of first order. The rate at the end of the step would put near-grazing impacts on
    a wrong branch of the motion, whatever the step.
    """
    curvature = 2.0 * (rate - (penetration - last_penetration) / dt) / dt
    square = rate * rate - 2.0 * curvature * penetration
    return math.sqrt(square if square > 0.0 else 0.0)


def unlikely(condition):
    """Return the condition unchanged; mark it for the tracer as the test of a branch that few steps take.

    The fast step leaves such a branch out and reports where it would be needed
    (compiler/trace/straight_line.py).
    """
    return condition


def normal_force(elastic, damping, rate, mobility):
    """Return the normal force F_N (N) and the penetration rate r (m/s) at t_n, solved together from
    F = elastic + damping r and r = rate - mobility F.

    ``rate`` (m/s) is the rate without this force, ``mobility`` (m/s/N) half a step times the joint's inverse
    mass. An attractive force is replaced by zero, as the law of Eq. 25 is meant for surfaces that push.
    """
    # Rate first, then force: the denominator is at least 1, so that no damping is too stiff for the step.
    solved = (rate - mobility * elastic) / (1.0 + mobility * damping)
    force = elastic + damping * solved
    pushes = force > 0.0
    return force if pushes else 0.0, solved if pushes else rate


def from_piece(S, i, x, y):
    """Return the signed distance (m) of the point (x, y) from the line or circle of a piece, the normal
    there, and whether the foot of the point lies on the piece.
    """
    c = S[i + PIECE.cosine]
    s = S[i + PIECE.sine]
    curvature = S[i + PIECE.curvature]
    rx = x - S[i + PIECE.x]
    ry = y - S[i + PIECE.y]
    rt = c * rx + s * ry
    rn = c * ry - s * rx
    f = 2.0 * rn - curvature * (rt * rt + rn * rn)
    inside = 1.0 - curvature * f
    root = math.sqrt(inside if inside > 0.0 else 0.0)
    inverse = 1.0 / (root + 1e-300)
    nx, ny = arm(c, s, -curvature * rt * inverse, (1.0 - curvature * rn) * inverse)
    past = S[i + PIECE.opens] * rt
    left = S[i + PIECE.end_cosine] * (x - S[i + PIECE.end_x]) + S[i + PIECE.end_sine] * (
        y - S[i + PIECE.end_y]
    )
    return f / (1.0 + root), nx, ny, past >= 0.0 and left <= 0.0


def from_path(S, first, count, x, y):
    """Return the signed distance (m) of the point (x, y) from a path of ``count`` pieces, positive on its
    left, and the path's normal to the left at the foot of the point.
    """
    # Selects instead of branches: lanes may be on different pieces. If no foot lies on its piece, the first
    # piece counts.
    distance, nx, ny, on = from_piece(S, first, x, y)
    if count > 1:
        nearest = abs(distance) if on else INFINITE
        for q in range(1, count):
            d, px, py, on = from_piece(S, first + PIECE.SIZE * q, x, y)
            nearer = on and abs(d) < nearest
            distance = d if nearer else distance
            nx = px if nearer else nx
            ny = py if nearer else ny
            nearest = abs(d) if nearer else nearest
    return distance, nx, ny


def in_slot(S, first, count, c, s, ex, ey):
    """Return the distance (m) of a pin from the middle of a slot and the direction to the nearer wall, in
    space; (c, s) are the direction cosines of the slot's body, (ex, ey) the pin seen from its origin (m).
    """
    away, px, py = from_path(S, first, count, c * ex + s * ey, c * ey - s * ex)
    side = 1.0 if away >= 0.0 else -1.0
    nx, ny = arm(c, s, side * px, side * py)
    return side * away, nx, ny
