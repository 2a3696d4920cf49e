"""What coefficients of one law must satisfy together."""

from collections.abc import Iterator

from ...errors import Fault


def not_below(static: float, kinetic: float) -> Iterator[Fault]:
    """Yield a fault where static friction is weaker than kinetic friction."""
    if static < kinetic:
        yield Fault(
            "static_coefficient",
            f"below coefficient = {kinetic:g}",
            f"{static:g}",
            f"at least {kinetic:g}",
            "raise the one or lower the other",
        )


def rising(v0: float, v1: float) -> Iterator[Fault]:
    """Yield a fault where a ramp of friction between two speeds (m/s) does not rise."""
    if v1 <= v0:
        yield Fault(
            "v1",
            "friction would have no ramp between v0 and v1",
            f"{v1:g}",
            f"above v0 = {v0:g} m/s",
            "raise v1 or lower v0",
        )
