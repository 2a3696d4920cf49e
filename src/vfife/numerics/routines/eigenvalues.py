"""Eigenvalues of general real matrices: elimination to Hessenberg's form, then Francis' double steps.

Martin, Peters and Wilkinson, Numerische Mathematik 14 (1970) 219-231 (elmhes and hqr of EISPACK).
"""

import math

STEPS = 60  # per eigenvalue; every tenth has a shift of its own
ROUNDING = 2.220446049250313e-16


def eigenvalues(A, real, imaginary, W):
    """Write the real and imaginary parts (count, size) of the eigenvalues of the matrices A (count, size,
    size); they are NaN for a matrix that is not finite or whose steps did not converge.

    ``W`` (size, size) is room for one matrix; A is kept.
    """
    size = A.shape[1]
    for m in range(A.shape[0]):
        check = 0.0  # entry times zero is zero, but NaN for an entry that is not finite
        for i in range(size):
            for j in range(size):
                W[i, j] = A[m, i, j]
                check += W[i, j] * 0.0
        if check == 0.0:
            hessenberg(W, size)
            check = francis(W, real, imaginary, m, size)
        if check != 0.0:
            for i in range(size):
                real[m, i] = (1e308 * 1e308) * 0.0
                imaginary[m, i] = (1e308 * 1e308) * 0.0


def hessenberg(a, n):
    """Bring a matrix to Hessenberg's form, zeros below the first subdiagonal, by elimination with pivots.

    Every row operation is followed by the inverse operation on the columns, so the eigenvalues stay.
    Elimination takes half the operations of Householder's reflections; its pivots keep the factors at or
    below one, but in theory it is less stable than they are.
    """
    for m in range(1, n - 1):
        x = 0.0
        i = m
        for j in range(m, n):
            if abs(a[j, m - 1]) > abs(x):
                x = a[j, m - 1]
                i = j
        if i != m:
            for j in range(m - 1, n):
                former = a[i, j]
                a[i, j] = a[m, j]
                a[m, j] = former
            for j in range(n):
                former = a[j, i]
                a[j, i] = a[j, m]
                a[j, m] = former
        if x != 0.0:
            for i in range(m + 1, n):
                y = a[i, m - 1]
                if y != 0.0:
                    y = y / x
                    a[i, m - 1] = 0.0
                    for j in range(m, n):
                        a[i, j] -= y * a[m, j]
                    for j in range(n):
                        a[j, m] += y * a[j, i]


def francis(a, real, imaginary, m, n):
    """Find the eigenvalues of a Hessenberg matrix by double steps with implicit shifts; return 1 where one of
    them does not converge, otherwise 0.

    The two shifts of a step are the eigenvalues of the last two rows; they may be a conjugate pair, and both
    at once keep the arithmetic real. One eigenvalue or two split off at the lower end, and the search goes on
    with the rows above them.
    """
    norm = 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            norm += abs(a[i, j])
    last = n - 1
    shift = 0.0  # what shifts have taken off the diagonal
    while last >= 0:
        step = 0
        count = 0
        while count == 0:
            l = cut(a, last, n, norm)
            x = a[last, last]
            if l == last:
                real[m, last] = x + shift
                imaginary[m, last] = 0.0
                count = 1
            elif l == last - 1:
                pair(a, real, imaginary, m, last, shift)
                count = 2
            elif step == STEPS:
                return 1.0
            else:
                y = a[last - 1, last - 1]
                w = a[last, last - 1] * a[last - 1, last]
                if step % 10 == 9:
                    # The usual shifts can repeat themselves in a cycle, as for a permutation of the rows. An
                    # arbitrary shift, that of the Algol procedure, breaks it.
                    shift = shift + x
                    for i in range(last + 1):
                        a[i, i] -= x
                    s = abs(a[last, last - 1]) + abs(a[last - 1, last - 2])
                    x = 0.75 * s
                    y = x
                    w = -0.4375 * s * s
                step = step + 1
                double_step(a, l, last, n, x, y, w)
        last = last - count
    return 0.0


