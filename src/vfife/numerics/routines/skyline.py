"""Factors L D L^T of symmetric matrices whose entries lie near the diagonal, row by row from the first entry that is not zero (skyline)."""


def factorise(A, start, first, size, least):
    """Factors in place. Row i has its entries from column ``first[i]`` to the diagonal, in A up to ``start[i]``, the diagonal's place.

    Pivots below ``least`` are taken as that: a matrix to which so much was added has none in exact arithmetic.
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
