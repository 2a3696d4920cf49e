"""Mechanisms of one structure as a batch: numbers of their bodies and points as arrays, cases first.

The cases of a study differ in a few numbers, such as a length or a mass. Their *structure* is everything
else: names, kinds of objects, connections, numbers of elements. What follows from structure alone (particles,
kinds of rows, messages) is computed for the first mechanism of a batch and holds for all. Numbers are
computed for all mechanisms at once, in arrays whose first axis is the case. One mechanism alone is a batch of
one.

Mechanisms are built by replacing single objects, so that most of their objects are shared: a study of the
length of a rod has one crank, and as many rods as cases. Objects are therefore told apart by identity, which
takes no time, and what follows from an object is computed once for all mechanisms that have it
(:class:`Shared`, :class:`Column`).

Two mechanisms have one structure if their objects differ in numbers alone, and if these numbers have the same
signs and are neither 0 nor 1: a number that is 0 or 1 often means that something is absent. Series of
numbers, on which numbers of pieces depend, and integers have to be equal (:class:`Structures`).

A case has the same bits in a batch of any size, because every operation on arrays is elementwise, or on the
matrix of one case at a time: no sum runs over cases.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cache
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


@cache
def fields_of(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    """Return the function that returns the values of all fields of a dataclass of this kind."""
    names = [field.name for field in dataclasses.fields(kind)]
    return attrgetter(*names) if len(names) > 1 else lambda item: tuple(getattr(item, n) for n in names)


class Shared:
    """Results of functions of objects, such as a joint or a table of loads, each computed once for all
    mechanisms that have these very objects.

    Results are found by the identity of the objects. The objects are kept with them, so that no object made
    later gets the identity of one that is gone.
    """

    def __init__(self) -> None:
        self.results: dict[Any, tuple[Any, Any]] = {}

    def __call__(self, function: Callable[..., Answer], *objects: Any) -> Answer:
        """Return a function's result, which depends on nothing but these objects."""
        return self.recall(function, objects, lambda: function(*objects))

    def recall(self, key: Any, objects: Sequence[Any], make: Callable[[], Answer]) -> Answer:
        """Return the result of ``make``, from an earlier call with an equal key and the same objects if there
        was one.
        """
        full = key, *map(id, objects)
        entry = self.results.get(full)
        if entry is None:
            entry = self.results[full] = make(), objects
        result: Answer = entry[0]
        return result


class Structures:
    """The structures of mechanisms and of their objects as integers: equal structures have one number. Each
    object is examined once, and the batches of mechanisms that were asked for are kept.

    ``shared``: results that all these mechanisms have in common.
    """

    def __init__(self) -> None:
        self.objects: dict[int, tuple[Any, int]] = {}
        self.numbers: dict[Any, int] = {}
        self.made: dict[tuple[int, ...], Batch] = {}
        self.shared = Shared()

    def batch(self, mechanisms: Sequence[Mechanism]) -> Batch:
        """Return the batch of mechanisms of one structure."""
        key = tuple(map(id, mechanisms))
        if key not in self.made:  # the batch keeps its mechanisms, so that no other ones get their identity
            self.made[key] = Batch(mechanisms, self.shared)
        return self.made[key]

    def groups(self, mechanisms: Sequence[Mechanism]) -> list[list[int]]:
        """Return groups of mechanisms of one structure, by their indices."""
        if len(mechanisms) == 1:
            return [[0]]
        result: dict[tuple[int, ...], list[int]] = {}
        for k, mechanism in enumerate(mechanisms):
            result.setdefault(self.mechanism(mechanism), []).append(k)
        return list(result.values())

    def mechanism(self, mechanism: Mechanism) -> tuple[int, ...]:
        """Return the structure of a mechanism."""
        # The key is a word: a bound method would refer to these structures, and the cycle keep all of a batch
        # until the garbage collector finds it.
        return self.shared.recall("structure", (mechanism,), lambda: self._mechanism(mechanism))

    def _mechanism(self, mechanism: Mechanism) -> tuple[int, ...]:
        """Compute the structure of a mechanism."""
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

    def of(self, item: Any) -> int:
        """Return the number of an object's structure."""
        entry = self.objects.get(id(item))
        if entry is None:  # the object is kept, so that no other one gets its identity
            entry = self.objects[id(item)] = item, self.number(self._description(item))
        return entry[1]

    def equal(self, item: Any) -> int:
        """Return the number of an object, the same for equal objects alone."""
        entry = self.objects.get(-id(item))  # its structure has the entry of id(item)
        if entry is None:
            entry = self.objects[-id(item)] = item, self.number(item)
        return entry[1]

    def number(self, description: Any) -> int:
        """Return the number of a description, a new one for one that is new."""
        return self.numbers.setdefault(description, len(self.numbers))

    def _description(self, item: Any) -> Any:
        """Return what two objects of one structure have equal: their kind, and each of their values as
        :meth:`_part`.
        """
        if isinstance(item, dict):
            return tuple(item), *map(self._part, item.values())
        if dataclasses.is_dataclass(item):
            kind: Any = type(item)
            return kind, *map(self._part, fields_of(kind)(item))
        return id(item)

    def _part(self, value: Any) -> Any:
        """Return a word, an integer or a series as it is, another number as its sign, an object as the number
        of its structure.
        """
        if value is None or isinstance(value, str | int):
            return value
        if isinstance(value, float):
            return value if value in (0.0, 1.0) or value - value != 0.0 else "+" if value > 0.0 else "-"
        if isinstance(value, tuple):
            series = len(value) > LONGEST_POINT and isinstance(value[0], float)
            return value if series else tuple(map(self._part, value))
        return self.of(value)


class Column:
    """The objects of one name, such as the body "rod", in all mechanisms of a batch.

    ``objects`` are the distinct ones, and ``index`` [cases] tells which of them each mechanism has; it is
    None if all have the same one. A function of the objects is thus called once for each distinct object.
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
        """Return numbers of the objects [cases, ...], read-only."""
        values = np.array([function(item) for item in self.objects], dtype=float)
        if self.index is not None:
            return values[self.index]
        return values if self.count == 1 else np.broadcast_to(values, (self.count, *values.shape[1:]))


class Batch:
    """Mechanisms of one structure; all arrays have the cases first, in the order of the mechanisms.
    ``shared`` are results that these mechanisms have in common with others.
    """

    def __init__(self, mechanisms: Sequence[Mechanism], shared: Shared | None = None) -> None:
        self.mechanisms, self.first, self.shared = mechanisms, mechanisms[0], shared or Shared()
        self.columns: dict[tuple[str, str], Column] = {}
        self.known: dict[Any, Any] = {}

    def __len__(self) -> int:
        return len(self.mechanisms)

    def recall(self, key: Any, make: Callable[[], Answer]) -> Answer:
        """Return the result of ``make``, from the first call with this key."""
        if key not in self.known:
            self.known[key] = make()
        result: Answer = self.known[key]
        return result

    def column(self, section: str, name: str) -> Column:
        """Return the objects of a section (a field of a mechanism) with a name."""
        key = section, name
        if key not in self.columns:
            tables = [getattr(mechanism, section) for mechanism in self.mechanisms]
            self.columns[key] = Column([table[name] for table in tables])
        return self.columns[key]

    def body(self, name: str, quantity: str, function: Callable[[Any], Any]) -> Array:
        """Return numbers of a body [cases, ...]; they are kept under the name of their ``quantity``."""
        return self.recall((name, quantity), lambda: self.column("bodies", name).numbers(function))

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

        def difference() -> Array:
            return self.point(side) if side[0] == "ground" else self.point(side) - self.center(side[0])

        return self.recall(("from center", *side), difference)
