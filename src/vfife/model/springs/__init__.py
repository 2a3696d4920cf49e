"""Massless elements of force between two bodies, one file each: springs and dampers along a line, about an axis, stops and bushings."""

from __future__ import annotations

from .bushing import Bushing
from .force_element import ForceElement
from .linear import Spring
from .stop import Stop
from .torsional import TorsionalSpring

AnySpring = Spring | TorsionalSpring | Stop | Bushing

__all__ = ["AnySpring", "Bushing", "ForceElement", "Spring", "Stop", "TorsionalSpring"]
