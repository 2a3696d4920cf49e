"""Internal force of the plane frame element by the fictitious reversed rigid-body motion (Ting, Shih and Wang
2004; paper Eq. 6-13).

Within a path unit the element is turned back from its present direction to that at the start of the unit;
what is left is the axial deformation and two end rotations, and their force increments are added to the
forces at the start of the unit.
"""

import math


def chord(dx, dy):
    """Length (m), inverse length (1/m) and direction cosines from the first node to the second."""
    length = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / length
    return length, inverse, dx * inverse, dy * inverse


def turn(c, s, ca, sa):
    """Rotation (rad) of the direction (c, s) from (ca, sa): odd series of the arcsine, error below 1e-13 up
    to 0.05 rad.
    """
    z = s * ca - c * sa
    q = z * z
    return z * (1.0 + q * (1.0 / 6.0 + q * (0.075 + q * (15.0 / 336.0))))


def step_turn(c, s, ca, sa):
    """The same for the turn of one step: error below 1e-15 up to 0.01 rad."""
    z = s * ca - c * sa
    q = z * z
    return z * (1.0 + q * (1.0 / 6.0 + q * 0.075))


def axial(length, la, ila, na, axial_stiffness):
    """Axial force (N): na + E A (l - l_a)/l_a, Eq. 12b with l where the print has I."""
    return na + axial_stiffness * ila * (length - la)


def bending(theta_1, theta_2, ila, m1a, m2a, bending_stiffness):
    """End moments (N m): increments 2EI/l (2 theta_1 + theta_2) and 2EI/l (theta_1 + 2 theta_2), Eq. 12b."""
    unit = 2.0 * bending_stiffness * ila
    return m1a + unit * (2.0 * theta_1 + theta_2), m2a + unit * (theta_1 + 2.0 * theta_2)


def bending_released(theta, ila, ma, bending_stiffness):
    """Moment at the end that is not released: increment 3EI/l theta (condensed stiffness, not Eq.

    12b with a zero struck in).
    """
    return ma + 3.0 * bending_stiffness * ila * theta


def nodal_force(c, s, inverse, n, m1, m2):
    """Force (N) of the element on the particle at its first node; the second takes the opposite.

    Shear from Eq. 11: -(m1 + m2)/l.
    """
    q = (m1 + m2) * inverse
    return c * n + s * q, s * n - c * q


def stiffness(ila, inverse, axial_stiffness, bending_stiffness):
    """Of the element with both ends held: along EA/l, across 12EI/l^3 (N/m), moment at an end for its turn
    4EI/l, for the other's 2EI/l (N m).

    ``ila``: inverse of the length that stiffness counts on, ``inverse`` of the present one, on which two of
    the three l across do.
    """
    near, far = bending(1.0, 0.0, ila, 0.0, 0.0, bending_stiffness)
    m1, m2 = bending(inverse, inverse, ila, 0.0, 0.0, bending_stiffness)
    return axial(1.0, 0.0, ila, 0.0, axial_stiffness), (m1 + m2) * inverse, near, far


def stiffness_released(ila, inverse, bending_stiffness):
    """One end released: across (N/m) 3EI/l^3, and moment at the other end for its own turn 3EI/l (N m)."""
    return bending_released(inverse, ila, 0.0, bending_stiffness) * inverse, bending_released(
        1.0, ila, 0.0, bending_stiffness
    )


def end_rotations(m1, m2, ila, bending_stiffness):
    """Rotations (rad) of both ends under moments (N m) on them, ``bending`` solved for them: l/6EI (2 m1 -
    m2) and l/6EI (2 m2 - m1).
    """
    near, far = bending(1.0, 0.0, ila, 0.0, 0.0, bending_stiffness)
    inverse = 1.0 / (near * near - far * far)
    return (near * m1 - far * m2) * inverse, (near * m2 - far * m1) * inverse
