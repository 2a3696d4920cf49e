"""The verification suite: cases with a source, a reference and a tolerance, run by ``vfife verify``."""

from . import (
    beams,
    bearings,
    chaos,
    drives,
    equilibria,
    fourbars,
    guides,
    impacts,
    oscillators,
    pendulums,
    ranges,
    squeezer,
)
from .case import Case, Nudge, Row, entry, verified

CASES: dict[str, Case] = verified.cases

__all__ = [
    "CASES",
    "Case",
    "Nudge",
    "Row",
    "beams",
    "bearings",
    "chaos",
    "drives",
    "entry",
    "equilibria",
    "fourbars",
    "guides",
    "impacts",
    "oscillators",
    "pendulums",
    "ranges",
    "squeezer",
]
