"""Geometry and functions as numbers: paths, polynomials, expressions, tables."""
