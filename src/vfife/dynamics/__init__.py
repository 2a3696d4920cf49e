"""Nonlinear dynamics: bifurcation diagrams, Poincaré sections, basins of attraction, waterfalls, spectra and
modes.
"""

from ..measures.modes import modes
from ..results.spectra import envelope, spectrogram, spectrum
from .basins import basins
from .bifurcation import bifurcation
from .load_map import load_map
from .sections import poincare_section
from .waterfall import waterfall

__all__ = [
    "basins",
    "bifurcation",
    "envelope",
    "load_map",
    "modes",
    "poincare_section",
    "spectrogram",
    "spectrum",
    "waterfall",
]
