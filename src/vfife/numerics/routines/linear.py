"""Products, elimination and factors of matrices.

Products of dense matrices row by row, each sum in the order of its terms.

Gauss' elimination with partial pivoting; of pivots of one size the first counts.

Factors L D L^T of symmetric matrices whose entries lie near the diagonal, row by row from the first entry
that is not zero (skyline).
"""


def multiply(A, B, C):
    """C = A B for matrices (count, rows, inner), (count, inner, columns); a single A or B counts for all of
    C.
    """
    for m in range(C.shape[0]):
        a = m if A.shape[0] > 1 else 0
        b = m if B.shape[0] > 1 else 0
        for i in range(A.shape[1]):
            for j in range(B.shape[2]):
                C[m, i, j] = 0.0
            for k in range(A.shape[2]):
                factor = A[a, i, k]
                for j in range(B.shape[2]):
                    C[m, i, j] += factor * B[b, k, j]


def multiply_vectors(A, x, y):
    """y = A x for matrices (count, rows, columns) and vectors (count, columns); a single A or x counts for
    all of y.
    """
    for m in range(y.shape[0]):
        a = m if A.shape[0] > 1 else 0
        b = m if x.shape[0] > 1 else 0
        for i in range(A.shape[1]):
            total = 0.0
            for k in range(A.shape[2]):
                total += A[a, i, k] * x[b, k]
            y[m, i] = total


def eliminate(A, B, signs):
    """Solve A X = B in place for matrices (count, size, size) and right sides (count, size, columns).

    ``signs`` (count) are those of the determinants: 0 where a column has no pivot, and B is then not solved.
    """
    for m in range(A.shape[0]):
        signs[m] = triangle(A, B, m)
        if signs[m] != 0.0:
            substitute(A, B, m)


def triangle(A, B, m):
    """Bring matrix m to an upper triangle, its right sides along; return the sign of the determinant.

    The pivot of a column is its largest entry, of several the first.
    """
    size = A.shape[1]
    sign = 1.0
    for k in range(size):
        row = k
        largest = abs(A[m, k, k])
        for i in range(k + 1, size):
            if abs(A[m, i, k]) > largest:
                largest = abs(A[m, i, k])
                row = i
        if not largest > 0.0:
            return 0.0
        if row != k:
            exchange(A, m, k, row)
            exchange(B, m, k, row)
            sign = -sign
        pivot = A[m, k, k]
        sign = -sign if pivot < 0.0 else sign
        for i in range(k + 1, size):
            factor = A[m, i, k] / pivot
            if factor != 0.0:
                for j in range(k + 1, size):
                    A[m, i, j] -= factor * A[m, k, j]
                for j in range(B.shape[2]):
                    B[m, i, j] -= factor * B[m, k, j]
    return sign


def exchange(A, m, first, second):
    """Exchange two rows of matrix m."""
    for j in range(A.shape[2]):
        former = A[m, first, j]
        A[m, first, j] = A[m, second, j]
        A[m, second, j] = former


def substitute(A, B, m):
    """Solve with the upper triangle of matrix m, from its last row on."""
    size = A.shape[1]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            factor = A[m, i, k]
            for j in range(B.shape[2]):
                B[m, i, j] -= factor * B[m, k, j]
        for j in range(B.shape[2]):
            B[m, i, j] = B[m, i, j] / A[m, i, i]


def factorise(A, start, first, size, least):
    """Factors in place.

    Row i has its entries from column ``first[i]`` to the diagonal, in A up to ``start[i]``, the diagonal's
    place.

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
