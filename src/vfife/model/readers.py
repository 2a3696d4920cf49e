"""Readers of what scripts and files may give for objects: laws by name, sections by shape, quantities as
texts, materials by name.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

from ..errors import ArgumentError, Fault, LawError, ModelError, Path, article, shown, suggestion
from ..laws import MATERIALS, Law
from ..laws.law import LAWS, law_kind
from ..schema import (
    Choice,
    Field,
    FixedList,
    Reader,
    Text,
    contains_text,
    described_fields,
    key_of,
    meaning_of,
    partial,
    value_of,
)
from .bodies import Section
from .joints import Contact

DEFAULTS: dict[str, Any] = {
    field.name: field.default_factory for field in dataclasses.fields(Contact) if field.name in LAWS
}


class LawReader(Reader):
    """Reader of the parameters of a law."""

    def __init__(self, name: str) -> None:
        super().__init__(written=True)
        self.name = name

    def unknown(self, path: Path, value: Any, names: Iterable[str] = ()) -> None:
        """Report a parameter that the law does not have."""
        remedy = suggestion(str(path[-1]), names, f'remove it, or name another law than "{self.name}"')
        self.refuse(path, "unknown key", shown(value), "", remedy)

    def missing(self, path: Path, field: Field) -> None:
        """Report a missing parameter with its meaning and unit."""
        meaning, unit = meaning_of(field), field.metadata.get("unit", "1")
        needs = f"{meaning} in {unit}" if unit != "1" else meaning
        self.refuse(path, f'the law "{self.name}" needs this key, which is missing', "", needs, "add it")


def read_law(kind: str, holder: Mapping[str, Any]) -> tuple[Law | None, list[Fault]]:
    """Return the law of a table [joint.NAME.contact] or [joint.NAME.friction] and no faults, or None and its
    faults.
    """
    registry = LAWS[kind].known()
    name = holder.get("law", DEFAULTS[kind].name)
    if not isinstance(name, str) or name not in registry:
        remedy = suggestion(
            str(name), registry, f"name a {kind} law, and with --laws the file of one of your own"
        )
        return None, [Fault(("law",), f"there is no {kind} law of this name", shown(name), "", remedy)]
    law, reader = registry[name], LawReader(name)
    values = reader.values(
        (),
        {field.name: field for field in dataclasses.fields(law)},
        {key: holder[key] for key in holder if key != "law"},
    )
    # Parameters that are known are compared with each other, whatever else is wrong.
    try:
        good = law(**{key: value for key, value in values.items() if value is not None})
    except LawError as error:
        refused = {fault.path[0] for fault in reader.faults}
        for fault in error.faults:
            if fault.where not in refused:
                reader.add(fault.at((fault.where,)))
    except (ArithmeticError, TypeError, ValueError) as error:
        if not reader.faults:
            reader.refuse(("",), f'the law "{name}" refuses these parameters: {error}')
    return (None, reader.faults) if reader.faults else (good, [])


def read_section(by: Any, path: Path, value: Mapping[str, Any]) -> Section:
    """Return the section of a table: ``area`` and ``second_moment``, or one shape; with faults, only its
    valid fields.
    """
    fault_count, shapes = len(by.faults), [key for key in Section.shapes if key in value]
    numbers = {"area", "second_moment"} & set(value)
    if not ((len(shapes) == 1 and not numbers) or (not shapes and len(numbers) == 2)):
        problem = "the section is described more than once" if shapes else "the section is not complete"
        limit = "area and second_moment together, or one of " + ", ".join(Section.shapes)
        by.refuse(path, problem, shown(value), limit, "give one of these")
    fields = {field.name: field for field in described_fields(Section)}
    read: dict[str, Any] = {}
    for key, entry in value.items():
        value_type = (
            Section.shapes[key][0] if key in shapes else value_of(fields[key]) if key in fields else None
        )
        if value_type is None:
            by.unknown((*path, key), entry, (*Section.shapes, *fields))
        else:
            read[key] = value_type.read(entry, (*path, key), by)
    if shapes and "extreme_fibre" in value:
        problem = f"{article(shapes[0])} section knows its outermost fibre"
        by.refuse((*path, "extreme_fibre"), problem, shown(value["extreme_fibre"]), "", "remove it")
    tube = read.get("tube")
    if tube is not None and tube[1] >= tube[0]:
        problem = "the inner diameter is not below the outer one: no wall is left"
        limit = f"inner below outer = {tube[0]:g} m"
        by.refuse((*path, "tube"), problem, shown(value["tube"]), limit, "give the outer diameter first")
    if len(by.faults) > fault_count:
        partial_section: Section = partial(Section, {} if shapes else read)
        return partial_section
    if not shapes:
        return Section(**read)
    sizes = read[shapes[0]]
    section: Section = getattr(Section, shapes[0])(*(sizes if isinstance(sizes, tuple) else (sizes,)))
    return section


Quantity: TypeAlias = float | str  # 0.1, or "100 mm"
Place: TypeAlias = Sequence[Quantity]  # x and y
Table: TypeAlias = Mapping[str, Any]  # keys and values as in a model file


class ScriptReader(Reader):
    """Reader of script values: everything that a model file can contain, and the objects themselves."""

    def __init__(self) -> None:
        super().__init__(written=True)

    def inner(self, path: Path, kind: type, value: Any) -> Any:
        """Return an object, or the one that a table describes."""
        if isinstance(value, Mapping):
            if kind is Section:
                return read_section(self, path, value)
            fault_count = len(self.faults)
            return self.build(
                kind,
                self.values(path, {field.name: field for field in described_fields(kind)}, value),
                fault_count,
            )
        return self.one_of(path, kind, value)

    def named(self, path: Path, kind: type, value: Any) -> Any:
        """Return a material, or the one of a name."""
        if not isinstance(value, str):
            return self.one_of(path, kind, value)
        if value not in MATERIALS:
            remedy = suggestion(
                value,
                MATERIALS,
                "make one: vfife.Material(name, youngs_modulus=..., poissons_ratio=..., density=...)",
            )
            self.refuse(path, "there is no material of this name", shown(value), "", remedy)
        return MATERIALS.get(value)

    def chosen(self, path: Path, base: type, value: Any) -> Any:
        """Return a law given as object, name, or table of ``law = name`` and parameters."""
        kind = law_kind(base)
        if isinstance(value, Law) and not isinstance(value, base):
            self.refuse(
                path, f"this is no {kind} law", shown(value.name), "", f"give {article(kind)} law here"
            )
            return None
        if isinstance(value, base):
            return value
        if isinstance(value, type) and issubclass(value, base):
            self.refuse(
                path,
                "this is the law's class",
                value.__name__,
                "",
                f"write {value.__name__}(), with its parameters by name",
            )
            return None
        if not isinstance(value, str | Mapping):
            self.unexpected(path, value, f"{article(kind)} law, its name, or its table", "give one")
            return None
        law, faults = read_law(kind, {"law": value} if isinstance(value, str) else value)
        for fault in faults:
            self.add(fault.at((*path, *fault.path)))
        return law

    def one_of(self, path: Path, kind: type, value: Any) -> Any:
        """Return an object made by Python, whose numbers are numbers already."""
        plain = Reader()
        item = plain.one_of(path, kind, value)
        self.faults += plain.faults
        return item


def users_of(model_class: Any, field: Field, word: Any) -> tuple[str, ...]:
    """Return the link models or analyses that use a field, if ``word`` is chosen and not one of them."""
    only: tuple[str, ...] = field.metadata.get("only") or ()
    if not only or word in only:
        return ()
    fields = described_fields(model_class)
    chooser = next(candidate for candidate in fields if candidate.name == model_class.selected_by)
    return only if word in chooser.metadata["choices"] else ()


def idle(model_class: Any, word: Any, users: tuple[str, ...], value: Any) -> Fault:
    """Return the fault for a ``value`` that the chosen link model or analysis ignores; ``users`` are the
    choices that use it.
    """
    chooser = model_class.selected_by
    kind = f"{article(word)} {'link' if chooser == 'model' else chooser}"
    listed = " or ".join(users if chooser == "model" else map(shown, users))
    return Fault(
        "",
        f"{kind} does not use this",
        shown(value),
        "",
        f"remove it, or set {chooser} {'to' if chooser == 'model' else '='} {listed}",
    )


Class = TypeVar("Class", bound=type)


def with_units(*path: str) -> Callable[[Class], Class]:
    """Return a decorator that lets a dataclass accept texts with units for its quantities.

    ``path`` is its place in a model file. The constructor raises ArgumentError for unknown keywords and
    ModelError for texts that are no such quantity. Limits are checked when the whole mechanism is validated.
    """

    def decorate(model_class: Class) -> Class:
        init_fields: Callable[..., None] = vars(model_class)["__init__"]
        names = [field.name for field in dataclasses.fields(model_class)]
        keys_and_types = {
            field.name: (key_of(field), value_of(field)) for field in described_fields(model_class)
        }
        quantities = {
            name for name, (_, value) in keys_and_types.items() if not isinstance(value, Text | Choice)
        }

        @functools.wraps(init_fields)
        def init(self: Any, *args: Any, **values: Any) -> None:
            faults = [
                strange((*path, key), value, names) for key, value in values.items() if key not in names
            ]
            if faults:
                raise ArgumentError(faults, f"{model_class.__name__}()")
            arguments, reader = dict(zip(names, args, strict=False)) | values, ScriptReader()
            if len(args) <= len(names):
                for name in quantities & arguments.keys():
                    (key, kind), value = keys_and_types[name], arguments[name]
                    if contains_text(value) or lacks_parts(kind, value):
                        arguments[name] = kind.read(value, (*path, key), reader)
                args, values = (), arguments
            if reader.faults:
                raise ModelError(reader.faults, f"{model_class.__name__}()")
            init_fields(self, *args, **values)

        setattr(model_class, "__init__", init)  # noqa: B010 - a checker forbids the assignment
        return model_class

    return decorate


def lacks_parts(kind: object, value: Any) -> bool:
    """Return whether a number, or a list of another length, stands for a list of fixed length."""
    if type(kind) is not FixedList:
        return False
    return isinstance(value, int | float) or (
        isinstance(value, list | tuple) and len(value) != len(kind.parts)
    )


def strange(path: Path, value: Any, names: list[str]) -> Fault:
    """Return the fault for an unknown keyword."""
    return Fault(
        path, "there is no such keyword", shown(value), "", suggestion(str(path[-1]), names, "remove it")
    )
