"""Numerical routines that give the same bits on every machine.

Every result follows from + - * / sqrt, comparisons and our own polynomials in a fixed order: no fused
products, no sum whose order depends on the width of a register, no call of the C library's functions, of BLAS
or of LAPACK. The routines for arrays are compiled like the loops of a run
(:mod:`vfife.compiler.runtime.native`) and run to the same bits as plain Python. Each matrix of a batch has
the bits that it has alone.

- :mod:`~vfife.numerics.scalar`: functions of one number, ``sin``, ``cos``, ``sincos``, ``tan``, ``atan``,
  ``atan2``, ``asin``, ``acos``, ``exp``, ``expm1``, ``log``, ``log1p``, ``log10``, ``power``, ``hypot``,
  ``distance``, ``integer_power``; error about 1 ulp. Imports no NumPy.
- :mod:`~vfife.numerics.elementwise`: the same of numbers and arrays, element by element, and ``interpolate``
  in place of ``np.interp``.
- :mod:`~vfife.numerics.dense`: ``dot``, ``times`` (matrix times vector), ``product`` (matrix times matrix),
  ``norm``, over leading dimensions; ``solve``, ``determinant_sign``, ``inverse``, ``svd``,
  ``singular_values``, ``eigh``, ``eigenvalue_sizes``, ``qr``, ``least_squares``, ``pinv``; matrices (...,
  rows, columns), names and shapes of results as in ``np.linalg``.

Infinite or undefined entries raise ``np.linalg.LinAlgError`` in ``svd``, ``eigh`` and what rests on them, as
there.
"""
