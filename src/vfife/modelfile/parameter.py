"""A value of a model by its path: unit, limits, value, and the model with another value.

A path such as ``joint.C.clearance`` names a key of the model file. A number that an object of the mechanism
holds directly is read and replaced there; other values (shapes of sections, shared materials, kinds) go
through the tables of the model file.
"""

from __future__ import annotations

import copy
import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..errors import Fault, ModelError, Path, shown
from ..laws import MATERIALS, Law
from ..model.drivers import Driver
from ..model.mechanism import Mechanism
from ..schema import (
    Field,
    FixedList,
    FreeList,
    Inner,
    Measure,
    Named,
    Names,
    Value,
    described_fields,
    key_of,
    value_of,
)
from .paths import default_at, field_at, list_at, parsed, resolve
from .read import line_at, lines_of, of_tables, text_of
from .tables import Raw, kinds_of, table
from .write import tables_of, unused

STEEL = "steel"  # the material of what names none
NO_NUMBER = "name a number of the model by its path, such as joint.C.clearance"


class Parameter:
    """A value of a model by its path; ``joint.BODY-BODY`` is the joint that connects the two bodies.

    ``model``: a mechanism, or the tables of a model file, which need not be valid. Raises Fault for an
    unknown path.

    >>> from vfife.gallery import four_bar
    >>> gap = Parameter(four_bar(), "joint.C.clearance")
    >>> gap.unit, gap.limits, gap.set("0.5 mm").joints["C"].clearance
    ('m', 'above 0 m', 0.0005)
    """

    def __init__(self, model: Mechanism | Raw, path: str) -> None:
        self.mechanism = model if isinstance(model, Mechanism) else None
        parts = tuple(part.strip() for part in path.split("."))
        place = number_at(self.mechanism, parts) if self.mechanism is not None else None
        # Attributes, names and indices from the mechanism to the number, if an object holds it.
        self.steps: Path | None = None
        self.keys: Path
        self.field: Value | None
        if place is not None:
            self.keys, self.steps, self.field = place
        else:
            self.tables = tables_of(model) if isinstance(model, Mechanism) else model
            self.keys = resolve(self.tables, path)
            self.field = field_at(self.tables, self.keys)

    @property
    def path(self) -> str:
        """The full path."""
        return ".".join(map(str, self.keys))

    @property
    def unit(self) -> str:
        """SI unit, "1" for none."""
        return self.field.unit if isinstance(self.field, Measure) else "1"

    @property
    def limits(self) -> str:
        """Limits of a number as text."""
        return (
            self.field.limits()
            if isinstance(self.field, Measure)
            else next(self.field.units(), "")
            if self.field
            else ""
        )

    @property
    def default(self) -> Any:
        """Default value (SI); None if the value is required, or if the list or law determines it."""
        tables = tables_of(self.mechanism) if self.mechanism is not None else self.tables
        return default_at(tables, self.keys)

    @property
    def line(self) -> int | None:
        """Line of the value, or of its table, in the model file from which the mechanism was read; None
        without file.
        """
        source = None if self.mechanism is None else self.mechanism.source
        if source is None or not os.path.isfile(source):
            return None
        return line_at(lines_of(text_of(source)), self.keys)

    @property
    def quantity(self) -> Measure | None:
        """The type of a single number with a unit; None for whole numbers, words, lists and tables."""
        return self.field if isinstance(self.field, Measure) and not self.field.series else None

    @property
    def elements(self) -> list[str]:
        """Paths of the elements of a list, whether the model gives it or has its default; else empty."""
        if self.steps is not None:
            return []
        value = self.get() if self.field is None else None
        values = value if isinstance(value, list) else list_at(self.tables, self.keys) or ()
        return [f"{self.path}.{k}" for k in range(len(values))]

    @property
    def misfit(self) -> Fault | None:
        """The fault of a number of another kind of driver, with the numbers of this one; None for others."""
        if self.steps is not None or self.keys[0] != "driver" or len(self.keys) != 3:
            return None
        _, name, key = map(str, self.keys)
        holder = table(self.tables, "driver", name)
        if key in holder or key in (keys := kinds_of("driver", holder)[0].keys):
            return None
        paths = [f"driver.{name}.{entry}" for entry in holder if entry in keys]
        message = f"{key} is a number of another kind of driver; that of {name} has {', '.join(holder)}"
        return Fault("", message, remedy=f"did you mean {' or '.join(map(shown, paths))}?")

    def read(self, value: Any) -> Any:
        """Return a value, possibly a text with a unit, in SI units. Raises Fault if it is invalid here."""
        if self.field is None:
            raise Fault("", "this is not a number of the model", shown(value), "", NO_NUMBER)
        return self.field.take(parsed(value) if isinstance(value, str) else value, written=True)

    def get(self) -> Any:
        """Return the value, None if the model does not give it."""
        value: Any = self.tables if self.steps is None else self.mechanism
        for step in self.keys if self.steps is None else self.steps:
            value = (
                getattr(value, str(step), None) if dataclasses.is_dataclass(value) else part_of(value, step)
            )
        return value if value is None or self.steps is not None or self.field is None else self.read(value)

    def set(self, value: Any) -> Mechanism:
        """Return the mechanism with another value. Raises Fault or ModelError if that is invalid."""
        if self.steps is None:
            return of_tables(copy.deepcopy(self.tables), [(self.path, value)])
        changed: Mechanism = replaced(self.mechanism, self.steps, self.read(value))
        return dataclasses.replace(changed, source=None)

    def set_many(self, values: Iterable[Any]) -> list[Mechanism]:
        """Return the mechanism with each of many values, sharing all else. Raises ModelError with
        all faults.
        """
        mechanisms, faults = list[Mechanism](), list[Fault]()
        for value in values:
            try:
                mechanisms.append(self.set(value))
            except Fault as fault:
                faults.append(fault.at(self.keys, value=shown(value)))
            except ModelError as error:
                faults += error.faults
        if faults:
            raise ModelError(faults, "set_many()")
        return mechanisms


