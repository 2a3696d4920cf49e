"""Wear over many turns: depths, volumes, worn profiles, cycle jumps, and the life of joints."""

from ..model.wear import Wear
from .simulate_wear import load_wear, wear
from .wear_state import Worn

__all__ = ["Wear", "Worn", "load_wear", "wear"]
