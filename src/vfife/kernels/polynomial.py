"""Functions of one argument as piecewise polynomials of degree 6: a ramp is one exactly, a table becomes one
by a spline.

Layout of a table: number of pieces; their start times; seven coefficients each (constant first, time counted
from the piece's start); for each piece the number of kinks up to its begin. A negative number of pieces marks
a periodic function; its period and the number of kinks per period follow that number, and start times lie in
[0, period).
"""

from .elementary import nearest


def polynomial(table, start, time):
    """Return value, first two derivatives and the number of kinks before ``time`` (s, or the unit of another
    argument). The first piece also holds before its start, the last one without end.
    """
    pieces = int(table[start])
    first = start + 1
    kinks = 0.0
    if pieces < 0:
        pieces = -pieces
        period = table[first]
        turns = nearest(time / period - 0.5)
        time = time - turns * period
        kinks = turns * table[first + 1]
        first += 2
    # Bisection for the last piece that begins at ``time`` or before.
    low = 0
    high = pieces - 1
    while low < high:
        middle = (low + high + 1) // 2
        if table[first + middle] <= time:
            low = middle
        else:
            high = middle - 1
    x = time - table[first + low]
    c = first + pieces + 7 * low
    # Horner's scheme for the value, its derivative and half its second derivative in one pass.
    value = 0.0
    rate = 0.0
    half = 0.0
    for k in range(6, -1, -1):
        half = half * x + rate
        rate = rate * x + value
        value = value * x + table[c + k]
    return value, rate, 2.0 * half, kinks + table[first + 8 * pieces + low]
