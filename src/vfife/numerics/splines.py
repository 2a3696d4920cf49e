"""Cubic pieces through points: natural and periodic splines, and monotone cubics; coefficients from each
place on, constant first.
"""

from collections.abc import Sequence

Places = Sequence[float]
Row = tuple[float, float, float, float]


def natural(places: Places, values: Places) -> list[Row]:
    """Return the cubic spline without curvature at its ends."""
    h, slopes = _steps(places, values)
    inner = len(h) - 1
    curvature = _tridiagonal(
        [2.0 * (h[k] + h[k + 1]) for k in range(inner)],
        h[1:inner],
        [6.0 * (slopes[k + 1] - slopes[k]) for k in range(inner)],
    )
    return _rows(values, h, slopes, [0.0, *curvature, 0.0])


def periodic(places: Places, values: Places) -> list[Row]:
    """Return the cubic spline whose ends meet with the same slope and curvature; the last value is replaced
    by the first.

    The matrix is tridiagonal except for its corners, which a correction of rank one removes (Sherman and
    Morrison 1950).
    """
    closed = [*values[:-1], values[0]]
    h, slopes = _steps(places, closed)
    n = len(h)
    right = [6.0 * (slopes[k] - slopes[k - 1]) for k in range(n)]
    diagonal = [2.0 * (h[k - 1] + h[k]) for k in range(n)]
    if n == 1:
        return _rows(closed, h, slopes, [0.0, 0.0])
    if n == 2:  # both entries beside the diagonal lie in one place
        off_diagonal = h[0] + h[1]
        scale = diagonal[0] * diagonal[1] - off_diagonal * off_diagonal
        first, second = (
            (right[0] * diagonal[1] - right[1] * off_diagonal) / scale,
            (right[1] * diagonal[0] - right[0] * off_diagonal) / scale,
        )
        return _rows(closed, h, slopes, [first, second, first])
    corner = h[n - 1]
    ends = [diagonal[0] + corner, *diagonal[1 : n - 1], diagonal[n - 1] + corner]
    plain = _tridiagonal(ends, h[: n - 1], right)
    turn = _tridiagonal(ends, h[: n - 1], [-corner, *[0.0] * (n - 2), corner])
    share = (plain[0] - plain[-1]) / (1.0 + (turn[0] - turn[-1]))
    curvature = [a - share * b for a, b in zip(plain, turn, strict=True)]
    return _rows(closed, h, slopes, [*curvature, curvature[0]])


def monotone(places: Places, values: Places) -> list[Row]:
    """Cubics that rise only where the values do (Fritsch and Carlson 1980), with slopes after Fritsch and
    Butland (1984).
    """
    h, slopes = _steps(places, values)
    if len(h) == 1:
        return [(float(values[0]), slopes[0], 0.0, 0.0)]
    rates = [_end(h[0], h[1], slopes[0], slopes[1])]
    for k in range(1, len(h)):
        left, right = slopes[k - 1], slopes[k]
        if (left > 0.0 and right > 0.0) or (left < 0.0 and right < 0.0):
            first, second = 2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]
            rates.append((first + second) / (first / left + second / right))
        else:
            rates.append(0.0)
    rates.append(_end(h[-1], h[-2], slopes[-1], slopes[-2]))
    rows = []
    for k in range(len(h)):
        bend = (rates[k] + rates[k + 1] - 2.0 * slopes[k]) / h[k]
        rows.append((float(values[k]), rates[k], (slopes[k] - rates[k]) / h[k] - bend, bend / h[k]))
    return rows


def value_at(starts: Places, rows: Sequence[Row], x: float) -> float:
    """Value of such pieces at a place; beyond the ends the first and the last piece go on."""
    low, high = 0, len(rows) - 1
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if x >= starts[middle] else (low, middle - 1)
    a, b, c, d = rows[low]
    t = x - starts[low]
    return a + t * (b + t * (c + t * d))


def _steps(places: Places, values: Places) -> tuple[list[float], list[float]]:
    """Distances from place to place, and slopes."""
    h = [float(b) - float(a) for a, b in zip(places, places[1:], strict=False)]
    return h, [(float(b) - float(a)) / step for a, b, step in zip(values, values[1:], h, strict=False)]


def _end(step: float, next_step: float, slope: float, next_slope: float) -> float:
    """Slope at an end from three points, held to what keeps the piece monotone."""
    rate = ((2.0 * step + next_step) * slope - step * next_slope) / (step + next_step)
    if rate * slope <= 0.0:
        return 0.0
    return 3.0 * slope if slope * next_slope <= 0.0 and abs(rate) > 3.0 * abs(slope) else rate


def _tridiagonal(diagonal: Places, off_diagonal: Places, right: Places) -> list[float]:
    """Solution of a symmetric matrix of three diagonals, the middle one largest in each row."""
    pivots, sums = [*diagonal], [*right]
    for k in range(1, len(pivots)):
        factor = off_diagonal[k - 1] / pivots[k - 1]
        pivots[k] = pivots[k] - factor * off_diagonal[k - 1]
        sums[k] = sums[k] - factor * sums[k - 1]
    for k in range(len(pivots) - 1, -1, -1):
        next_term = off_diagonal[k] * sums[k + 1] if k < len(pivots) - 1 else 0.0
        sums[k] = (sums[k] - next_term) / pivots[k]
    return sums


def _rows(values: Places, h: Places, slopes: Places, curvature: Places) -> list[Row]:
    """Coefficients from values and second derivatives."""
    rows = []
    for k, step in enumerate(h):
        a, b = curvature[k], curvature[k + 1]
        rows.append(
            (float(values[k]), slopes[k] - step * (2.0 * a + b) / 6.0, 0.5 * a, (b - a) / (6.0 * step))
        )
    return rows
