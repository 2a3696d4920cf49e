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
from typing import NamedTuple

# Largest cosine between two rows that count as orthogonal, over the root of their length: some roundings of
# their product.
ORTHOGONAL = 2.2e-16
# Rows shorter than this part of the longest are rounding; their directions are chosen orthogonal to the
# others.
ROUNDING_SHARE = 1e-17
# One sweep over all pairs after another: five to eight do.
SWEEPS = 60


class Offsets(NamedTuple):
    """Where the parts of a decomposition lie in its work array.

    The matrix has n columns of ``length`` entries at 0; one with fewer rows than columns is transposed.
    Behind it lie the factors of its reflections and the diagonal of R at t, the order of the
    columns, the rows of R at M, the rotations at J, squares of lengths, the rank of each of these, and a
    vector at X.
    """

    n: int
    length: int
    t: int
    order: int
    M: int
    J: int
    squares: int
    rank: int
    X: int


def offsets_of(rows, columns) -> Offsets:
    """Return the offsets for a matrix (rows, columns)."""
    n = min(rows, columns)
    length = max(rows, columns)
    t = n * length
    M = t + 3 * n
    J = M + n * n
    squares = J + n * n
    return Offsets(n, length, t, t + 2 * n, M, J, squares, squares + n, squares + 2 * n)


def decompose(A, left, size, right, W, vectors):
    """Write the singular values of matrices A (count, rows, columns) to ``size`` (count, n) in falling order.

    ``vectors`` is 0 for values alone, 1 for the vectors that belong to them, 2 for complete bases. ``left``
    (count, rows, k) takes the vectors as columns, ``right`` (count, k, columns) as rows. The values of a
    matrix that is not finite are NaN. ``W`` is the work array (see :class:`Offsets`).
    """
    offsets = offsets_of(A.shape[1], A.shape[2])
    n, length, t, order, M, J, squares, rank, _ = offsets
    for m in range(A.shape[0]):
        scale = gather(A, W, m)
        if not scale < 1e300:  # gather found an entry that is infinite, NaN or near the overflow
            for i in range(n):
                size[m, i] = scale - scale
        else:
            # Rotations of the rows of R rather than of the columns of A: n^2 numbers instead of n times
            # length, and after the pivoting the rows are nearly orthogonal and fall in size.
            reflect(W, t, order, n, length, 1)
            for i in range(n):
                for j in range(n):
                    entry = W[j * length + i] if i < j else 0.0
                    W[M + i * n + j] = W[t + n + i] if i == j else entry
                    W[J + i * n + j] = 1.0 if i == j else 0.0
            shortest = ROUNDING_SHARE * abs(W[t + n]) if n > 0 else 0.0
            orthogonalise(W, offsets, shortest)
            sort(W, squares, rank, n)
            for i in range(n):
                size[m, i] = math.sqrt(W[squares + int(W[rank + i])]) * scale
            if vectors != 0:
                directions(W, offsets, shortest)
                hand_out(left, right, W, m, vectors, A.shape[1] > A.shape[2], offsets)


def gather(A, W, m):
    """Copy matrix m to the work array by its rows, or by its columns where these are fewer, with its largest
    entry brought near 1; return the factor by which singular values are to be multiplied.

    The factor is a power of two, so scaling rounds nothing; it keeps the squares of lengths from overflow and
    from vanishing.
    """
    rows = A.shape[1]
    columns = A.shape[2]
    largest = 0.0
    check = 0.0
    for i in range(rows):
        for j in range(columns):
            check += A[m, i, j] * 0.0
            largest = abs(A[m, i, j]) if abs(A[m, i, j]) > largest else largest
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
            W[j * rows + i if rows > columns else i * columns + j] = A[m, i, j] * scale
    return 1.0 / scale


def orthogonalise(W, offsets: Offsets, shortest):
    """Rotate the rows at M in pairs until they are orthogonal, and those at J with them; rows shorter than
    ``shortest`` are left out.
    """
    n, _, _, _, M, _, squares, _, _ = offsets
    limit = ORTHOGONAL * math.sqrt(float(n))
    shortest_square = shortest * shortest
    for _ in range(SWEEPS):
        largest = 0.0  # cosine between two rows that this sweep found
        steepest = 0.0  # tangent of a rotation
        for p in range(n):
            W[squares + p] = dot(W, M + p * n, M + p * n, n)
        for p in range(n - 1):
            for q in range(p + 1, n):
                a = W[squares + p]
                b = W[squares + q]
                if a > shortest_square and b > shortest_square:
                    c = dot(W, M + p * n, M + q * n, n)
                    lengths = math.sqrt(a * b)
                    if abs(c) > limit * lengths:
                        largest = max(largest, abs(c) / lengths)
                        steepest = max(steepest, rotate(W, offsets, p, q, c))
        # A rotation of one pair spoils other pairs by at most its sine times their cosine. Where the product
        # of the largest of both is rounding, a further sweep would find nothing.
        if largest * steepest <= limit:
            break
    for p in range(n):
        W[squares + p] = dot(W, M + p * n, M + p * n, n)


