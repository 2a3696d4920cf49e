"""Gauss' elimination with partial pivoting; of pivots of one size the first counts."""


def eliminate(A, B, signs, count, size, columns):
    """Solves A X = B in place for ``count`` matrices (size, size) and right sides (size, columns).

    ``signs`` (count) are those of the determinants: 0 where a column has no pivot, and B is then not solved.
    """
    for m in range(count):
        o = m * size * size
        p = m * size * columns
        signs[m] = triangle(A, B, o, p, size, columns)
        if signs[m] != 0.0:
            substitute(A, B, o, p, size, columns)


def triangle(A, B, o, p, size, columns):
    """Upper triangle of a matrix at ``o``, the right sides at ``p`` changed along; returned: the sign of the determinant."""
    sign = 1.0
    for k in range(size):
        row = k
        largest = abs(A[o + k * size + k])
        for i in range(k + 1, size):
            if abs(A[o + i * size + k]) > largest:
                largest = abs(A[o + i * size + k])
                row = i
        if not largest > 0.0:
            return 0.0
        if row != k:
            exchange(A, o + k * size, o + row * size, size)
            exchange(B, p + k * columns, p + row * columns, columns)
            sign = -sign
        pivot = A[o + k * size + k]
        sign = -sign if pivot < 0.0 else sign
        for i in range(k + 1, size):
            factor = A[o + i * size + k] / pivot
            if factor != 0.0:
                for j in range(k + 1, size):
                    A[o + i * size + j] -= factor * A[o + k * size + j]
                for j in range(columns):
                    B[p + i * columns + j] -= factor * B[p + k * columns + j]
    return sign


def exchange(A, first, second, count):
    """Exchanges numbers that lie behind two places."""
    for j in range(count):
        held = A[first + j]
        A[first + j] = A[second + j]
        A[second + j] = held


def substitute(A, B, o, p, size, columns):
    """Solves with an upper triangle, from its last row on."""
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            factor = A[o + i * size + k]
            for j in range(columns):
                B[p + i * columns + j] -= factor * B[p + k * columns + j]
        for j in range(columns):
            B[p + i * columns + j] = B[p + i * columns + j] / A[o + i * size + i]
