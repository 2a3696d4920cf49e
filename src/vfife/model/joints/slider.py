"""The ideal slider, and the pin in a straight slot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...fields import Direction, Switch, described
from .joint import Joint, Point


@dataclass(frozen=True, kw_only=True)
class Slider(Joint):
    """The journal's pin moves along a straight guide through the bearing's pin.

    ``direction`` is that of the guide, in the frame of the bearing's body. The two bodies keep their relative angle (that of the closed start)
    unless ``turning``: then the journal is a pin in a slot.
    """

    kind: ClassVar[str] = "slider"

    direction: Point = described(Direction(), "direction of the guide in the frame of the bearing's body", (1.0, 0.0))
    turning: bool = described(Switch(), "true: a pin in a slot, free to turn; false: the bodies keep their relative angle", False)
