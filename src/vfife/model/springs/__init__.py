"""Massless force elements between two bodies, one file each: springs and dampers along a line or about an
axis, stops and bushings.
"""

from .bushing import Bushing
from .force_element import ForceElement as ForceElement
from .linear import Spring
from .stop import Stop
from .torsional import TorsionalSpring

AnySpring = ForceElement

# What all of them share is imported by its name; the kinds are public, and those of vfife too.
__all__ = ["Bushing", "Spring", "Stop", "TorsionalSpring"]
