"""What coefficients of one law must satisfy together."""

from __future__ import annotations


def not_below(static: float, kinetic: float) -> None:
    """Raises ValueError where static friction is weaker than kinetic friction."""
    if static < kinetic:
        raise ValueError(f"static_coefficient = {static:g} is below coefficient = {kinetic:g}; raise the one or lower the other")
