"""Context of all checks: the mechanism, where it is invalid already, and the faults found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...errors import Fault, Path, suggestion
from ..joints import Contact
from ..rows import Coincide, Row

if TYPE_CHECKING:
    from ..mechanism import Mechanism

NAME_LIMIT = 64
MOST_SUGGESTIONS = 40  # comparing names takes time, and nobody reads more suggestions


class Checks:
    """A mechanism, possibly known in part, the paths of ``refusals`` (values that are invalid already), and
    the ``faults`` found.

    ``overrides`` are the paths of values that replace those of the file; ``written`` returns the text of the
    value at a path.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        refusals: Iterable[Path] = (),
        overrides: Iterable[Path] = (),
        written: Callable[[Path], str] = lambda path: "",
    ) -> None:
        self.mechanism, self.overrides, self.written = mechanism, overrides, written
        self.refused = {path[:depth] for path in refusals for depth in range(2, len(path) + 1)}
        self.faults: list[Fault] = []
        self.suggestions = 0
        self.bodies: dict[str, Any] = dict(mechanism.bodies)
        self.joints = dict(readable(mechanism.joints))
        self.drivers = dict(readable(mechanism.drivers))
        self.turned = {
            driver.body: name
            for name, driver in self.drivers.items()
            if driver.moves and driver.target == "body" and driver.body
        }

    @cached_property
    def pivots(self) -> dict[str, list[str]]:
        """The joints that pin each body to the ground, by body."""
        result: dict[str, list[str]] = {}
        for name, joint in self.joints.items():
            bodies = bodies_of(joint)
            if rows_of(joint) == (Coincide(),) and len(bodies) == 2 and "ground" in bodies:
                result.setdefault(next(iter(bodies - {"ground"})), []).append(name)
        return result

    def add(self, path: Path, problem: str, remedy: str, limit: str = "") -> None:
        """Add a fault at a path, with the value there."""
        value = self.written(path) if path[-1] != "" else ""
        fault = Fault("", problem, value, limit, remedy).at(path, self.overrides)
        if self.faults[-1:] != [fault]:  # two tables over the same places report them once
            self.faults.append(fault)

    def conflicts(self, path: Path, item: Any) -> None:
        """Add the faults that an object at a path reports about itself."""
        for fault in item.conflicts():
            self.add((*path, *fault.path), fault.what, fault.remedy, fault.limit)

    def fails(self, path: Path) -> bool:
        """Return whether the value at a path, or a part of it, is invalid already."""
        return path in self.refused

    def name_hint(self, name: str, among: Iterable[str], advice: str) -> str:
        """Return a suggestion of a similar name, else the advice. Only the first faults are compared with all
        names.
        """
        self.suggestions += 1
        return suggestion(name, among, advice) if self.suggestions <= MOST_SUGGESTIONS else advice

    def points(self, body: str) -> Iterable[str]:
        """Return the names of the points of a body or of the ground."""
        if body == "ground":
            return self.mechanism.points
        item = self.bodies.get(body)
        return () if item is None else points_of(item)

    def side(self, path: Path, side: Any, ground: str = "") -> None:
        """Check that ``body.pin`` exists. ``ground`` is the message for a pin of the ground, if none is
        allowed.
        """
        if side is None or self.fails(path):
            return
        body, _, pin = side.partition(".")
        bodies = [*self.bodies, *([] if ground else ["ground"])]
        if body not in bodies:
            pins = (f"{name}.{point}" for name in bodies for point in self.points(name))
            problem = f"there is no body {shown_name(body)}" if body != "ground" else ground
            self.add(path, problem, self.name_hint(side, pins, 'name a pin as "body.pin"'))
        elif (body == "ground" or self.bodies[body] is not None) and pin not in self.points(body):
            problem = (
                f"{body} has no {'point' if body == 'ground' else 'pin'} {shown_name(pin)}"
                if pin
                else "the pin is missing"
            )
            listed = (f"{body}.{point}" for point in self.points(body))
            self.add(path, problem, self.name_hint(side, listed, "name one that is there, or add it"))

    def body(self, path: Path, name: Any) -> bool:
        """Return whether a text names a body or the ground; add a fault if not."""
        if name is None or self.fails(path):
            return False
        among = [*self.bodies, "ground"]
        if name in among:
            return True
        remedy = self.name_hint(name, among, "name a body")
        if "." in name and name.partition(".")[0] in among:
            remedy = f'name the body alone: "{name.partition(".")[0]}"'
        self.add(path, f"there is no body {shown_name(name)}", remedy)
        return False

    def series(self, path: Path, values: tuple[str, Any], places: tuple[str, Any]) -> None:
        """Check a table: at least two ascending arguments, and one value for each. Both are pairs of key and
        numbers.
        """
        (key, values_of_table), (axis, points) = values, places
        if self.fails((*path, key)) or self.fails((*path, axis)):
            return
        for missing, present, value in ((axis, key, points), (key, axis, values_of_table)):
            if value is None:
                self.add(
                    (*path, missing),
                    f"{present} and {missing} go together, and {missing} is missing",
                    "add it",
                )
        if points is None or values_of_table is None:
            return
        count = len(values_of_table) if isinstance(values_of_table, tuple | list) else 1
        if count != len(points) or not isinstance(values_of_table, tuple | list):
            self.add(
                (*path, key),
                f"{count} for {len(points)} {axis}",
                f"give each of the {axis} its value",
                f"{len(points)} values",
            )
        if len(points) < 2:
            self.add(
                (*path, axis), f"a table over {axis} needs at least two of them", "add more, or leave it out"
            )
        for k, (early, late) in enumerate(zip(points, points[1:], strict=False), 1):
            if late <= early:
                self.add((*path, axis), f"{axis} must ascend, and number {k + 1} does not", "sort them")
                break


