"""Singular values and vectors: QR factors, then Jacobi's rotations of the rows of R until they are
orthogonal.

One-sided rotations in a fixed order of pairs (Hestenes, Journal of the SIAM 6 (1958) 51-90), on the triangle
of a QR factorisation with column pivoting, which leaves them little to do and gives small singular values
with high relative accuracy (Drmac and Veselic, SIAM Journal on Matrix Analysis and Applications 29 (2008)
1322-1362).

QR factors by Householder's reflections, with the largest remaining column first where asked.

A matrix is held by its columns: row j of W is column j. A reflection I - t v v^T keeps v behind its first
entry, 1, in place of what it removed.
"""

import math

# Largest cosine between two rows that count as orthogonal, over the root of their length: some roundings of
# their product.
ORTHOGONAL = 2.2e-16
# Rows shorter than this part of the longest are rounding; their directions are chosen orthogonal to the
# others.
NOTHING = 1e-17
# One sweep over all pairs after another: five to eight do.
SWEEPS = 60


def decompose(A, left, size, right, W, count, rows, columns, vectors):
    """Singular values of ``count`` matrices (rows, columns) in falling order, with ``vectors`` 1 the vectors
    that belong to them, with 2 all.

    ``left`` (rows, k) has the vectors as columns, ``right`` (k, columns) as rows. Returns nothing; ``size``
    of a matrix that is not finite is NaN.
    """
    n = min(rows, columns)
    length = max(rows, columns)
    k = length if vectors == 2 else n
    o = 0
    t = n * length
    order = t + 2 * n
    M = order + n
    J = M + n * n
    squares = J + n * n
    rank = squares + n
    X = rank + n
    for m in range(count):
        scale = gather(A, W, m * rows * columns, o, rows, columns)
        if not scale < 1e300:
            for i in range(n):
                size[m * n + i] = scale - scale
        else:
            reflect(W, o, t, order, n, length, 1)
            for i in range(n):
                for j in range(n):
                    above = W[o + j * length + i] if i < j else 0.0
                    W[M + i * n + j] = W[t + n + i] if i == j else above
                    W[J + i * n + j] = 1.0 if i == j else 0.0
            orthogonalise(W, M, J, squares, n, NOTHING * abs(W[t + n]) if n > 0 else 0.0)
            sort(W, squares, rank, n)
            for i in range(n):
                size[m * n + i] = math.sqrt(W[squares + int(W[rank + i])]) * scale
            if vectors != 0:
                directions(W, M, squares, n, NOTHING * abs(W[t + n]) if n > 0 else 0.0, X)
                hand_out(left, right, W, m, rows, columns, k, o, t, order, M, J, rank, X)


def gather(A, W, a, o, rows, columns):
    """A matrix by its rows, or its columns where these are fewer, its largest entry brought near 1; returned:
    what that was divided by.
    """
    largest = 0.0
    check = 0.0
    for i in range(rows * columns):
        check += A[a + i] * 0.0
        largest = abs(A[a + i]) if abs(A[a + i]) > largest else largest
    if check != 0.0 or largest >= 1e300:
        return 1e308 * 1e308
    scale = 1.0
    if largest > 0.0:
        while largest * scale > 65536.0:
            scale = scale * 1.52587890625e-05
        while largest * scale < 1.52587890625e-05 and scale < 1e300:
            scale = scale * 65536.0
    for i in range(rows):
        for j in range(columns):
            place = o + j * rows + i if rows > columns else o + i * columns + j
            W[place] = A[a + i * columns + j] * scale
    return 1.0 / scale


def orthogonalise(W, M, J, squares, n, least):
    """Rotates the rows at ``M`` in pairs until they are orthogonal, those at ``J`` along; ``squares`` are
    those of their lengths.
    """
    limit = ORTHOGONAL * math.sqrt(float(n))
    below = least * least
    for _ in range(SWEEPS):
        largest = 0.0  # cosine between two rows that this sweep found
        steepest = 0.0  # tangent of a rotation
        for p in range(n):
            W[squares + p] = dot(W, M + p * n, M + p * n, n)
        for p in range(n - 1):
            for q in range(p + 1, n):
                a = W[squares + p]
                b = W[squares + q]
                if a > below and b > below:
                    c = dot(W, M + p * n, M + q * n, n)
                    both = math.sqrt(a * b)
                    if abs(c) > limit * both:
                        largest = max(largest, abs(c) / both)
                        steepest = max(steepest, rotate(W, M, J, squares, n, p, q, c))
        if (
            largest * steepest <= limit
        ):  # what a rotation puts back into pairs that were orthogonal is below rounding
            break
    for p in range(n):
        W[squares + p] = dot(W, M + p * n, M + p * n, n)


