"""From a record to motion, forces, energies and measures: arrays and numbers, without datasets and without kernels."""

from .energy import Ledger, ledger
from .influence import influence, lip
from .measures import last_turn, measures

__all__ = ["Ledger", "influence", "last_turn", "ledger", "lip", "measures"]
