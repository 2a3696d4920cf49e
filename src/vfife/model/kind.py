"""Base of the kinds of joints, springs, drivers and loads, which register themselves under a word."""

from __future__ import annotations

from typing import Any, ClassVar


class Kind:
    """Base of joints, springs, drivers and loads. The base class of each package has a ``registry``; every
    subclass with a ``kind`` enters it.
    """

    kind: ClassVar[str] = ""  # the word in a model file
    # Values of fields without a default, with which generic tests construct the kind.
    sample: ClassVar[dict[str, Any]] = {}
    registry: ClassVar[dict[str, Any]] = {}
    # Builders by name: fields that each does not accept, and optional fields that it requires. The default is
    # one builder named after the kind.
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Register a class that has a ``kind``, with a builder of that name unless it states others."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls
            if "builders" not in cls.__dict__:
                cls.builders = {cls.kind.replace("-", "_"): ()}
