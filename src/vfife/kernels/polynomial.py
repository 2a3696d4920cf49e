"""Functions of time as piecewise polynomials: a ramp is one exactly, a table becomes one by a spline.

Layout of a table: number of pieces, then their start times, then seven coefficients each (constant first,
time counted from the piece's start), then for each piece the number of kinks up to its begin. A negative
number of pieces says that the function repeats itself; its period and the number of kinks in it follow,
before the start times, which lie in [0, period).
"""

from .elementary import nearest


def polynomial(table, start, time):
    """Value, first two derivatives and the number of kinks before ``time``; the first piece goes on before
    its start and the last for ever.
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
    value = 0.0
    rate = 0.0
    half = 0.0
    for k in range(6, -1, -1):
        half = half * x + rate
        rate = rate * x + value
        value = value * x + table[c + k]
    return value, rate, 2.0 * half, kinks + table[first + 8 * pieces + low]
