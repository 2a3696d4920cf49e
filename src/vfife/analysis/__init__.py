"""From a record to motion, forces, energies and measures: arrays and numbers, without datasets and without kernels."""

from .energy import Ledger, ledger
from .influence import influence, lip
from .measures import last_turn, measures
from .ranges import Measured, ranged

__all__ = ["Ledger", "Measured", "influence", "last_turn", "ledger", "lip", "measures", "ranged"]
