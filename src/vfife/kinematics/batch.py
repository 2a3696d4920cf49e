"""Mechanisms of one structure as a batch: numbers of their bodies and points as arrays, cases first.

Cases of a study differ in a few numbers. Everything that follows from structure alone (numbers of particles,
kinds of rows, names) is therefore computed for the first mechanism of a batch, and numbers of one object once
for all mechanisms that share it. Two mechanisms have one structure if their objects differ in numbers alone
that are not 0 or 1 and have the same signs. Series of numbers, on which counts of pieces depend, are compared
exactly.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..model.lumping import rigid_properties
from ..model.mechanism import Mechanism
from .pins import local_point

Array = NDArray[np.float64]
Side = tuple[str, str]
Answer = TypeVar("Answer")
SECTIONS = ("bodies", "joints", "drivers", "loads", "gears", "springs")
LONGEST_POINT = 2  # numbers; a longer tuple is a series


FIELDS: dict[type, Callable[[Any], tuple[Any, ...]]] = {}


def fields_of(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    """Return the function that returns the values of all fields of a dataclass of this kind."""
    if kind not in FIELDS:
        names = [field.name for field in dataclasses.fields(kind)]
        FIELDS[kind] = (
            attrgetter(*names) if len(names) > 1 else lambda item: tuple(getattr(item, n) for n in names)
        )
    return FIELDS[kind]


class Structures:
    """Numbers that stand for structures of mechanisms and of their objects, each object examined once."""

    def __init__(self) -> None:
        self.objects: dict[int, tuple[Any, int]] = {}
        self.numbers: dict[Any, int] = {}

    def of(self, item: Any) -> int:
        """Return the number of an object's structure, the same for objects that differ in numbers alone."""
        entry = self.objects.get(id(item))
        if entry is None:  # the object is kept, so that no other one gets its identity
            entry = self.objects[id(item)] = item, self.number(self._description(item))
        return entry[1]

    def number(self, description: Any) -> int:
        """Return the number of a description."""
        return self.numbers.setdefault(description, len(self.numbers))

    def equal(self, item: Any) -> int:
        """Return the number of an object, the same for equal ones."""
        entry = self.objects.get(-id(item))
        if entry is None:
            entry = self.objects[-id(item)] = item, self.number(item)
        return entry[1]

    def mechanism(self, mechanism: Mechanism) -> tuple[int, ...]:
        """Return the structure of a mechanism."""
        numbers = [self.of(getattr(mechanism, section)) for section in SECTIONS]
        numbers += [self.equal(mechanism.settings), self.equal(mechanism.start)]
        # The carrier of a gear follows from points that coincide, the crank of a load from the fastest
        # driver.
        points, gravity, drivers = mechanism.points, mechanism.gravity, mechanism.drivers
        exact = (
            tuple(points.items()) if mechanism.gears else tuple(points),
            tuple(gravity),
            tuple(drivers.items()) if len(drivers) > 1 else (),
        )
        return (*numbers, self.number(exact))

    def _description(self, item: Any) -> Any:
        if isinstance(item, dict):
            return tuple(item), *map(self._part, item.values())
        if dataclasses.is_dataclass(item):
            return type(item), *map(self._part, fields_of(type(item))(item))
        return id(item)

    def _part(self, value: Any) -> Any:
        if value is None or isinstance(value, str | int):
            return value
        if isinstance(value, float):
            return value if value in (0.0, 1.0) or value - value != 0.0 else "+" if value > 0.0 else "-"
        if isinstance(value, tuple):
            series = len(value) > LONGEST_POINT and isinstance(value[0], float)
            return value if series else tuple(map(self._part, value))
        return self.of(value)


def batches(mechanisms: Sequence[Mechanism], structures: Structures | None = None) -> list[list[int]]:
    """Return groups of mechanisms of one structure, by their indices."""
    if len(mechanisms) == 1:
        return [[0]]
    structures, groups = structures or Structures(), dict[tuple[int, ...], list[int]]()
    for k, mechanism in enumerate(mechanisms):
        groups.setdefault(structures.mechanism(mechanism), []).append(k)
    return list(groups.values())


