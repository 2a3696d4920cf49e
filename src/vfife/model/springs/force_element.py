"""What all massless elements of force share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...fields import Text, described


@dataclass(frozen=True, kw_only=True)
class ForceElement:
    """A massless element between ``first`` and ``second``: pins (``body.pin`` or ``ground.point``), or bodies where it acts about the axis."""

    name: str
    first: str = described(Text("pin"), 'one end, "body.pin" or "ground.point"')
    second: str = described(Text("pin"), 'the other end, "body.pin" or "ground.point"')

    kind: ClassVar[str] = ""  # the word in a model file; a class that has one of its own is a kind
    registry: ClassVar[dict[str, type[ForceElement]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls
