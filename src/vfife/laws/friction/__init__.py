"""Friction laws, one file a law. A new law is a file here and a line below."""

from .ambrosio import Ambrosio
from .bengisu_akay import BengisuAkay
from .brown_mcphee import BrownMcPhee
from .coulomb import Coulomb
from .dahl import Dahl
from .gonthier import GonthierFriction
from .karnopp import Karnopp
from .lugre import LuGre
from .none import Frictionless
from .stribeck import Stribeck
from .threlfall import Threlfall

__all__ = [
    "Ambrosio",
    "BengisuAkay",
    "BrownMcPhee",
    "Coulomb",
    "Dahl",
    "Frictionless",
    "GonthierFriction",
    "Karnopp",
    "LuGre",
    "Stribeck",
    "Threlfall",
]