class Shared:
    """Results of functions of objects that mechanisms of a batch have in common, each computed once."""

    def __init__(self) -> None:
        self.results: dict[Any, tuple[Any, Any]] = {}

    def __call__(self, function: Callable[..., Answer], *objects: Any) -> Answer:
        """Return a function's result, which depends on nothing but these objects, told apart by identity."""
        return self.recall(function, objects, lambda: function(*objects))

    def recall(self, key: Any, objects: Sequence[Any], make: Callable[[], Answer]) -> Answer:
        """Return what ``make`` returned for the same objects and an equal key before, else what it returns
        now.
        """
        full = key, *map(id, objects)
        entry = self.results.get(full)
        if entry is None:  # the objects are kept, so that no other ones get their identity
            entry = self.results[full] = make(), objects
        result: Answer = entry[0]
        return result


class Column:
    """The objects of one name in all mechanisms of a batch: the distinct ones, and which of them each
    mechanism has; ``index`` is None if all share one.
    """

    def __init__(self, objects: list[Any]) -> None:
        first = objects[0]
        self.objects, self.index = [first], None
        if any(item is not first for item in objects):
            places: dict[int, int] = {}
            self.objects = []
            for item in objects:
                if places.setdefault(id(item), len(places)) == len(self.objects):
                    self.objects.append(item)
            self.index = np.array([places[id(item)] for item in objects], dtype=np.intp)
        self.count = len(objects)

    def numbers(self, function: Callable[[Any], Any]) -> Array:
        """Return numbers of the objects [cases, ...]."""
        values = np.array([function(item) for item in self.objects], dtype=float)
        if self.index is not None:
            return values[self.index]
        return values if self.count == 1 else np.broadcast_to(values, (self.count, *values.shape[1:]))


class Batch:
    """Mechanisms of one structure."""

    def __init__(self, mechanisms: Sequence[Mechanism]) -> None:
        self.mechanisms, self.first = mechanisms, mechanisms[0]
        self.columns: dict[tuple[str, str], Column] = {}
        self.known: dict[Any, Array] = {}

    def __len__(self) -> int:
        return len(self.mechanisms)

    def column(self, section: str, name: str) -> Column:
        """Return the objects of a section (a field of a mechanism) with a name."""
        key = section, name
        if key not in self.columns:
            tables = [getattr(mechanism, section) for mechanism in self.mechanisms]
            self.columns[key] = Column([table[name] for table in tables])
        return self.columns[key]

    def body(self, name: str, quantity: str, function: Callable[[Any], Any]) -> Array:
        """Return numbers of a body [cases, ...]; they are kept under the name of their ``quantity``."""
        key = name, quantity
        if key not in self.known:
            self.known[key] = self.column("bodies", name).numbers(function)
        return self.known[key]

    def mass(self, name: str) -> Array:
        """Return mass (kg) and inertia (kg m²) of a body [cases, 2]."""
        return self.body(name, "mass", lambda body: rigid_properties(body)[::2])

    def center(self, name: str) -> Array:
        """Return the centre of mass of a body in its frame (m) [cases, 2]."""
        return self.body(name, "center", lambda body: rigid_properties(body).center)

    def angle(self, name: str) -> Array:
        """Return the approximate angle of a body (rad) [cases]."""
        if name == "ground":
            return np.zeros(len(self))
        return self.body(name, "angle", lambda body: body.angle)

    def point(self, side: Side) -> Array:
        """Return a pin in its body's frame, or a point of the ground (m) [cases, 2]. Raises AssemblyError for
        a pin that does not exist.
        """
        body, pin = side
        local_point(self.first, side)
        if body == "ground":
            return self.column("points", pin).numbers(lambda point: point)
        return self.body(body, f"point {pin}", lambda body: body.points[pin])

    def from_center(self, side: Side) -> Array:
        """Return a pin from the centre of mass in the body's axes, or a point of the ground from the origin
        (m) [cases, 2].
        """
        point = self.point(side)
        return point if side[0] == "ground" else point - self.center(side[0])
