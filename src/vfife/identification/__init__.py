"""Numbers of a model from measurements: misfits and their derivatives, searches, and how far what was found
can be trusted.
"""

from ..results.fit import load_fit
from .fitting import fit
from .records import Record

__all__ = ["Record", "fit", "load_fit"]
