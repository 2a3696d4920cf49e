"""Elementary functions of arrays, number by number."""

from ...kernels.elementary import sincos
from .functions import exponential, half_turn, logarithm, raised


def turn_all(angle, sine, cosine):
    """Sines and cosines of angles below 1e6 rad."""
    for k in range(len(angle)):
        sine[k], cosine[k] = sincos(angle[k])


def raise_all(x, exponent, found):
    """Powers of positive numbers."""
    for k in range(len(x)):
        found[k] = raised(x[k], exponent[k])


def exponentials(x, found):
    """e**x."""
    for k in range(len(x)):
        found[k] = exponential(x[k])


def logarithms(x, found):
    """Natural logarithms of positive numbers."""
    for k in range(len(x)):
        found[k] = logarithm(x[k])


def directions_of(y, x, found):
    """Angles of directions (x, y), y other than zero."""
    for k in range(len(x)):
        angle = half_turn(abs(y[k]), x[k])
        found[k] = -angle if y[k] < 0.0 else angle
