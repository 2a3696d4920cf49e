"""Drivers: prescribed motions, torques and forces."""

from .model.drivers import *  # noqa: F403
from .model.drivers import __all__ as __all__