def readable(items: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield names and objects, without unreadable objects (None)."""
    return ((name, item) for name, item in items.items() if item is not None)


def points_of(body: Any) -> Iterator[str]:
    """Yield the names of the points of a body, which may be known in part."""
    yield from type(body).own_points
    for key in ("pins", "nodes"):
        yield from entries_of(body, key)


def entries_of(body: Any, key: str) -> Any:
    """Return the pins or nodes of a body, which may be known in part."""
    return vars(body).get(key) or ()


def ends(joint: Any) -> tuple[str, str]:
    """Return bearing and journal, "" where unknown."""
    return joint.bearing or "", joint.journal or ""


def bodies_of(joint: Any) -> set[str]:
    """Return the bodies that a joint connects."""
    return {side.partition(".")[0] for side in ends(joint)}


def rows_of(joint: Any) -> tuple[Row, ...]:
    """Return the rows of an ideal joint; none for a joint with clearance or with invalid sizes, which have
    their own fault.
    """
    try:
        return () if isinstance(joint, Contact) else tuple(joint.rows())
    except (TypeError, ValueError):
        return ()


def shown_name(name: str) -> str:
    """Return a name in quotes, shortened."""
    return repr(name if len(name) <= NAME_LIMIT else name[: NAME_LIMIT - 3] + "...")


def reached(neighbours: dict[str, set[str]], start: str) -> set[str]:
    """Return the names that lead to ``start``, from each to its neighbours, and ``start`` itself."""
    names, waiting = {start}, [start]
    while waiting:
        fresh = neighbours[waiting.pop()] - names
        names |= fresh
        waiting += fresh
    return names


def neighbours_of(names: Iterable[str], pairs: Iterable[Iterable[str]]) -> dict[str, set[str]]:
    """Return the neighbours of each name, given the connected pairs."""
    neighbours: dict[str, set[str]] = {name: set() for name in names}
    for first, second in pairs:
        neighbours[first].add(second)
        neighbours[second].add(first)
    return neighbours


def connections(mechanism: Mechanism) -> Iterator[tuple[str, str]]:
    """Yield the pairs of pins, or bodies, that joints, springs and gears connect."""
    for joint in mechanism.joints.values():
        yield joint.bearing, joint.journal
    for spring in mechanism.springs.values():
        yield spring.first, spring.second
    for gear in mechanism.gears.values():
        yield gear.first, gear.second


def used_pins(mechanism: Mechanism) -> set[str]:
    """Return the pins, or bodies, that joints, springs, gears, loads and drivers use."""
    used = {pin for pair in connections(mechanism) for pin in pair}
    pushes = (push for load in mechanism.loads.values() for push in load.pushes(mechanism.joints))
    used |= {f"{push.body}.{push.pin}" for push in pushes} | {load.place for load in mechanism.loads.values()}
    return used | {driver.point for driver in mechanism.drivers.values()}
