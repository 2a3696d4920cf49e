"""Wear over many turns: depths and volumes, worn profiles, jumps over cycles, and lives."""

from ..model.wear import Wear
from .simulate_wear import load_wear, wear
from .wear_state import Worn

__all__ = ["Wear", "Worn", "load_wear", "wear"]
