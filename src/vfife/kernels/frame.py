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
    """Return the rotation (rad) from the direction (ca, sa) to (c, s): the series of the arcsine, with an
    error below 1e-13 up to 0.05 rad.
    """
    # z is the sine of the rotation; a difference of two angles would lose digits and need an arctangent.
    z = s * ca - c * sa
    q = z * z
    return z * (1.0 + q * (1.0 / 6.0 + q * (0.075 + q * (15.0 / 336.0))))


def step_turn(c, s, ca, sa):
    """Return the rotation (rad) like :func:`turn`, for the turn of a single step: one term less, with an
    error below 1e-15 up to 0.01 rad.
    """
    z = s * ca - c * sa
    q = z * z
    return z * (1.0 + q * (1.0 / 6.0 + q * 0.075))


def axial(length, la, ila, na, axial_stiffness):
    """Return the axial force (N), na + E A (l - l_a)/l_a: Eq. 12b with the length l for the printed I."""
    return na + axial_stiffness * ila * (length - la)


def bending(theta_1, theta_2, ila, m1a, m2a, bending_stiffness):
    """Return the end moments (N m) after the increments 2EI/l (2 theta_1 + theta_2) and
    2EI/l (theta_1 + 2 theta_2) of Eq. 12b.
    """
    unit = 2.0 * bending_stiffness * ila
    return m1a + unit * (2.0 * theta_1 + theta_2), m2a + unit * (theta_1 + 2.0 * theta_2)


def bending_released(theta, ila, ma, bending_stiffness):
    """Return the moment (N m) at the end that is not released, after the increment 3EI/l theta.

    3EI/l is the stiffness with the released rotation condensed out. The paper's rule, to set the moment of
    the released end in Eq. 12b to zero, would keep the stiffness 4EI/l of a clamped one.
    """
    return ma + 3.0 * bending_stiffness * ila * theta


def nodal_force(c, s, inverse, n, m1, m2):
    """Return the force (N) of the element on the particle at its first node; the second gets the opposite.

    The shear force -(m1 + m2)/l follows from Eq. 11.
    """
    q = (m1 + m2) * inverse
    return c * n + s * q, s * n - c * q


def stiffness(ila, inverse, axial_stiffness, bending_stiffness):
    """Return four stiffnesses of an element with both ends clamped: EA/l along, 12EI/l^3 across (N/m), and
    the moments 4EI/l at the end that turns and 2EI/l at the other (N m/rad).

    ``ila`` (1/m) is the inverse of the length to which the stiffness refers, ``inverse`` (1/m) that of the
    present length, which is two of the three factors l across.
    """
    direct, coupling = bending(1.0, 0.0, ila, 0.0, 0.0, bending_stiffness)
    m1, m2 = bending(inverse, inverse, ila, 0.0, 0.0, bending_stiffness)
    return axial(1.0, 0.0, ila, 0.0, axial_stiffness), (m1 + m2) * inverse, direct, coupling


def stiffness_released(ila, inverse, bending_stiffness):
    """Return two stiffnesses of an element with one end released: 3EI/l^3 across (N/m), and the moment 3EI/l
    at the other end when it turns (N m/rad).
    """
    return bending_released(inverse, ila, 0.0, bending_stiffness) * inverse, bending_released(
        1.0, ila, 0.0, bending_stiffness
    )


def end_rotations(m1, m2, ila, bending_stiffness):
    """Return the rotations (rad) of both ends under moments (N m) on them, the inverse of :func:`bending`:
    l/6EI (2 m1 - m2) and l/6EI (2 m2 - m1).
    """
    direct, coupling = bending(1.0, 0.0, ila, 0.0, 0.0, bending_stiffness)
    inverse = 1.0 / (direct * direct - coupling * coupling)
    return (direct * m1 - coupling * m2) * inverse, (direct * m2 - coupling * m1) * inverse
