"""Names that nouns had before: they work for one version more, and say what they are called now."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

Noun = TypeVar("Noun", bound=type)


def renamed(**names: str) -> Callable[[Noun], Noun]:
    """Lets a dataclass be made and read by the old ``names`` of its fields, old = new; every use is a DeprecationWarning.

    An old name that now means something else is taken as a keyword only.
    """

    def decorate(noun: Noun) -> Noun:
        made: Callable[..., None] = vars(noun)["__init__"]
        fields = {field.name for field in dataclasses.fields(noun)}

        @functools.wraps(made)
        def init(self: Any, *args: Any, **values: Any) -> None:
            for old in [old for old, new in names.items() if old in values and new in fields and old not in fields]:
                tell(noun, old, names[old])
                values[names[old]] = values.pop(old)
            made(self, *args, **values)

        setattr(noun, "__init__", init)  # noqa: B010 - a checker forbids the assignment
        for old, new in names.items():
            if inspect.getattr_static(noun, old, None) is None and old not in fields:
                setattr(noun, old, property(functools.partial(read, noun=noun, old=old, new=new), doc=f"``{new}``, as it was called before."))
        return noun

    return decorate


def read(self: Any, *, noun: type, old: str, new: str) -> Any:
    """The value under its new name."""
    tell(noun, old, new)
    return getattr(self, new)


def tell(noun: type, old: str, new: str) -> None:
    """Says the new name, at the line that used the old one."""
    warnings.warn(f"{noun.__name__}.{old} is called {new} now; the old name goes with the next version", DeprecationWarning, stacklevel=3)