def with_values(mechanism: Mechanism, values: Mapping[str, Any]) -> Mechanism:
    """Return the mechanism with other values by path. Raises Fault or ModelError with all faults."""
    changed = mechanism
    for path, value in values.items():
        parameter = Parameter(changed, path)
        if parameter.steps is None:
            return of_tables(tables_of(mechanism), values.items())
        changed = parameter.set(value)
    return changed


def holds(mechanism: Mechanism, path: str, value: float) -> bool:
    """Return whether an object of the mechanism holds the number of a full path directly: it is not in a
    shared material and not derived from others.
    """
    place = number_at(mechanism, path.split("."))
    return place is not None and Parameter(mechanism, path).get() == value


def numbers(mechanism: Mechanism) -> dict[str, float]:
    """Return all numbers of a model (SI) by path, except counts and those of the table ``run``.

    Numbers of named materials, and of steel, the default material, are included.
    """
    tables = tables_of(mechanism)
    materials = sorted({STEEL, *_texts(tables)} & MATERIALS.keys() - tables.get("material", {}).keys())
    named = {f"material.{name}": vars(MATERIALS[name]) for name in materials}
    return dict(
        pair for key, value in {**tables, **named}.items() if key != "run" for pair in _within(key, value)
    )


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texts(inner)


def _within(path: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, float):
        yield path, value
    elif isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _within(f"{path}.{key}", inner)


def number_at(mechanism: Mechanism, parts: Sequence[str]) -> tuple[Path, Path, Measure] | None:
    """Return keys, steps (attributes, names, indices) and type of a number that an object of the mechanism
    holds; None for any other path.
    """
    value: Any = mechanism
    field: Value = Inner(Mechanism)
    keys, steps = list[str | int](), list[str | int]()
    for part in parts:
        key: str | int = part
        step: str | int = part
        if dataclasses.is_dataclass(value) and not isinstance(field, Named):
            part_field = own_field(value, part)
            if part_field is None or unused(value, part_field):
                return None
            field, step = value_of(part_field, isinstance(value, Driver) and value.is_linear), part_field.name
            value = getattr(value, part_field.name)
        elif isinstance(value, dict) and part in value:
            value = value[part]
            field = field.part if isinstance(field, Names) else Inner(type(value))
        elif isinstance(value, tuple) and part.isdecimal() and int(part) < len(value):
            key = step = at = int(part)
            value, field = (
                value[at],
                (
                    field.parts[at]
                    if isinstance(field, FixedList)
                    else field.part
                    if isinstance(field, FreeList)
                    else field
                ),
            )
        else:
            return None
        keys.append(key)
        steps.append(step)
    if (
        not isinstance(field, Measure)
        or not isinstance(value, float | None)
        or (field.series and value is None)
    ):
        return None
    return tuple(keys), tuple(steps), dataclasses.replace(field, series=False) if field.series else field


def own_field(item: Any, key: str) -> Field | None:
    """Return the field of an object by its key in a file, of a law by its name."""
    linear = isinstance(item, Driver) and item.is_linear
    fields = dataclasses.fields(item) if isinstance(item, Law) else described_fields(type(item))
    return next((field for field in fields if key_of(field, linear) == key), None)


def part_of(holder: Any, key: str | int) -> Any:
    """Return an entry of a table or list, None if there is none."""
    if isinstance(holder, list | tuple):
        return holder[int(key)] if int(key) < len(holder) else None
    return holder.get(key) if isinstance(holder, dict) else None


def replaced(value: Any, steps: Path, number: Any) -> Any:
    """Return a mechanism, or a part of one, with another number."""
    if not steps:
        return number
    step, inner_steps = steps[0], steps[1:]
    if isinstance(value, dict):
        return {**value, step: replaced(value[step], inner_steps, number)}
    if isinstance(value, tuple):
        return (*value[: int(step)], replaced(value[int(step)], inner_steps, number), *value[int(step) + 1 :])
    changed = replaced(getattr(value, str(step)), inner_steps, number)
    if isinstance(value, Mechanism):  # its own values are objects, which need no check
        mechanism = copy.copy(value)
        setattr(mechanism, str(step), changed)
        return mechanism
    return dataclasses.replace(value, **{str(step): changed})
