"""Pieces of a step that every loop shares: coefficients of the central difference, work, what links do."""

from typing import NamedTuple


class Central(NamedTuple):
    """Coefficients of a step: v_n = p (v_(n-1/2) + h a), v_(n+1/2) = decay v_(n-1/2) + gain a; h and gain in
    s.
    """

    h: float
    decay: float
    gain: float
    p: float


def undamped(start, dt) -> Central:
    """Coefficients of a step without mass-proportional damping."""
    return Central(0.0 if start else 0.5 * dt, 1.0, 0.5 * dt if start else dt, 1.0)


def coefficients(start, dt, damping) -> Central:
    """Coefficients of a step with mass-proportional damping z = damping dt / 2.

    With c1 = 1/(1 + z), c2 = c1 (1 - z) this is d_(n+1) = c1 dt^2 a + 2 c1 d_n - c2 d_(n-1), which is Eq. 5
    for z = 0. The first step starts from v_0 itself: d_(-1) = d_0 - dt v_0 + dt^2 a_0 / 2.
    """
    z = 0.5 * dt * damping
    c1 = 1.0 / (1.0 + z)
    h = 0.0 if start else 0.5 * dt
    decay = 1.0 - z if start else c1 * (1.0 - z)
    gain = 0.5 * dt if start else dt * c1
    p = 1.0 if start else c1
    return Central(h, decay, gain, p)


def resized(u, a, old, size, damping):
    """Velocity half a step after t_n where the next step is ``size`` and not ``old`` long, from the one that
    was, u, and the acceleration at t_n.

    Both come from the same v_n: v_(n+1/2) = (1 - z) v_n + h/2 a_n, z = damping h / 2 for a step of h.
    """
    return (u - 0.5 * old * a) * ((1.0 - 0.5 * size * damping) / (1.0 - 0.5 * old * damping)) + 0.5 * size * a


def larger(a, b):
    """The larger of two numbers, the first where they compare equal or the second is no number."""
    return b if b > a else a


def chord_acceleration(dx, dy, ax, ay, inverse):
    """Angular acceleration (rad/s^2) of a link's chord: its ends' relative acceleration across the chord,
    over the length.
    """
    return (dx * ay - dy * ax) * inverse * inverse
