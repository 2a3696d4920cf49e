"""Motion, forces, energies and measures computed from a record, as arrays and numbers."""

from .catalogue import influence, lip, measures
from .energy import Ledger, ledger
from .error_ranges import ranged
from .turns import last_turn
from .values import Measured, Measures

__all__ = ["Ledger", "Measured", "Measures", "influence", "last_turn", "ledger", "lip", "measures", "ranged"]
