"""Methods that add bodies, joints, gears, springs, drivers and loads to a mechanism.

:meth:`Builders.add` takes an object; one method for each kind takes the fields of its class. These methods
are generated; ``builders.pyi`` contains their signatures for editors and type checkers (``python
tests/model/stubs.py``). Quantities are numbers in SI units or texts with a unit ("100 mm"). Laws and
materials are objects or names; laws and sections may also be tables of a model file: ``contact={"law":
"hertz", ...}``, ``section={"round": "20 mm"}``.
"""

from __future__ import annotations

import dataclasses
import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import Parameter as Argument
from typing import TYPE_CHECKING, Any, cast

from ..errors import ArgumentError, Fault, ModelError, Path, shown, suggestion
from ..schema import (
    PLACE,
    Choice,
    Chosen,
    Field,
    FixedList,
    FreeList,
    Inner,
    Integer,
    Measure,
    Named,
    Names,
    Switch,
    Value,
    default_of,
    described_fields,
    key_of,
    meaning_of,
    partial,
    required,
    value_of,
)
from .bodies import Body, Frame, Link, Pin, PointMass, RigidBody
from .drivers import Driver
from .joints import Gear, Joint
from .kind import Kind
from .loads import Load
from .readers import ScriptReader, idle, users_of
from .springs import ForceElement
from .validation import faults_of

if TYPE_CHECKING:
    from .mechanism import Mechanism

# Fields from which a driver without a name takes it; the dot of a pin becomes a space.
TARGETS = ("body", "slider", "point")
SECTIONS: dict[type, str] = {
    Body: "body",
    Joint: "joint",
    Gear: "gear",
    ForceElement: "spring",
    Driver: "driver",
    Load: "load",
}
# Builders of classes that are no kinds: they have no registry.
WITHOUT_KIND: dict[str, type] = {
    "link": Link,
    "rigid_body": RigidBody,
    "point_mass": PointMass,
    "frame": Frame,
    "gear": Gear,
}


@dataclass(frozen=True)
class Builder:
    """Specification of a builder method: its name, the section and class of what it adds, ``omitted`` fields
    that it does not accept, and optional fields that it requires (``needed``).
    """

    name: str
    section: str
    kind: Any
    omitted: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()

    @property
    def fields(self) -> dict[str, Field]:
        """Accepted fields, by name."""
        named = [field for field in dataclasses.fields(self.kind) if field.name == "name"]
        return {
            field.name: field
            for field in (*named, *described_fields(self.kind))
            if field.name not in self.omitted
        }

    @property
    def arguments(self) -> list[Argument]:
        """Arguments of the method: the name and what it connects by position, all others by keyword."""
        arguments = []
        for name, field in self.fields.items():
            value_type = None if name == "name" else value_of(field)
            needed = name in self.needed or required(field)
            leading = (
                name == "name"
                or (needed and bool(getattr(value_type, "refers", "")))
                or (name == "body" and self.section == "driver")
            )
            default = default_of(field)
            default = Argument.empty if needed else getattr(default, "name", default)
            annotation = (
                "str"
                if value_type is None
                else annotation_of(value_type) + (" | None" if default is None else "")
            )
            kind = Argument.POSITIONAL_OR_KEYWORD if leading else Argument.KEYWORD_ONLY
            arguments.append(Argument(name, kind, default=default, annotation=annotation))
        return sorted(arguments, key=lambda argument: (argument.kind, argument.default is not Argument.empty))

    @property
    def help(self) -> str:
        """Docstring of the method: what it adds, one line per argument with its meaning and units, what it
        returns and raises.
        """
        summary = (inspect.getdoc(self.kind) or "").partition("\n\n")[0]
        lines = [f"Add {summary[:1].lower()}{summary[1:]}", ""]
        for name, field in self.fields.items():
            if name == "name":
                lines.append(f"name: unique name of the {self.section}")
            else:
                units = "; ".join(dict.fromkeys(value_of(field).units()))
                lines.append(f"{name}: {meaning_of(field)}{f' [{units}]' if units else ''}")
        return "\n".join([*lines, "", f"Returns the {self.section}. Raises ModelError with all its faults."])

    def method(self) -> Callable[..., Any]:
        """Return the method, with its signature and docstring."""
        arguments = self.arguments
        leading = [argument.name for argument in arguments if argument.kind is Argument.POSITIONAL_OR_KEYWORD]

        def add(mechanism: Mechanism, *places: Any, **values: Any) -> Any:
            arguments_by_name = dict(zip(leading, places, strict=False)) | values
            path = (self.section, str(arguments_by_name.get("name") or called(arguments_by_name)))
            faults = strange(path, self, leading, places, values)
            lacking = [
                argument.name
                for argument in arguments
                if argument.default is Argument.empty and argument.name not in arguments_by_name
            ]
            faults += [
                Fault((*path, keyword), "this keyword is missing", remedy=f"add {keyword}=...")
                for keyword in lacking
            ]
            return admit(
                mechanism,
                self.kind,
                {key: value for key, value in arguments_by_name.items() if key in self.fields},
                faults=faults,
            )

        add.__name__, add.__qualname__, add.__doc__ = self.name, f"Mechanism.{self.name}", self.help
        signature = inspect.Signature(
            [Argument("self", Argument.POSITIONAL_OR_KEYWORD), *arguments],
            return_annotation=self.kind.__name__,
        )
        cast(Any, add).__signature__ = signature
        return add


