"""From a record to motion, forces, energies and measures: arrays and numbers, without datasets and without
kernels.
"""

from .catalogue import influence, last_turn, lip, measures
from .energy import Ledger, ledger
from .measured import Measured, Measures
from .ranges import ranged

__all__ = ["Ledger", "Measured", "Measures", "influence", "last_turn", "ledger", "lip", "measures", "ranged"]
