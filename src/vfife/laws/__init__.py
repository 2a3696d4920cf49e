"""Contact and friction laws, and what they need to know of the two surfaces."""

from . import contact, friction
from .contact import *  # noqa: F403
from .friction import *  # noqa: F403
from .law import ContactLaw, FrictionLaw, Law, Material, Pair, quantity
from .materials import MATERIALS
from .user import load_laws

__all__ = ["MATERIALS", "ContactLaw", "FrictionLaw", "Law", "Material", "Pair", "load_laws", "quantity"]
__all__ += contact.__all__
__all__ += friction.__all__
