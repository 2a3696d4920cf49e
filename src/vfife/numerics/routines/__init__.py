"""Texts of the numerical routines in the subset of Python that :mod:`vfife.codegen.plain` compiles: numbers, loops, flat arrays with offsets."""
