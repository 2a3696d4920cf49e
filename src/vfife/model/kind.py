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
    builder: ClassVar[str] = ""  # name of the builder of a mechanism, if it is not the kind
    # Builders by name, if a class has several or they differ from its fields: the fields that each does not
    # accept, and optional fields that it requires.
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Register a class that has a ``kind``, with a builder of that name unless it states others."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls
            if "builders" not in cls.__dict__:
                cls.builders = {cls.__dict__.get("builder") or cls.kind.replace("-", "_"): ()}
