"""Friction laws, one file a law. A new law is a file here and a line below."""

from .ambrosio import Ambrosio
from .none import Frictionless

__all__ = ["Ambrosio", "Frictionless"]
