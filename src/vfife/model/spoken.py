"""Settings and sections made by a script: quantities may be texts with a unit there as well, and a misspelt keyword gets a sentence."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, TypeVar

from ..errors import ArgumentError, Fault, ModelError, Path, shown, suggestion
from ..fields import Choice, Text, described_fields, key_of, value_of
from .given import Given

Noun = TypeVar("Noun", bound=type)


def spoken(*path: str) -> Callable[[Noun], Noun]:
    """Lets a dataclass take texts with units where it holds quantities. ``path``: where it stands in a model file.

    Making one raises ArgumentError for a keyword that it does not have, and ModelError for a text that is no such quantity. Numbers are looked at
    when the whole mechanism is.
    """

    def decorate(noun: Noun) -> Noun:
        made: Callable[..., None] = vars(noun)["__init__"]
        names = [field.name for field in dataclasses.fields(noun)]
        held = {field.name: (key_of(field), value_of(field)) for field in described_fields(noun)}
        quantities = {name for name, (_, value) in held.items() if not isinstance(value, Text | Choice)}

        @functools.wraps(made)
        def init(self: Any, *args: Any, **values: Any) -> None:
            faults = [strange((*path, key), value, names) for key, value in values.items() if key not in names]
            if faults:
                raise ArgumentError(faults, f"{noun.__name__}()")
            given, reading = dict(zip(names, args, strict=False)) | values, Given()
            if len(args) <= len(names):
                for name in quantities & given.keys():
                    if written(given[name]):
                        given[name] = held[name][1].read(given[name], (*path, held[name][0]), reading)
                args, values = (), given
            if reading.faults:
                raise ModelError(reading.faults, f"{noun.__name__}()")
            made(self, *args, **values)

        setattr(noun, "__init__", init)  # noqa: B010 - a checker forbids the assignment
        return noun

    return decorate


def strange(path: Path, value: Any, names: list[str]) -> Fault:
    """A keyword that there is not."""
    return Fault(path, "there is no such keyword", shown(value), "", suggestion(str(path[-1]), names, "remove it"))


def written(value: Any) -> bool:
    """Whether a text is given where a quantity stands, or among those of a list."""
    return isinstance(value, str) or (isinstance(value, tuple | list) and any(isinstance(one, str) for one in value))
