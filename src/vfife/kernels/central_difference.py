"""Coefficients of the central difference, with and without mass-proportional damping, and the change of the
step size.
"""

from typing import NamedTuple


class Central(NamedTuple):
    """Coefficients of a step: v_n = p (v_(n-1/2) + h a) and v_(n+1/2) = decay v_(n-1/2) + gain a, with h and
    gain in s. In step 0 the velocity is that of t_0 itself: h is 0 and gain half a step.
    """

    h: float
    decay: float
    gain: float
    p: float


def undamped(start, dt) -> Central:
    """Return the coefficients of a step of ``dt`` (s) without mass-proportional damping."""
    return Central(0.0 if start else 0.5 * dt, 1.0, 0.5 * dt if start else dt, 1.0)


def coefficients(start, dt, damping) -> Central:
    """Return the coefficients of a step of ``dt`` (s) with mass-proportional ``damping`` (1/s).

    With z = damping dt / 2, c1 = 1/(1 + z) and c2 = c1 (1 - z) they are equivalent to
    d_(n+1) = c1 dt^2 a + 2 c1 d_n - c2 d_(n-1), which is Eq. 5 for z = 0. The first step starts from v_0:
    d_(-1) = d_0 - dt v_0 + dt^2 a_0 / 2.
    """
    z = 0.5 * dt * damping
    c1 = 1.0 / (1.0 + z)
    h = 0.0 if start else 0.5 * dt
    decay = 1.0 - z if start else c1 * (1.0 - z)
    gain = 0.5 * dt if start else dt * c1
    p = 1.0 if start else c1
    return Central(h, decay, gain, p)


def resized(u, a, old, size, damping):
    """Return the velocity half a step after t_n for the next step ``size`` (s), from that for the step
    ``old``, u, and the acceleration a at t_n.

    Both follow from the same v_n: v_(n+1/2) = (1 - z) v_n + h/2 a_n, with z = damping h / 2 for a step h.
    """
    return (u - 0.5 * old * a) * ((1.0 - 0.5 * size * damping) / (1.0 - 0.5 * old * damping)) + 0.5 * size * a


def larger(a, b):
    """Return the larger of two numbers; the first if they are equal or the second is NaN."""
    return b if b > a else a


def chord_acceleration(dx, dy, ax, ay, inverse):
    """Return the angular acceleration (rad/s^2) of a link's chord: the relative acceleration of its ends
    across the chord, divided by its length.
    """
    return (dx * ay - dy * ax) * inverse * inverse