def builders() -> dict[str, Builder]:
    """Return all builders by name: bodies, gears and every registered kind."""
    specifications = [Builder(name, section_of(kind), kind) for name, kind in WITHOUT_KIND.items()]
    for base, section in SECTIONS.items():
        for kind in vars(base)["registry"].values() if issubclass(base, Kind) else ():
            specifications += [
                Builder(name, section, kind, *exceptions) for name, exceptions in kind.builders.items()
            ]
    return {builder.name: builder for builder in specifications}


def annotation_of(value_type: Value) -> str:
    """Return the type annotation of a builder argument, as source text."""
    if isinstance(value_type, Measure):
        return "Quantity | Sequence[Quantity]" if value_type.series else "Quantity"
    if isinstance(value_type, FixedList):
        return "Place"
    if isinstance(value_type, FreeList):
        return f"Sequence[{annotation_of(value_type.part)}]"
    if isinstance(value_type, Names):
        return f"Mapping[str, {annotation_of(value_type.part)}]"
    if isinstance(value_type, Choice):
        return f"Literal[{', '.join(map(shown, value_type.options))}]"
    if isinstance(value_type, Inner | Named):
        return f"{value_type.model_class.__name__} | {'Table' if isinstance(value_type, Inner) else 'str'}"
    if isinstance(value_type, Chosen):
        return f"{value_type.base.__name__} | str | Table"
    named = {"body": "str | Body", "joint": "str | Joint"}
    return (
        "int"
        if isinstance(value_type, Integer)
        else "bool"
        if isinstance(value_type, Switch)
        else named.get(getattr(value_type, "refers", ""), "str")
    )


class Builders:
    """Base of :class:`Mechanism` with the methods that add to it; those of the kinds are attached at the end
    of this module.
    """

    if TYPE_CHECKING:
        name: str
        points: dict[str, tuple[float, float]]

    def point(self, name: str, x: Any, y: Any) -> Pin:
        """Add a point of the ground at (``x``, ``y``) in m and return its pin. Raises ModelError for an
        invalid position and for a name that is invalid or in use.
        """
        reader, at = ScriptReader(), ("ground", str(name))
        place = PLACE.read((x, y), at, reader)
        if not name or "." in str(name):
            reader.refuse(
                ("ground", ""),
                f"the name {shown(name)} cannot be part of a path",
                remedy="choose a name without dots",
            )
        elif name in self.points:
            reader.refuse(at, f"there is a point called {shown(name)} already", remedy="choose another name")
        if reader.faults:
            raise ModelError(reader.faults, str(self.name) or "mechanism")
        self.points[name] = place
        return Pin(f"ground.{name}")

    def clearance(self, *places: Any, **values: Any) -> Any:
        """Add a revolute joint with clearance and return it: former name of ``clearance_joint``, with a
        DeprecationWarning.

        places, values: positional and keyword arguments of ``clearance_joint``
        """
        warnings.warn(
            "Mechanism.clearance() is called clearance_joint() now", DeprecationWarning, stacklevel=2
        )
        return getattr(self, "clearance_joint")(*places, **values)  # noqa: B009 - the method is set below

    def add(self, item: Any, name: str | None = None) -> Any:
        """Add a body, joint, gear, spring, driver or load and return it.

        item: the object, checked as its builder checks its arguments
        name: its name in the mechanism, by default ``item.name``; a driver without one takes the name of the
        body, slider or point it drives

        Raises ModelError with all faults, and TypeError for other objects.
        """
        return admit(cast("Mechanism", self), type(item), vars(item), name)


