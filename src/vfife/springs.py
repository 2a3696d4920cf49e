"""Springs, dampers, stops and bushings."""

from .model.springs import *  # noqa: F403
from .model.springs import __all__ as __all__
