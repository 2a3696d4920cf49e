"""QR factors by Householder's reflections, with the largest remaining column first where asked.

A matrix is held by its columns: row j of W is column j. A reflection I - t v v^T keeps v behind its first entry, 1, in place of what it removed.
"""

import math


def dot(W, first, second, count):
    """Sum of products of what lies behind two places, in four sums that are added in pairs at the end: one would wait for itself."""
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
    """Factors of ``count`` columns of ``size`` entries each at ``o``: column j has R below entry j, its reflection behind it.

    The diagonal of R lies at t + count + j, the factors of the reflections at t + j, the order of the columns at ``order``.
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
    """Q (rows, k) and R (k, columns) of ``count`` matrices (rows, columns); k is the lesser of both, or ``rows`` where Q is to be ``full``."""
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