def admit(
    mechanism: Mechanism, kind: Any, raw: Mapping[str, Any], name: Any = None, faults: Sequence[Fault] = ()
) -> Any:
    """Read the values of a class, check the object against the mechanism, add and return it.

    ``raw`` has the values by field name, ``faults`` those already known of the call. Raises ModelError, or
    ArgumentError if ``faults`` is not empty, with all faults. Pins of bodies that are not yet in the
    mechanism are checked by :func:`~vfife.model.validation.validate`.
    """
    section, name = section_of(kind), name or raw.get("name") or called(raw) or raw.get("name")
    path: Path = (section, name if isinstance(name, str) else "?")
    item, refused = read(path, kind, raw)
    if not isinstance(name, str) and (name is not None or section != "driver"):
        refused.append(Fault(path, "this is not a name", repr(name), "a text", "put it in quotes"))
    elif name in items(mechanism, section):
        refused.append(
            Fault(
                (*path, ""),
                f"there is a {section} called {shown(name)} already",
                remedy="choose another name",
            )
        )
    elif name is not None:
        refused += faults_of(mechanism, section, name, item, [fault.path for fault in refused])
    if faults or refused:
        raise (ArgumentError if faults else ModelError)(
            [*faults, *refused], str(mechanism.name) or "mechanism"
        )
    items(mechanism, section)[str(name)] = item
    return item


def section_of(kind: type) -> str:
    """Return the section of a model file that contains objects of a class. Raises TypeError if none does."""
    for base, section in SECTIONS.items():
        if issubclass(kind, base):
            return section
    raise TypeError(
        f"a mechanism has no {kind.__name__}; it has bodies, joints, gears, springs, drivers and loads"
    )


def called(values: Mapping[str, Any]) -> Any:
    """Return the name of an object without one: the target of a driver, else None."""
    target = next((values[target_key] for target_key in TARGETS if values.get(target_key)), None)
    return target.replace(".", " ") if isinstance(target, str) else getattr(target, "name", target)


def strange(
    path: Path, builder: Builder, leading: list[str], places: tuple[Any, ...], values: Mapping[str, Any]
) -> list[Fault]:
    """Return a fault for each unknown argument, for each one passed twice, and for surplus positional
    arguments.
    """
    faults, names = [], list(builder.fields)
    for key, value in values.items():
        if key not in names:
            siblings = (sibling for sibling in builders().values() if sibling.section == builder.section)
            methods = [
                f"{sibling.name}()" for sibling in siblings if key == sibling.name or key in sibling.fields
            ]
            if key == "kind" and value in builders():  # as a model file has it
                methods = [f"{value}()"]
            advice = f"use {' or '.join(methods[:3])} for it" if methods else "remove it"
            faults.append(
                Fault(
                    (*path, key), "there is no such keyword", shown(value), "", suggestion(key, names, advice)
                )
            )
        elif key in leading[: len(places)]:
            faults.append(Fault((*path, key), "this is given twice", shown(value), "", "give it once"))
    if len(places) > len(leading):
        problem = f"only {', '.join(leading)} stand without a keyword"
        keywords = [name for name in names if name not in leading]
        faults.append(
            Fault(
                (*path, ""),
                problem,
                shown(places[len(leading)]),
                "",
                f"write {keywords[0]}=..." if keywords else "leave it out",
            )
        )
    return faults


def read(path: Path, kind: Any, raw: Mapping[str, Any]) -> tuple[Any, list[Fault]]:
    """Return the object made of ``raw`` values and the faults found; with faults, the object has only its
    valid fields.
    """
    reader, values = ScriptReader(), {key: raw[key] for key in ("name",) if key in raw}
    linear = bool(raw.get("slider") or raw.get("point"))
    fields: dict[str, Field] = {field.name: field for field in described_fields(kind)}
    for key, field in fields.items():
        if key not in raw or (raw[key] is None and field.default is None):
            continue
        at = (*path, key_of(field, linear))
        values[key] = value_of(field, linear).read(raw[key], at, reader)
        word = raw.get(getattr(kind, "selected_by", ""))
        if (users := users_of(kind, field, word)) and raw[key] != default_of(field):
            reader.add(idle(kind, word, users, raw[key]).at(at))
    lacking = [key for key, field in fields.items() if required(field) and key not in values]
    return partial(kind, values) if lacking or reader.faults else kind(**values), reader.faults


def items(mechanism: Mechanism, section: str) -> dict[str, Any]:
    """Return the objects of a section of the mechanism, by name."""
    field = next(field for field in described_fields(type(mechanism)) if key_of(field) == section)
    entries: dict[str, Any] = getattr(mechanism, field.name)
    return entries


for _builder in builders().values():
    setattr(Builders, _builder.name, _builder.method())
