"""Loads: forces and moments at a pin or along a guide."""

from .model.loads import *  # noqa: F403
from .model.loads import __all__ as __all__
