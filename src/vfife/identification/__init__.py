"""Numbers of a model from measurements: misfits and their derivatives, searches, and how far what was found
can be trusted.
"""

from ..results.fit import load_fit
from .fitting import fit

__all__ = ["fit", "load_fit"]
