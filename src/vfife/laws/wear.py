"""Wear coefficients of pairs of materials by name, as their sources have them.

Archard's law, V = K F s/H: volume V that a surface loses under a normal force F over a sliding distance s, H its hardness, K a number of the pair.
What a machine needs is k = K/H in 1/Pa; 1 mm^3/(N m) is 1e-9 1/Pa. Tests of one pair differ by a factor of ten from each other (``SCATTER``), and
oil changes K by a factor of a thousand and more (``OILED``): a coefficient that was measured on the pair at hand is worth more than any table.
"""

from __future__ import annotations

from .law import Material
from .materials import hardness_of

ARCHARD = (
    "Archard: Contact and rubbing of flat surfaces, J. Appl. Phys. 24, 981 (1953), and Archard, Hirst: The wear of metals under unlubricated "
    "conditions, Proc. R. Soc. A 236, 397 (1956), as tables of wear coefficients repeat them"
)

SCATTER = 10.0  # tests of one pair lie within so many times of K to either side
OILED = 1e-3  # of K, and less, where oil separates the surfaces
# Name: K (1) of the surface that is named first, dry in air; source.
PAIRS: dict[str, tuple[float, str]] = {
    "mild steel on mild steel": (7e-3, ARCHARD),
    "brass on tool steel": (6e-4, ARCHARD),
    "tool steel on tool steel": (1.3e-4, ARCHARD),
    "beryllium copper on tool steel": (3.7e-5, ARCHARD),
    "ptfe on tool steel": (2.5e-5, ARCHARD),
    "ferritic stainless steel on tool steel": (1.7e-5, ARCHARD),
    "pmma on tool steel": (7e-6, ARCHARD),
    "polyethylene on tool steel": (1.3e-7, ARCHARD),
}


def coefficient(named: float | str, material: Material) -> float | None:
    """k (1/Pa) of a surface: the number itself, or that of a pair over the hardness of the surface's material; None where that is not known."""
    if not isinstance(named, str):
        return named
    hardness = hardness_of(material)
    return None if hardness is None else PAIRS[named][0] / hardness