def rotate(W, M, J, squares, n, p, q, c):
    """Makes rows p and q orthogonal, whose product is c; returned: the tangent of the angle by which they
    turn.
    """
    slope = (W[squares + q] - W[squares + p]) / (2.0 * c)
    root = math.sqrt(1.0 + slope * slope)
    tangent = 1.0 / (slope + root) if slope > 0.0 else 1.0 / (slope - root)
    if (
        slope == 0.0
        # rows of one length: the sign of c decides, so that a row turned round gives the same rows turned
        # round
    ):
        tangent = 1.0 if c > 0.0 else -1.0
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for k in range(n):
        x = W[M + p * n + k]
        y = W[M + q * n + k]
        W[M + p * n + k] = cosine * x - sine * y
        W[M + q * n + k] = sine * x + cosine * y
    for k in range(n):
        x = W[J + p * n + k]
        y = W[J + q * n + k]
        W[J + p * n + k] = cosine * x - sine * y
        W[J + q * n + k] = sine * x + cosine * y
    W[squares + p] -= tangent * c
    W[squares + q] += tangent * c
    return abs(tangent)


def sort(W, squares, rank, n):
    """Places of the squares in falling order, those of one size as they come."""
    for i in range(n):
        place = i
        while place > 0 and W[squares + int(W[rank + place - 1])] < W[squares + i]:
            W[rank + place] = W[rank + place - 1]
            place = place - 1
        W[rank + place] = i


def directions(W, M, squares, n, least, X):
    """Scales the rows to unit length; those that are nothing become unit vectors across all others."""
    for i in range(n):
        if W[squares + i] > least * least:
            scale = 1.0 / math.sqrt(W[squares + i])
            for k in range(n):
                W[M + i * n + k] = W[M + i * n + k] * scale
    for i in range(n):
        if not W[squares + i] > least * least:
            for k in range(n):  # what is left of each axis
                W[X + k] = 1.0
            for j in range(n):
                if j < i or W[squares + j] > least * least:
                    for k in range(n):
                        W[X + k] -= W[M + j * n + k] * W[M + j * n + k]
            best = 0
            for k in range(n):
                best = k if W[X + k] > W[X + best] else best
            for k in range(n):
                W[M + i * n + k] = 1.0 if k == best else 0.0
            for _ in range(3):
                for j in range(n):
                    if j < i or (j > i and W[squares + j] > least * least):
                        deduct(W, M + i * n, M + j * n, n, dot(W, M + i * n, M + j * n, n))
                scale = 1.0 / math.sqrt(dot(W, M + i * n, M + i * n, n))
                for k in range(n):
                    W[M + i * n + k] = W[M + i * n + k] * scale


def hand_out(left, right, W, m, rows, columns, k, o, t, order, M, J, rank, X):
    """Writes the vectors in falling order of their singular values: those of the longer side are Q J^T, the
    others lie at ``M``.
    """
    n = min(rows, columns)
    length = max(rows, columns)
    tall = rows > columns
    lefts = k if tall else n  # columns of ``left``
    rights = n if tall else k  # rows of ``right``
    for i in range(k):
        for j in range(length):
            W[X + j] = 1.0 if i == j else 0.0
        if i < n:
            row = int(W[rank + i])
            for j in range(n):
                W[X + j] = W[J + row * n + j]
            for j in range(n):
                to = int(W[order + j])
                if tall:
                    right[m * rights * columns + i * columns + to] = W[M + row * n + j]
                else:
                    left[m * rows * lefts + to * lefts + i] = W[M + row * n + j]
        turn_back(W, o, t, n, length, X)
        for j in range(length):
            if tall:
                left[m * rows * lefts + j * lefts + i] = W[X + j]
            else:
                right[m * rights * columns + i * columns + j] = W[X + j]