def rotate(W, offsets: Offsets, p, q, c):
    """Make rows p and q orthogonal, whose scalar product is c; return the absolute tangent of the rotation.

    Of the two angles that do it the smaller one is taken: with the larger, rows would change places in every
    sweep and the sweeps need not converge.
    """
    n = offsets.n
    squares = offsets.squares
    slope = (W[squares + q] - W[squares + p]) / (2.0 * c)
    root = math.sqrt(1.0 + slope * slope)
    tangent = 1.0 / (slope + root) if slope > 0.0 else 1.0 / (slope - root)
    # Rows of one length: the sign of c decides, so that a row of opposite sign gives the same rows with
    # opposite sign.
    if slope == 0.0:
        tangent = 1.0 if c > 0.0 else -1.0
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    turn_rows(W, offsets.M + p * n, offsets.M + q * n, n, cosine, sine)
    turn_rows(W, offsets.J + p * n, offsets.J + q * n, n, cosine, sine)
    W[squares + p] -= tangent * c
    W[squares + q] += tangent * c
    return abs(tangent)


def turn_rows(W, first, second, n, cosine, sine):
    """Rotate two rows into each other."""
    for k in range(n):
        x = W[first + k]
        y = W[second + k]
        W[first + k] = cosine * x - sine * y
        W[second + k] = sine * x + cosine * y


def sort(W, squares, rank, n):
    """Write to ``rank`` the places of the squares in falling order; equal ones keep their order."""
    for i in range(n):
        place = i
        while place > 0 and W[squares + int(W[rank + place - 1])] < W[squares + i]:
            W[rank + place] = W[rank + place - 1]
            place = place - 1
        W[rank + place] = i


def directions(W, offsets: Offsets, shortest):
    """Scale the rows at M to unit length; a row shorter than ``shortest`` becomes a unit vector orthogonal to
    all the others.

    Such a row is rounding and has no direction. It starts as the axis that the other rows cover least, by the
    squares of their entries. Its components along the others are subtracted three times: each pass removes
    what rounding left in the pass before.
    """
    n, _, _, _, M, _, squares, _, X = offsets
    for i in range(n):
        if W[squares + i] > shortest * shortest:
            scale = 1.0 / math.sqrt(W[squares + i])
            for k in range(n):
                W[M + i * n + k] = W[M + i * n + k] * scale
    for i in range(n):
        if not W[squares + i] > shortest * shortest:
            for k in range(n):  # square of the part of each axis that no other row covers
                W[X + k] = 1.0
            for j in range(n):
                if j < i or W[squares + j] > shortest * shortest:
                    for k in range(n):
                        W[X + k] -= W[M + j * n + k] * W[M + j * n + k]
            best = 0
            for k in range(n):
                best = k if W[X + k] > W[X + best] else best
            for k in range(n):
                W[M + i * n + k] = 1.0 if k == best else 0.0
            for _ in range(3):
                for j in range(n):
                    if j < i or (j > i and W[squares + j] > shortest * shortest):
                        deduct(W, M + i * n, M + j * n, n, dot(W, M + i * n, M + j * n, n))
                scale = 1.0 / math.sqrt(dot(W, M + i * n, M + i * n, n))
                for k in range(n):
                    W[M + i * n + k] = W[M + i * n + k] * scale


def hand_out(left, right, W, m, vectors, tall, offsets: Offsets):
    """Write the vectors in falling order of their singular values: those of the longer side are Q J^T, the
    others lie at M.
    """
    n, length, t, order, M, J, _, rank, X = offsets
    for i in range(length if vectors == 2 else n):
        for j in range(length):
            W[X + j] = 1.0 if i == j else 0.0
        if i < n:
            row = int(W[rank + i])
            for j in range(n):
                W[X + j] = W[J + row * n + j]
            for j in range(n):
                to = int(W[order + j])
                if tall:
                    right[m, i, to] = W[M + row * n + j]
                else:
                    left[m, to, i] = W[M + row * n + j]
        turn_back(W, t, n, length, X)
        for j in range(length):
            if tall:
                left[m, j, i] = W[X + j]
            else:
                right[m, i, j] = W[X + j]


