"""Eigenvalues and vectors of symmetric matrices: reflections to three diagonals, then implicit QL steps with shifts.

Bowdler, Martin, Reinsch and Wilkinson, Numerische Mathematik 11 (1968) 293-306 (tred2 and tql2 of EISPACK).
"""

import math

from .functions import length

STEPS = 60


def diagonalise(A, values, vectors, W, count, size):
    """Eigenvalues of ``count`` symmetric matrices (size, size) in rising order, and vectors as columns; those of a matrix not finite are NaN."""
    d = size * size
    e = d + size
    for m in range(count):
        check = 0.0
        for i in range(size * size):
            W[i] = A[m * size * size + i]
            check += W[i] * 0.0
        if check != 0.0:
            for i in range(size):
                values[m * size + i] = check
        else:
            tridiagonal(W, d, e, size)
            steps(W, d, e, size)
            for i in range(size):
                place = 0  # how many come before: smaller ones, and equal ones of a lower number
                for j in range(size):
                    if W[d + j] < W[d + i] or (W[d + j] == W[d + i] and j < i):
                        place = place + 1
                values[m * size + place] = W[d + i]
                for j in range(size):
                    vectors[(m * size + j) * size + place] = W[j * size + i]


def tridiagonal(V, d, e, n):
    """Reflections to a diagonal at ``d`` and one beside it at ``e``, gathered in V; only its lower triangle is read."""
    for j in range(n):
        V[d + j] = V[(n - 1) * n + j]
    for i in range(n - 1, 0, -1):
        scale = 0.0
        h = 0.0
        for k in range(i):
            scale += abs(V[d + k])
        if scale == 0.0:
            V[e + i] = V[d + i - 1]
            for j in range(i):
                V[d + j] = V[(i - 1) * n + j]
                V[i * n + j] = 0.0
                V[j * n + i] = 0.0
        else:
            for k in range(i):
                V[d + k] = V[d + k] / scale
                h += V[d + k] * V[d + k]
            f = V[d + i - 1]
            g = -math.sqrt(h) if f > 0.0 else math.sqrt(h)
            V[e + i] = scale * g
            h = h - f * g
            V[d + i - 1] = f - g
            for j in range(i):
                V[e + j] = 0.0
            for j in range(i):
                f = V[d + j]
                V[j * n + i] = f
                g = V[e + j] + V[j * n + j] * f
                for k in range(j + 1, i):
                    g += V[k * n + j] * V[d + k]
                    V[e + k] += V[k * n + j] * f
                V[e + j] = g
            f = 0.0
            for j in range(i):
                V[e + j] = V[e + j] / h
                f += V[e + j] * V[d + j]
            hh = f / (h + h)
            for j in range(i):
                V[e + j] -= hh * V[d + j]
            for j in range(i):
                f = V[d + j]
                g = V[e + j]
                for k in range(j, i):
                    V[k * n + j] -= f * V[e + k] + g * V[d + k]
                V[d + j] = V[(i - 1) * n + j]
                V[i * n + j] = 0.0
        V[d + i] = h
    gathered(V, d, n)
    if n > 0:
        V[e] = 0.0


def gathered(V, d, n):
    """The product of the reflections."""
    for i in range(n - 1):
        V[(n - 1) * n + i] = V[i * n + i]
        V[i * n + i] = 1.0
        h = V[d + i + 1]
        if h != 0.0:
            for k in range(i + 1):
                V[d + k] = V[k * n + i + 1] / h
            for j in range(i + 1):
                g = 0.0
                for k in range(i + 1):
                    g += V[k * n + i + 1] * V[k * n + j]
                for k in range(i + 1):
                    V[k * n + j] -= g * V[d + k]
        for k in range(i + 1):
            V[k * n + i + 1] = 0.0
    for j in range(n):
        V[d + j] = V[(n - 1) * n + j]
        V[(n - 1) * n + j] = 0.0
    if n > 0:
        V[(n - 1) * n + n - 1] = 1.0


def steps(V, d, e, n):
    """QL steps until what lies beside the diagonal is nothing."""
    for i in range(1, n):
        V[e + i - 1] = V[e + i]
    if n > 0:
        V[e + n - 1] = 0.0
    f = 0.0
    largest = 0.0
    for l in range(n):
        here = abs(V[d + l]) + abs(V[e + l])
        largest = here if here > largest else largest
        m = l
        while m < n - 1 and abs(V[e + m]) > 2.220446049250313e-16 * largest:
            m = m + 1
        if m > l:
            step = 0
            while step < STEPS and (step == 0 or abs(V[e + l]) > 2.220446049250313e-16 * largest):
                step = step + 1
                f = f + shifted(V, d, e, n, l, m)
        V[d + l] = V[d + l] + f
        V[e + l] = 0.0


def shifted(V, d, e, n, l, m):
    """One step between l and m; returned: the shift that the diagonal has lost."""
    g = V[d + l]
    p = (V[d + l + 1] - g) / (2.0 * V[e + l])
    r = length(p, 1.0)
    r = -r if p < 0.0 else r
    V[d + l] = V[e + l] / (p + r)
    V[d + l + 1] = V[e + l] * (p + r)
    next_one = V[d + l + 1]
    shift = g - V[d + l]
    for i in range(l + 2, n):
        V[d + i] -= shift
    p = V[d + m]
    c = 1.0
    c2 = c
    c3 = c
    s = 0.0
    s2 = 0.0
    beside = V[e + l + 1]
    for i in range(m - 1, l - 1, -1):
        c3 = c2
        c2 = c
        s2 = s
        g = c * V[e + i]
        h = c * p
        r = length(p, V[e + i])
        V[e + i + 1] = s * r
        s = V[e + i] / r
        c = p / r
        p = c * V[d + i] - s * g
        V[d + i + 1] = h + s * (c * g + s * V[d + i])
        for k in range(n):
            h = V[k * n + i + 1]
            V[k * n + i + 1] = s * V[k * n + i] + c * h
            V[k * n + i] = c * V[k * n + i] - s * h
    p = -s * s2 * c3 * beside * V[e + l] / next_one
    V[e + l] = s * p
    V[d + l] = c * p
    return shift