def dot(W, first, second, count):
    """Sum of products of what lies behind two places, in four sums that are added in pairs at the end: one
    would wait for itself.
    """
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    whole = count // 4 * 4
    for k in range(count // 4):
        i = first + 4 * k
        j = second + 4 * k
        a += W[i] * W[j]
        b += W[i + 1] * W[j + 1]
        c += W[i + 2] * W[j + 2]
        d += W[i + 3] * W[j + 3]
    for k in range(whole, count):
        a += W[first + k] * W[second + k]
    return (a + b) + (c + d)


def deduct(W, first, second, count, factor):
    """Takes a multiple of what lies behind the second place off what lies behind the first."""
    for k in range(count):
        W[first + k] -= factor * W[second + k]


def first_sign(W, at, count):
    """The first entry that is not zero: a column turned round is reflected by the same vector."""
    for k in range(count):
        if W[at + k] != 0.0:
            return W[at + k]
    return 0.0


def reflect(W, o, t, order, count, size, pivoted):
    """Factors of ``count`` columns of ``size`` entries each at ``o``: column j has R below entry j, its
    reflection behind it.

    The diagonal of R lies at t + count + j, the factors of the reflections at t + j, the order of the columns
    at ``order``.
    """
    for k in range(count):
        W[order + k] = k
    for k in range(min(count, size)):
        left = size - k
        if pivoted != 0:
            best = k
            largest = dot(W, o + k * size + k, o + k * size + k, left)
            for j in range(k + 1, count):
                square = dot(W, o + j * size + k, o + j * size + k, left)
                if square > largest:
                    largest = square
                    best = j
            if best != k:
                for j in range(size):
                    held = W[o + k * size + j]
                    W[o + k * size + j] = W[o + best * size + j]
                    W[o + best * size + j] = held
                held = W[order + k]
                W[order + k] = W[order + best]
                W[order + best] = held
        here = o + k * size + k
        head = W[here]
        rest = dot(W, here + 1, here + 1, left - 1)
        if rest == 0.0:
            W[t + k] = 0.0
            W[t + count + k] = head
        else:
            whole = math.sqrt(head * head + rest)
            whole = whole if first_sign(W, here, left) < 0.0 else -whole
            W[t + k] = (whole - head) / whole
            W[t + count + k] = whole
            scale = 1.0 / (head - whole)
            for j in range(1, left):
                W[here + j] = W[here + j] * scale
        W[here] = 1.0
        if W[t + k] != 0.0:
            for j in range(k + 1, count):
                there = o + j * size + k
                deduct(W, there, here, left, W[t + k] * dot(W, here, there, left))


def turn_back(W, o, t, count, size, at):
    """Q x for a vector of ``size`` entries at ``at``: the reflections from the last to the first."""
    for k in range(count - 1, -1, -1):
        if W[t + k] != 0.0:
            here = o + k * size + k
            deduct(W, at + k, here, size - k, W[t + k] * dot(W, here, at + k, size - k))


def factors(A, Q, R, W, count, rows, columns, full):
    """Q (rows, k) and R (k, columns) of ``count`` matrices (rows, columns); k is the lesser of both, or
    ``rows`` where Q is to be ``full``.
    """
    most = min(rows, columns)
    k = rows if full != 0 else most
    o = 0
    t = columns * rows
    order = t + 2 * columns
    at = order + columns
    for m in range(count):
        for i in range(rows):
            for j in range(columns):
                W[o + j * rows + i] = A[m * rows * columns + i * columns + j]
        reflect(W, o, t, order, columns, rows, 0)
        for i in range(k):
            for j in range(columns):
                above = W[o + j * rows + i] if i < j else 0.0
                R[m * k * columns + i * columns + j] = W[t + columns + j] if i == j else above
        for i in range(k):
            for j in range(rows):
                W[at + j] = 1.0 if i == j else 0.0
            turn_back(W, o, t, most, rows, at)
            for j in range(rows):
                Q[m * rows * k + j * k + i] = W[at + j]
