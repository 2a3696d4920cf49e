"""Identification of model parameters from measurements: residuals and their derivatives, searches, and the
uncertainty of the result.
"""

from .. import methods
from ..results.fit import load_fit
from .fit_task import fit
from .records import Record

__all__ = ["Record", "fit", "load_fit"]
methods.attach()
