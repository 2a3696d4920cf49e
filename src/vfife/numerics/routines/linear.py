"""Products, elimination and factors of matrices.

Products of dense matrices row by row, each sum in the order of its terms.

Gauss' elimination with partial pivoting; of pivots of one size the first counts.

Factors L D L^T of symmetric matrices whose entries lie near the diagonal, row by row from the first entry
that is not zero (skyline).
"""


def multiply(A, B, C, count, a, b, c, rows, inner, columns):
    """C = A B for ``count`` pairs of matrices (rows, inner) and (inner, columns), which lie ``a``, ``b`` and
    ``c`` numbers apart.
    """
    for m in range(count):
        for i in range(rows):
            at = m * c + i * columns
            for j in range(columns):
                C[at + j] = 0.0
            for k in range(inner):
                factor = A[m * a + i * inner + k]
                place = m * b + k * columns
                for j in range(columns):
                    C[at + j] += factor * B[place + j]


def multiply_vectors(A, x, y, count, a, b, rows, columns):
    """y = A x for ``count`` matrices (rows, columns) and vectors, which lie ``a`` and ``b`` numbers apart."""
    for m in range(count):
        for i in range(rows):
            total = 0.0
            for k in range(columns):
                total += A[m * a + i * columns + k] * x[m * b + k]
            y[m * rows + i] = total


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
    """Upper triangle of a matrix at ``o``, the right sides at ``p`` changed along; returned: the sign of the
    determinant.
    """
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


def factorise(A, start, first, size, least):
    """Factors in place. Row i has its entries from column ``first[i]`` to the diagonal, in A up to
    ``start[i]``, the diagonal's place.

    Pivots below ``least`` are taken as that: a matrix to which so much was added has none in exact
    arithmetic.
    """
    for i in range(size):
        here = int(start[i]) - i  # column 0 would lie here
        begin = int(first[i])
        for j in range(begin, i):
            there = int(start[j]) - j
            total = A[here + j]
            low = begin if begin > int(first[j]) else int(first[j])
            for k in range(low, j):
                total -= A[here + k] * A[there + k]
            A[here + j] = total
        pivot = A[here + i]
        for j in range(begin, i):
            factor = A[here + j] / A[int(start[j])]
            pivot -= factor * A[here + j]
            A[here + j] = factor
        A[here + i] = pivot if pivot > least else least


def substitute_back(A, start, first, x, size):
    """Solves with the factors, in place."""
    for i in range(size):
        here = int(start[i]) - i
        total = x[i]
        for j in range(int(first[i]), i):
            total -= A[here + j] * x[j]
        x[i] = total
    for i in range(size):
        x[i] = x[i] / A[int(start[i])]
    for i in range(size - 1, -1, -1):
        here = int(start[i]) - i
        for j in range(int(first[i]), i):
            x[j] -= A[here + j] * x[i]
