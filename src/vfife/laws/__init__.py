"""Contact and friction laws, and what they need to know of the two surfaces."""

from .contact import Hydrodynamic, LankaraniNikravesh, Pereira
from .friction import Ambrosio, Frictionless
from .law import ContactLaw, FrictionLaw, Law, Material, Pair, quantity
from .materials import MATERIALS

__all__ = [
    "MATERIALS",
    "Ambrosio",
    "ContactLaw",
    "FrictionLaw",
    "Frictionless",
    "Hydrodynamic",
    "LankaraniNikravesh",
    "Law",
    "Material",
    "Pair",
    "Pereira",
    "quantity",
]
