"""Eigenvalues, and vectors of symmetric matrices.

Eigenvalues of general real matrices: elimination to Hessenberg's form, then Francis' double steps.

Martin, Peters and Wilkinson, Numerische Mathematik 14 (1970) 219-231 (elmhes and hqr of EISPACK).

Eigenvalues and vectors of symmetric matrices: reflections to three diagonals, then implicit QL steps with
shifts.

Bowdler, Martin, Reinsch and Wilkinson, Numerische Mathematik 11 (1968) 293-306 (tred2 and tql2 of EISPACK).
"""

import math

from .functions import length

STEPS = 60  # per eigenvalue; every tenth has a shift of its own
ROUNDING = 2.220446049250313e-16


def eigenvalues(A, real, imaginary, W, count, size):
    """Real and imaginary parts of the eigenvalues of ``count`` matrices (size, size); of a matrix not finite,
    or not solved, NaN.
    """
    for m in range(count):
        check = 0.0
        for i in range(size * size):
            W[i] = A[m * size * size + i]
            check += W[i] * 0.0
        if check == 0.0:
            hessenberg(W, size)
            check = francis(W, real, imaginary, m * size, size)
        if check != 0.0:
            for i in range(size):
                real[m * size + i] = (1e308 * 1e308) * 0.0
                imaginary[m * size + i] = (1e308 * 1e308) * 0.0


def hessenberg(a, n):
    """Zeros below the first diagonal under the main one, by elimination with pivots."""
    for m in range(1, n - 1):
        x = 0.0
        i = m
        for j in range(m, n):
            if abs(a[j * n + m - 1]) > abs(x):
                x = a[j * n + m - 1]
                i = j
        if i != m:
            for j in range(m - 1, n):
                held = a[i * n + j]
                a[i * n + j] = a[m * n + j]
                a[m * n + j] = held
            for j in range(n):
                held = a[j * n + i]
                a[j * n + i] = a[j * n + m]
                a[j * n + m] = held
        if x != 0.0:
            for i in range(m + 1, n):
                y = a[i * n + m - 1]
                if y != 0.0:
                    y = y / x
                    a[i * n + m - 1] = 0.0
                    for j in range(m, n):
                        a[i * n + j] -= y * a[m * n + j]
                    for j in range(n):
                        a[j * n + m] += y * a[j * n + i]


def francis(a, real, imaginary, at, n):
    """Double steps with implicit shifts; returned: 1 where an eigenvalue does not converge."""
    norm = 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            norm += abs(a[i * n + j])
    last = n - 1
    lost = 0.0  # what shifts have taken off the diagonal
    while last >= 0:
        step = 0
        found = 0
        while found == 0:
            l = cut(a, last, n, norm)
            x = a[last * n + last]
            if l == last:
                real[at + last] = x + lost
                imaginary[at + last] = 0.0
                found = 1
            elif l == last - 1:
                pair(a, real, imaginary, at, last, n, lost)
                found = 2
            elif step == STEPS:
                return 1.0
            else:
                y = a[(last - 1) * n + last - 1]
                w = a[last * n + last - 1] * a[(last - 1) * n + last]
                if step % 10 == 9:
                    lost = lost + x
                    for i in range(last + 1):
                        a[i * n + i] -= x
                    s = abs(a[last * n + last - 1]) + abs(a[(last - 1) * n + last - 2])
                    x = 0.75 * s
                    y = x
                    w = -0.4375 * s * s
                step = step + 1
                double_step(a, l, last, n, x, y, w)
        last = last - found
    return 0.0


def cut(a, last, n, norm):
    """Where the part that ends with ``last`` begins."""
    for l in range(last, 0, -1):
        s = abs(a[(l - 1) * n + l - 1]) + abs(a[l * n + l])
        s = norm if s == 0.0 else s
        if abs(a[l * n + l - 1]) <= ROUNDING * s:
            a[l * n + l - 1] = 0.0
            return l
    return 0


def pair(a, real, imaginary, at, last, n, lost):
    """The two eigenvalues of the last two rows."""
    x = a[last * n + last]
    y = a[(last - 1) * n + last - 1]
    w = a[last * n + last - 1] * a[(last - 1) * n + last]
    p = 0.5 * (y - x)
    q = p * p + w
    z = math.sqrt(abs(q))
    x = x + lost
    if q >= 0.0:
        z = p + (z if p >= 0.0 else -z)
        real[at + last - 1] = x + z
        real[at + last] = x - w / z if z != 0.0 else x + z
        imaginary[at + last - 1] = 0.0
        imaginary[at + last] = 0.0
    else:
        real[at + last - 1] = x + p
        real[at + last] = x + p
        imaginary[at + last - 1] = z
        imaginary[at + last] = -z


def beginning(a, l, last, n, x, y, w):
    """Row from which a double step may begin, and the first column of its shifted product there."""
    p = 0.0
    q = 0.0
    r = 0.0
    m = last - 2
    while m >= l:
        z = a[m * n + m]
        r = x - z
        s = y - z
        p = (r * s - w) / a[(m + 1) * n + m] + a[m * n + m + 1]
        q = a[(m + 1) * n + m + 1] - z - r - s
        r = a[(m + 2) * n + m + 1]
        s = abs(p) + abs(q) + abs(r)
        p = p / s
        q = q / s
        r = r / s
        if m == l:
            break
        u = abs(a[m * n + m - 1]) * (abs(q) + abs(r))
        v = abs(p) * (abs(a[(m - 1) * n + m - 1]) + abs(z) + abs(a[(m + 1) * n + m + 1]))
        if u <= ROUNDING * v:
            break
        m = m - 1
    return m, p, q, r


def double_step(a, l, last, n, x, y, w):
    """One double QR step on the rows from l to ``last``."""
    m, p, q, r = beginning(a, l, last, n, x, y, w)
    for i in range(m + 2, last + 1):
        a[i * n + i - 2] = 0.0
        if i != m + 2:
            a[i * n + i - 3] = 0.0
    for k in range(m, last):
        if k != m:
            p = a[k * n + k - 1]
            q = a[(k + 1) * n + k - 1]
            r = a[(k + 2) * n + k - 1] if k != last - 1 else 0.0
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
                    a[k * n + k - 1] = -a[k * n + k - 1]
            else:
                a[k * n + k - 1] = -s * x
            p = p + s
            x = p / s
            y = q / s
            z = r / s
            q = q / p
            r = r / p
            for j in range(k, last + 1):
                p = a[k * n + j] + q * a[(k + 1) * n + j]
                if k != last - 1:
                    p = p + r * a[(k + 2) * n + j]
                    a[(k + 2) * n + j] -= p * z
                a[(k + 1) * n + j] -= p * y
                a[k * n + j] -= p * x
            end = last if last < k + 3 else k + 3
            for i in range(l, end + 1):
                p = x * a[i * n + k] + y * a[i * n + k + 1]
                if k != last - 1:
                    p = p + z * a[i * n + k + 2]
                    a[i * n + k + 2] -= p * r
                a[i * n + k + 1] -= p * q
                a[i * n + k] -= p


def diagonalise(A, values, vectors, W, count, size):
    """Eigenvalues of ``count`` symmetric matrices (size, size) in rising order, and vectors as columns; those
    of a matrix not finite are NaN.
    """
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
    """Reflections to a diagonal at ``d`` and one beside it at ``e``, gathered in V; only its lower triangle
    is read.
    """
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
