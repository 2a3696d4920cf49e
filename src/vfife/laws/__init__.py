"""Contact and friction laws, and what they need to know of the two surfaces."""

from .contact import LankaraniNikravesh, Pereira
from .friction import Ambrosio, BrownMcPhee, Coulomb, Dahl, Frictionless, Karnopp, LuGre, Stribeck
from .law import ContactLaw, FrictionLaw, Law, Material, Pair, quantity

__all__ = [
    "Ambrosio",
    "BrownMcPhee",
    "ContactLaw",
    "Coulomb",
    "Dahl",
    "FrictionLaw",
    "Frictionless",
    "Karnopp",
    "LankaraniNikravesh",
    "Law",
    "LuGre",
    "Material",
    "Pair",
    "Pereira",
    "Stribeck",
    "quantity",
]
