"""Products of dense matrices row by row, each sum in the order of its terms."""


def multiply(A, B, C, count, a, b, c, rows, inner, columns):
    """C = A B for ``count`` pairs of matrices (rows, inner) and (inner, columns), which lie ``a``, ``b`` and ``c`` numbers apart."""
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
