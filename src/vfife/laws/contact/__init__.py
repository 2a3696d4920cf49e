"""Normal contact laws, one file a law. A new law is a file here and a line below."""

from .hydrodynamic import Hydrodynamic
from .lankarani_nikravesh import LankaraniNikravesh
from .pereira import Pereira

__all__ = ["Hydrodynamic", "LankaraniNikravesh", "Pereira"]