def dot(W, first, second, count):
    """Sum of products of what lies behind two places, in four sums that are added in pairs at the end: one
    would wait for itself.
    """
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    fours = count // 4 * 4
    for k in range(count // 4):
        i = first + 4 * k
        j = second + 4 * k
        a += W[i] * W[j]
        b += W[i + 1] * W[j + 1]
        c += W[i + 2] * W[j + 2]
        d += W[i + 3] * W[j + 3]
    for k in range(fours, count):
        a += W[first + k] * W[second + k]
    return (a + b) + (c + d)


def deduct(W, first, second, count, factor):
    """Subtract ``factor`` times the ``count`` entries from the second place on from those at the first."""
    for k in range(count):
        W[first + k] -= factor * W[second + k]


def first_sign(W, at, count):
    """Return the first entry that is not zero, or 0.

    Its sign decides that of a reflection, and not that of the first entry, which may be zero: so a column of
    opposite sign is reflected by the same vector.
    """
    for k in range(count):
        if W[at + k] != 0.0:
            return W[at + k]
    return 0.0


def reflect(W, t, order, count, size, pivoted):
    """Factor ``count`` columns of ``size`` entries each, which lie at 0: in column j the entries before
    entry j become those of R, and those from entry j on the vector of its reflection.

    The diagonal of R goes to t + count + j, the factors of the reflections to t + j, the order of the columns
    to ``order``. ``pivoted`` is 1 to take the largest remaining column first.
    """
    for k in range(count):
        W[order + k] = k
    for k in range(min(count, size)):
        left = size - k
        if pivoted != 0:
            choose_column(W, order, count, size, k)
        head_place = k * size + k
        head = W[head_place]
        tail_square = dot(W, head_place + 1, head_place + 1, left - 1)
        if tail_square == 0.0:
            W[t + k] = 0.0
            W[t + count + k] = head
        else:
            # The diagonal has the sign opposite to the column's: head - diagonal is then a sum, which loses
            # no digits.
            diagonal = math.sqrt(head * head + tail_square)
            diagonal = diagonal if first_sign(W, head_place, left) < 0.0 else -diagonal
            W[t + k] = (diagonal - head) / diagonal
            W[t + count + k] = diagonal
            scale = 1.0 / (head - diagonal)
            for j in range(1, left):
                W[head_place + j] = W[head_place + j] * scale
        W[head_place] = 1.0
        if W[t + k] != 0.0:
            for j in range(k + 1, count):
                target = j * size + k
                deduct(W, target, head_place, left, W[t + k] * dot(W, head_place, target, left))


def choose_column(W, order, count, size, k):
    """Exchange column k with the one behind it whose entries from row k on are longest together.

    The lengths are summed anew for every k. Updating them by differences is cheaper, but loses digits where a
    column nearly vanishes.
    """
    best = k
    largest = dot(W, k * size + k, k * size + k, size - k)
    for j in range(k + 1, count):
        square = dot(W, j * size + k, j * size + k, size - k)
        if square > largest:
            largest = square
            best = j
    if best != k:
        for j in range(size):
            former = W[k * size + j]
            W[k * size + j] = W[best * size + j]
            W[best * size + j] = former
        former = W[order + k]
        W[order + k] = W[order + best]
        W[order + best] = former


def turn_back(W, t, count, size, at):
    """Replace the vector x of ``size`` entries at ``at`` by Q x: the reflections from the last to the
    first.
    """
    for k in range(count - 1, -1, -1):
        if W[t + k] != 0.0:
            place = k * size + k
            deduct(W, at + k, place, size - k, W[t + k] * dot(W, place, at + k, size - k))


def factors(A, Q, R, W):
    """Write Q (count, rows, k) and R (count, k, columns) of the matrices A (count, rows, columns), without
    pivoting; k is the lesser of rows and columns, or all rows.
    """
    rows = A.shape[1]
    columns = A.shape[2]
    t = columns * rows
    order = t + 2 * columns
    at = order + columns
    for m in range(A.shape[0]):
        for i in range(rows):
            for j in range(columns):
                W[j * rows + i] = A[m, i, j]
        reflect(W, t, order, columns, rows, 0)
        for i in range(R.shape[1]):
            for j in range(columns):
                entry = W[j * rows + i] if i < j else 0.0
                R[m, i, j] = W[t + columns + j] if i == j else entry
        for i in range(Q.shape[2]):
            for j in range(rows):
                W[at + j] = 1.0 if i == j else 0.0
            turn_back(W, t, min(rows, columns), rows, at)
            for j in range(rows):
                Q[m, j, i] = W[at + j]
