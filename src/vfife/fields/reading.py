"""Who reads values, and what is left of a noun of which one was refused."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import MISSING
from typing import Any

from ..errors import Fault, Path, kind_of
from .described import described_fields, key_of, value_of


class Reading:
    """Who reads values: keeps all faults, with their paths. From Python numbers are numbers; a ``written`` one may be a text with a unit."""

    written = False

    def __init__(self) -> None:
        self.faults: list[Fault] = []

    def add(self, fault: Fault) -> None:
        """Keeps a fault."""
        self.faults.append(fault)

    def refuse(self, path: Path, what: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        """Keeps the fault of what is at a path."""
        self.add(Fault(path, what, value, limit, remedy))

    def noun(self, path: Path, kind: type, value: Any) -> Any:
        """A noun in a field of another."""
        return self.one_of(path, kind, value)

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """A noun that a file calls by its name."""
        return self.one_of(path, kind, value)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """A law, of those that there are."""
        return self.one_of(path, base, value)

    def one_of(self, path: Path, kind: type, value: Any) -> Any:
        """The value if it is of the kind, its own fields being read."""
        if not isinstance(value, kind):
            what = kind_of(value) if type(value).__module__ == "builtins" else f"a {type(value).__name__}"
            self.refuse(path, f"this is {what}", "", f"a {kind.__name__}", f"give a {kind.__name__}")
            return None
        return self.fields(path, value)

    def fields(self, path: Path, noun: Any, along: bool = False) -> Any:
        """The noun as it was read, with None in place of every value that is refused."""
        found = {}
        for field in described_fields(type(noun)):
            value = getattr(noun, field.name)
            if not (value is None and field.default is None):
                found[field.name] = value_of(field, along).read(value, (*path, key_of(field, along)), self)
        return partial(type(noun), vars(noun) | found)


def partial(noun: type, values: Mapping[str, Any]) -> Any:
    """A noun of which only some values are known: None stands for the others, so that what does not hang on them can still be checked."""
    made: Any = object.__new__(noun)
    for field in dataclasses.fields(noun):
        default = field.default_factory() if field.default_factory is not MISSING else None if field.default is MISSING else field.default
        object.__setattr__(made, field.name, values.get(field.name, default))
    return made
