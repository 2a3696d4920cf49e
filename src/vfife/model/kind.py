"""What makes a class of nouns a kind: a word in a model file, by which its package finds it."""

from __future__ import annotations

from typing import Any, ClassVar


class Kind:
    """Base of joints, springs, drivers and loads. The base in each package has a ``registry``, which each
    class below it with a ``kind`` enters.
    """

    kind: ClassVar[str] = ""  # the word in a model file
    sample: ClassVar[
        dict[str, Any]
    ] = {}  # for fields without a default, sizes with which a test walks its stops
    registry: ClassVar[dict[str, Any]] = {}
    # Methods of a mechanism that add it: keywords that each does not take, and those that it cannot do
    # without. Named after the kind if not said.
    builders: ClassVar[dict[str, tuple[tuple[str, ...], ...]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers a kind."""
        super().__init_subclass__(**kwargs)
        if cls.__dict__.get("kind"):
            cls.registry[cls.kind] = cls
            if "builders" not in cls.__dict__:
                cls.builders = {cls.kind.replace("-", "_"): ()}
