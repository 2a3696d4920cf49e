"""Products, elimination and factors of matrices.

Products of dense matrices row by row, each sum in the order of its terms.

Gauss' elimination with partial pivoting; of pivots of one size the first counts.

Factors L D L^T of symmetric matrices whose entries lie near the diagonal, row by row from the first entry
that is not zero (skyline).
"""


def multiply(A, B, C):
    """Write C = A B for matrices A (count, rows, inner) and B (count, inner, columns); a single A or B counts
    for all of C.

    The inner index is in the middle: an entry's terms are still added in their order, and the innermost loop
    goes along rows, where a compiler may work on several entries at once without changing a bit.
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
    """Write y = A x for matrices A (count, rows, columns) and vectors x (count, columns); a single A or x
    counts for all of y.
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

    ``signs`` (count) takes the signs of the determinants. It is 0 where a column has no pivot, and B then
    holds no solution.
    """
    for m in range(A.shape[0]):
        signs[m] = triangle(A, B, m)
        if signs[m] != 0.0:
            substitute(A, B, m)


def triangle(A, B, m):
    """Bring matrix m to an upper triangle, its right sides along; return the sign of the determinant.

    The pivot of a column is its largest entry, and of several equal ones the first. Entries below the
    diagonal are left as they were: nothing reads them afterwards.
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
        if not largest > 0.0:  # also where it is NaN
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


def factorise(A, start, first, size, smallest):
    """Factor a symmetric matrix of ``size`` rows as L D L^T, in place.

    Row i has its entries from column ``first[i]`` to the diagonal one behind the other in the array A; the
    diagonal is at ``start[i]``. L fills in only behind the first entry of a row, so that the factors need no
    room of their own.

    A pivot below ``smallest`` is replaced by ``smallest``: the caller added more than that to the diagonal,
    so in exact arithmetic there is no such pivot.
    """
    for i in range(size):
        offset = int(start[i]) - i  # column 0 would lie here
        begin = int(first[i])
        # First the row of L D, whose entry j needs the finished rows before i only. Division by the pivots
        # comes afterwards, because the sums of later entries of this row use the entries undivided.
        for j in range(begin, i):
            other_offset = int(start[j]) - j
            total = A[offset + j]
            low = begin if begin > int(first[j]) else int(first[j])
            for k in range(low, j):
                total -= A[offset + k] * A[other_offset + k]
            A[offset + j] = total
        pivot = A[offset + i]
        for j in range(begin, i):
            factor = A[offset + j] / A[int(start[j])]
            pivot -= factor * A[offset + j]
            A[offset + j] = factor
        A[offset + i] = pivot if pivot > smallest else smallest


def substitute_back(A, start, first, x, size):
    """Solve for x (size,), which holds the right side, in place: by L, then D, then L^T.

    L is stored by rows. For L^T, whose columns these are, each finished entry is therefore subtracted from
    those before it instead of being summed over.
    """
    for i in range(size):
        offset = int(start[i]) - i
        total = x[i]
        for j in range(int(first[i]), i):
            total -= A[offset + j] * x[j]
        x[i] = total
    for i in range(size):
        x[i] = x[i] / A[int(start[i])]
    for i in range(size - 1, -1, -1):
        offset = int(start[i]) - i
        for j in range(int(first[i]), i):
            x[j] -= A[offset + j] * x[i]
