"""Identification of model parameters from measurements: residuals and their derivatives, searches, and the
uncertainty of the result.
"""

from importlib import import_module

from ..results.fit import load_fit
from .fit_task import fit
from .records import Record

__all__ = ["Record", "fit", "load_fit"]
import_module("..methods", __name__).attach()
