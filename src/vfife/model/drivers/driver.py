"""What all drivers share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What is driven: the angle of ``body``, the travel of the joint ``slider``, or the pin ``point`` along ``direction`` (fixed in space).

    The angle (rad) counts from the body's start angle; a body turns about its one ideal revolute to the ground, or, with ``against``, relative
    to another body. Travel and path (m) count from the start.
    """

    body: str = ""
    slider: str = ""
    point: str = ""
    direction: Point = (1.0, 0.0)
    against: str = "ground"

    kind: ClassVar[str] = ""  # the word in a model file; a class that has one of its own is a kind
    registry: ClassVar[dict[str, type[Driver]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls
