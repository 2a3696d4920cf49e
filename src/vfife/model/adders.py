"""How a builder adds a noun to a mechanism: what it is given is read by the noun's own fields, and told at once where it is wrong."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from ..errors import ArgumentError, Fault, ModelError, Path, shown, suggestion
from ..fields import Field, described_fields, key_of, meaning_of, partial, required, value_of
from .given import Given, idle

if TYPE_CHECKING:
    from .mechanism import Mechanism

Arguments = ParamSpec("Arguments")
Noun = TypeVar("Noun")
TARGETS = ("body", "slider", "point")  # what a driver is called after, where it has no name: of a pin without its dot
BUILDERS: dict[str, dict[str, list[str]]] = {}  # of each section, with their keywords


def adds(section: str, noun: type[Noun]) -> Callable[[Callable[Arguments, Noun]], Callable[Arguments, Noun]]:
    """Makes a builder of a signature: its arguments become the noun, which joins those of its ``section`` under its name.

    The signature is written out because editors, type checkers and notebooks read it; a test holds it against the fields of the noun. A keyword
    that is left out is left to the noun. The builder raises ModelError with all faults of what it is given, and ArgumentError, which is a TypeError
    too, where a keyword is misspelt or missing.
    """

    def decorate(signed: Callable[Arguments, Noun]) -> Callable[Arguments, Noun]:
        wanted = list(inspect.signature(signed).parameters.values())[1:]
        names = [one.name for one in wanted]
        leading = [one.name for one in wanted if one.kind is one.POSITIONAL_OR_KEYWORD]
        needed = [one.name for one in wanted if one.default is one.empty]

        BUILDERS.setdefault(section, {})[signed.__name__] = names
        signed.__doc__ = f"{signed.__doc__}\n\n{keywords(noun, names)}"

        @functools.wraps(signed)
        def add(*args: Any, **given: Any) -> Any:
            mechanism, *places = args
            found = dict(zip(leading, places, strict=False)) | given
            name = found.get("name") or next((called(found[one]) for one in TARGETS if found.get(one)), None)
            path: Path = (section, name if isinstance(name, str) else "?")
            faults = strange(path, names, leading, places, given) + [
                Fault((*path, one), "this keyword is missing", remedy=f"add {one}=...") for one in needed if one not in found
            ]
            known = {key: value for key, value in found.items() if key in names}
            made, more = read(path, noun, known)
            more += alone(mechanism, section, name, made, more)
            if faults or more:
                raise (ArgumentError if faults else ModelError)([*faults, *more], str(mechanism.name) or "mechanism")
            nouns(mechanism, section)[str(name)] = made
            return made

        return add

    return decorate


def called(target: Any) -> Any:
    """The name of what has none of its own."""
    return target.replace(".", " ") if isinstance(target, str) else target


def keywords(noun: Any, names: list[str]) -> str:
    """What a builder takes, a line for each: the meaning of its field, with units and limits."""
    lines = []
    for field in described_fields(noun):
        if field.name in names:
            units = "; ".join(dict.fromkeys(value_of(field).units()))
            lines.append(f"        {field.name}: {meaning_of(field)}{f' [{units}]' if units else ''}")
    return "\n".join(lines)


def strange(path: Path, names: list[str], leading: list[str], places: list[Any], given: Mapping[str, Any]) -> list[Fault]:
    """Arguments that there are not, or that come twice."""
    found = []
    for key, value in given.items():
        if key not in names:
            others = [f"{name}()" for name, keys in BUILDERS.get(str(path[0]), {}).items() if key == name or key in keys]
            advice = f"use {' or '.join(others[:3])} for it" if others else "remove it"
            found.append(Fault((*path, key), "there is no such keyword", shown(value), "", suggestion(key, names, advice)))
        elif key in leading[: len(places)]:
            found.append(Fault((*path, key), "this is given twice", shown(value), "", "give it once"))
    if len(places) > len(leading):
        what, rest = f"only {', '.join(leading)} stand without a keyword", [name for name in names if name not in leading]
        found.append(Fault((*path, ""), what, shown(places[len(leading)]), "", f"write {rest[0]}=..." if rest else "leave it out"))
    return found


def read(path: Path, noun: Any, given: Mapping[str, Any]) -> tuple[Any, list[Fault]]:
    """The noun of what is given, known in part where something is refused, and what is."""
    reading, values = Given(), {key: given[key] for key in ("name",) if key in given}
    along = bool(given.get("slider") or given.get("point"))
    fields: dict[str, Field] = {field.name: field for field in described_fields(noun)}
    for key, field in fields.items():
        if key not in given or (given[key] is None and field.default is None):
            continue
        at = (*path, key_of(field, along))
        values[key] = value_of(field, along).read(given[key], at, reading)
        if users := unused(noun, fields, key, given):
            reading.add(idle(noun, given[noun.selected_by], users, given[key]).at(at))
    lacking = [key for key, field in fields.items() if required(field) and key not in values]
    return (partial if lacking or reading.faults else made)(noun, values), reading.faults


def made(noun: Any, values: Mapping[str, Any]) -> Any:
    """The noun."""
    return noun(**values)


def unused(noun: Any, fields: Mapping[str, Field], key: str, given: Mapping[str, Any]) -> tuple[str, ...]:
    """Models that would have a use for a value that is no default, where the model that is named has none."""
    only, field = fields[key].metadata.get("only"), fields[key]
    word = given.get(getattr(noun, "selected_by", ""))
    default = field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
    if not only or word is None or word in only or given[key] == default or word not in fields[noun.selected_by].metadata["choices"]:
        return ()
    return tuple(only)


def alone(mechanism: Mechanism, section: str, name: Any, noun: Any, told: list[Fault]) -> list[Fault]:
    """What is wrong with a name, and with a noun among those there; pins of bodies that come later are looked for in a whole mechanism."""
    from .validate.single import faults_of

    if not isinstance(name, str):
        return [] if name is None else [Fault((section, "?"), "this is no name", shown(name), "a text", "put it in quotes")]
    if name in nouns(mechanism, section):
        what = f"there is a {section} called {shown(name)} already"
        return [Fault((section, name, ""), what, "", "", "choose another name")]
    return faults_of(mechanism, section, name, noun, [fault.path for fault in told])


def nouns(mechanism: Mechanism, section: str) -> dict[str, Any]:
    """The nouns of a section by name."""
    field = next(field for field in described_fields(type(mechanism)) if key_of(field) == section)
    found: dict[str, Any] = getattr(mechanism, field.name)
    return found
