"""Functions of time as piecewise polynomials: a ramp is one exactly, a table becomes one by a spline.

Layout of a table: number of pieces, then their start times, then seven coefficients each (constant first, time counted from the piece's start).
"""


def polynomial(table, start, time):
    """Value and first two derivatives at ``time``; the first piece holds before its start and the last goes on for ever."""
    pieces = int(table[start])
    low = 0
    high = pieces - 1
    while low < high:
        middle = (low + high + 1) // 2
        if table[start + 1 + middle] <= time:
            low = middle
        else:
            high = middle - 1
    x = time - table[start + 1 + low]
    c = start + 1 + pieces + 7 * low
    value = 0.0
    rate = 0.0
    half = 0.0
    for k in range(6, -1, -1):
        half = half * x + rate
        rate = rate * x + value
        value = value * x + table[c + k]
    return value, rate, 2.0 * half
