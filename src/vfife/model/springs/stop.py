"""Rotational stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Text, described, quantity
from .force_element import ForceElement


@dataclass(frozen=True, kw_only=True)
class Stop(ForceElement):
    """Rotational stop: the angle of the second body less that of the first stays between ``low`` and ``high`` (rad).

    Beyond either the stop answers like a torsional spring and damper (N m/rad, N m s/rad); it never pulls back.
    """

    kind: ClassVar[str] = "stop"

    first: str = described(Text("body"), "a body, or ground")
    second: str = described(Text("body"), "another body, or ground")
    low: float = quantity("rad", "least angle of the second body less that of the first")
    high: float = quantity("rad", "largest angle of the second body less that of the first")
    stiffness: float = quantity("N m/rad", "stiffness beyond the limits", above=0.0)
    damping: float = quantity("N m s/rad", "damping beyond the limits", 0.0, low=0.0)
