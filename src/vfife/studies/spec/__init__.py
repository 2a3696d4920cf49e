"""Specification of a study: what varies, distributions, limits and requested measures."""
