"""What all joints share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...fields import Text, described

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Joint:
    """Two pins in one place: ``bearing`` and ``journal`` are ``body.pin`` or ``ground.point``."""

    name: str
    bearing: str = described(Text("pin"), 'the bearing side, "body.pin" or "ground.point"')
    journal: str = described(Text("pin"), 'the journal side, "body.pin" or "ground.point"')

    kind: ClassVar[str] = ""  # the word in a model file; a class that has one of its own is a kind
    registry: ClassVar[dict[str, type[Joint]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """(body, pin) of the bearing and of the journal."""
        bearing, journal = self.bearing.partition("."), self.journal.partition(".")
        return (bearing[0], bearing[2]), (journal[0], journal[2])
