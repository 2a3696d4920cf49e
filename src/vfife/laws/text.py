"""How the functions of a user's own law are written: what their arguments are, and what the language of laws says of them."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any, NamedTuple

from .kinds import NUMBER, Kind, Several
from .language import Language
from .law import Law


class Part(NamedTuple):
    """A function of a law: its name, the kinds of its arguments, how many numbers it returns (a tuple of them where it is not 1), and what."""

    name: str
    kinds: tuple[Kind, ...]
    numbers: tuple[int, ...]
    what: str


def parts_of(law: Any, kind: str) -> list[Part]:
    """The functions that a law has."""
    slots = Several((NUMBER,) * len(law.slots), slots=True)
    if kind == "friction":
        rows = len(law.memory)
        memory: Kind = Several((NUMBER,) * rows) if rows > 1 else NUMBER
        what = (
            "two numbers, the friction force (N) and the memory"
            if rows < 2
            else f"the friction force (N) and a tuple of {rows} numbers to remember"
        )
        found = [Part("force", (NUMBER, NUMBER, NUMBER, memory, NUMBER, slots), (1, max(rows, 1)), what)]
        return [*found, Part("regime", (NUMBER, slots), (1,), "one number")] if law.regime is not None else found
    what = "two numbers, the elastic force (N) and the damping coefficient (N s/m)"
    found = [Part("force", (NUMBER, NUMBER, slots), (1, 1), what)]
    return [*found, Part("film_force", (NUMBER,) * 3 + (slots,), (1,) * 5, "five finite numbers")] if law.film else found


def place(law: type[Law]) -> str:
    """Which law is meant: its name, class, file and line."""
    function = getattr(law, "force", None)
    code = getattr(function, "__code__", None)
    where = f"{code.co_filename}, line {code.co_firstlineno}, " if code is not None and law.__module__ != "vfife.laws.law" else ""
    return f"{where}law {law.name!r} ({law.__name__})"


def faults_of_text(function: Callable[..., Any], part: Part) -> list[str]:
    """What the language of laws does not have in a function and in those that it calls; raises OSError where a text cannot be read."""
    if not isinstance(function, FunctionType):
        return [f"{part.name} is no plain function; write it as a `def` in the class"]
    return Language().examine(function, part.kinds, part.numbers, part.what)
