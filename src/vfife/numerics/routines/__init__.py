"""Texts of the numerical routines in the subset of Python that :mod:`vfife.compiler.backends.plain` compiles:
numbers, loops, flat arrays with offsets.
"""
