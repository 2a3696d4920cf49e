"""Friction laws, one file a law. A new law is a file here and a line below."""

from .ambrosio import Ambrosio
from .brown_mcphee import BrownMcPhee
from .coulomb import Coulomb
from .dahl import Dahl
from .karnopp import Karnopp
from .lugre import LuGre
from .none import Frictionless
from .stribeck import Stribeck

__all__ = ["Ambrosio", "BrownMcPhee", "Coulomb", "Dahl", "Frictionless", "Karnopp", "LuGre", "Stribeck"]