def cut(a, last, n, norm):
    """Return the first row of the block that ends with row ``last``: there the subdiagonal is rounding, and
    is set to zero.
    """
    for l in range(last, 0, -1):
        s = abs(a[l - 1, l - 1]) + abs(a[l, l])
        s = norm if s == 0.0 else s
        if abs(a[l, l - 1]) <= ROUNDING * s:
            a[l, l - 1] = 0.0
            return l
    return 0


def pair(a, real, imaginary, m, last, shift):
    """Write the two eigenvalues of the block of rows ``last`` - 1 and ``last``."""
    x = a[last, last]
    y = a[last - 1, last - 1]
    w = a[last, last - 1] * a[last - 1, last]
    # lambda = x + p +- sqrt(p^2 + w). Of two real values the one further from x is computed by the sum; the
    # other follows from their product, since a difference would lose its digits.
    p = 0.5 * (y - x)
    q = p * p + w
    z = math.sqrt(abs(q))
    x = x + shift
    if q >= 0.0:
        z = p + (z if p >= 0.0 else -z)
        real[m, last - 1] = x + z
        real[m, last] = x - w / z if z != 0.0 else x + z
        imaginary[m, last - 1] = 0.0
        imaginary[m, last] = 0.0
    else:
        real[m, last - 1] = x + p
        real[m, last] = x + p
        imaginary[m, last - 1] = z
        imaginary[m, last] = -z


def beginning(a, l, last, n, x, y, w):
    """Return the row from which a double step may begin, and the three entries that the first column of
    (H - a I)(H - b I) has there, with x, y and w for the sum and product of the shifts a and b.

    A step may begin below row l where two small subdiagonal entries follow each other: what it would leave
    above them is below rounding.
    """
    p = 0.0
    q = 0.0
    r = 0.0
    m = last - 2
    while m >= l:
        z = a[m, m]
        r = x - z
        s = y - z
        p = (r * s - w) / a[m + 1, m] + a[m, m + 1]
        q = a[m + 1, m + 1] - z - r - s
        r = a[m + 2, m + 1]
        s = abs(p) + abs(q) + abs(r)
        p = p / s
        q = q / s
        r = r / s
        if m == l:
            break
        u = abs(a[m, m - 1]) * (abs(q) + abs(r))
        v = abs(p) * (abs(a[m - 1, m - 1]) + abs(z) + abs(a[m + 1, m + 1]))
        if u <= ROUNDING * v:
            break
        m = m - 1
    return m, p, q, r


def double_step(a, l, last, n, x, y, w):
    """Do one double QR step on the rows from l to ``last``.

    A first reflection of three rows makes the first column of the shifted product; it puts entries below the
    subdiagonal, and each further reflection moves them one row down, until they leave at the end (the bulge
    is chased). Nothing is formed outside the block, because only eigenvalues are asked for.
    """
    m, p, q, r = beginning(a, l, last, n, x, y, w)
    for i in range(m + 2, last + 1):
        a[i, i - 2] = 0.0
        if i != m + 2:
            a[i, i - 3] = 0.0
    for k in range(m, last):
        if k != m:
            p = a[k, k - 1]
            q = a[k + 1, k - 1]
            r = a[k + 2, k - 1] if k != last - 1 else 0.0
            x = abs(p) + abs(q) + abs(r)
            if x != 0.0:
                p = p / x
                q = q / x
                r = r / x
        s = math.sqrt(p * p + q * q + r * r)
        s = -s if p < 0.0 else s
        if s != 0.0:
            if k == m:
                if l != m:
                    a[k, k - 1] = -a[k, k - 1]
            else:
                a[k, k - 1] = -s * x
            p = p + s
            x = p / s
            y = q / s
            z = r / s
            q = q / p
            r = r / p
            for j in range(k, last + 1):
                p = a[k, j] + q * a[k + 1, j]
                if k != last - 1:
                    p = p + r * a[k + 2, j]
                    a[k + 2, j] -= p * z
                a[k + 1, j] -= p * y
                a[k, j] -= p * x
            end = last if last < k + 3 else k + 3
            for i in range(l, end + 1):
                p = x * a[i, k] + y * a[i, k + 1]
                if k != last - 1:
                    p = p + z * a[i, k + 2]
                    a[i, k + 2] -= p * r
                a[i, k + 1] -= p * q
                a[i, k] -= p
