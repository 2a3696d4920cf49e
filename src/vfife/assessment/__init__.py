"""Decisions on clearances: which one matters, which fits keep a limit, how long joints last."""

from .answer import Design, JointDesign
from .design_work import design

__all__ = ["Design", "JointDesign", "design"]
