"""Checks across the tables of a model file, on the raw tables, to find what they can whatever else is wrong."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ..errors import Fault, Path, place, shown, suggestion
from ..laws import MATERIALS
from .schema import STATIC_ONLY, driver_kind
from .tables import NAMED, Raw, amount, amounts, entries, pins, table, text

NAME_LIMIT = 64
MOST_SUGGESTIONS = 40  # looking for names that look alike takes time, and nobody reads so many
SHORTEST_DIRECTION = 1e-9
MOTIONS = ("speed", "travel", "amplitude", "angles", "travels")
EFFORTS = ("torque", "force")


class Checks:
    """What the checks know of a model, and the ``faults`` they found."""

    def __init__(self, raw: Raw, given: set[Path]) -> None:
        self.raw, self.given = raw, given
        self.faults: list[Fault] = []
        self.suggestions = 0
        self.materials = (*MATERIALS, *table(raw, "material"))
        self.bodies = table(raw, "body")
        self.joints = dict(entries(raw, "joint"))
        self.drivers = dict(entries(raw, "driver"))
        self.turned = {body_of(name, driver): name for name, driver in self.drivers.items() if driver_kind(driver) == "<body>" and moves(driver)}
        self.pivots: dict[str, list[str]] = {}
        for name, joint in self.joints.items():
            held = {side.partition(".")[0] for side in sides(joint)}
            if joint.get("kind", "ideal") == "ideal" and len(held) == 2 and "ground" in held:
                self.pivots.setdefault(next(iter(held - {"ground"})), []).append(name)

    def add(self, path: Path, what: str, remedy: str, limit: str = "") -> None:
        """One fault more, with the value that stands at the path."""
        holder = table(self.raw, *path[:-1])
        value = shown(holder[path[-1]]) if path[-1] in holder else ""
        self.faults.append(Fault(place(path, self.given), what, value, limit, remedy))

    def near(self, name: str, known: Iterable[str], advice: str) -> str:
        """Did-you-mean, or the advice; only the first faults look for names that look alike."""
        self.suggestions += 1
        return suggestion(name, known, advice) if self.suggestions <= MOST_SUGGESTIONS else advice

    def names(self) -> None:
        """Names can be parts of a path."""
        if not any(True for _ in entries(self.raw, "body")):
            self.add(("body",), "the model has no body", "add a table such as [body.crank]")
        if "ground" in self.bodies:
            self.add(("body", "ground"), '"ground" is what does not move', "call the body otherwise")
        for path in named_things(self.raw):
            name = str(path[-1])
            if not (0 < len(name) <= NAME_LIMIT and name.isprintable() and name == name.strip() and "." not in name):
                remedy = f"choose a name of 1 to {NAME_LIMIT} printable signs without dots"
                self.add((*path[:-1], ""), f"the name {shown(name)} cannot be part of a path", remedy)

    def side(self, path: Path, side: Any, ground: str = "") -> bool:
        """Whether a text ``body.pin`` names a pin that exists; ``ground`` says why it must not be the ground's."""
        if not isinstance(side, str):
            return False  # missing or of another type: the schema tells
        body, _, pin = side.partition(".")
        bodies = [*self.bodies, *([] if ground else ["ground"])]
        if body not in bodies:
            every = (f"{name}.{pin}" for name in bodies for pin in pins(self.raw, name))
            what = f"there is no body {shown_name(body)}" if body != "ground" else ground
            self.add(path, what, self.near(side, every, 'name a pin as "body.pin"'))
            return False
        if pin not in pins(self.raw, body):
            what = f"{body} has no {'point' if body == 'ground' else 'pin'} {shown_name(pin)}" if pin else "the pin is missing"
            listed = (f"{body}.{one}" for one in pins(self.raw, body))
            self.add(path, what, self.near(side, listed, "name one that is there, or add it"))
            return False
        return True

    def body(self, path: Path, name: Any, *, ground: bool = True) -> bool:
        """Whether a text names a body that exists, or the ground."""
        if not isinstance(name, str):
            return False
        known = [*self.bodies, *(["ground"] if ground else [])]
        if name in known:
            return True
        remedy = self.near(name, known, "name a body")
        if "." in name and name.partition(".")[0] in known:
            remedy = f'name the body alone: "{name.partition(".")[0]}"'
        self.add(path, f"there is no body {shown_name(name)}", remedy)
        return False

    def material(self, path: Path, holder: Raw, key: str = "material") -> None:
        """A material that is named exists."""
        name = holder.get(key)
        if isinstance(name, str) and name not in self.materials:
            remedy = self.near(name, self.materials, f"add a table [material.{name}]")
            self.add((*path, key), "there is no material of this name", remedy)

    def direction(self, path: Path, holder: Raw) -> None:
        """A direction has a length."""
        parts = amounts(holder.get("direction"), ("1", "1"))
        if parts is not None and max(map(abs, parts)) < SHORTEST_DIRECTION:
            self.add((*path, "direction"), "a direction of no length points nowhere", "give it a part along x or y, as in [1, 0]")

    def series(self, path: Path, holder: Raw, key: str, over: str = "times", unit: str = "s") -> None:
        """What a table is over ascends, has two values at least, and each has its value."""
        points, values = holder.get(over), holder.get(key)
        for missing, other in ((over, key), (key, over)):
            if missing not in holder:
                self.add((*path, missing), f"{other} and {missing} go together, and {missing} is missing", "add it")
        if not isinstance(points, list) or key not in holder:
            return
        if not isinstance(values, list) or len(values) != len(points):
            count = len(values) if isinstance(values, list) else 1
            self.add((*path, key), f"{count} for {len(points)} {over}", f"give each of the {over} its value", f"{len(points)} values")
        if len(points) < 2:
            self.add((*path, over), f"a table over {over} needs at least two of them", "add more, or leave it out")
        numbers = [amount({"x": point}, "x", unit) for point in points]
        for k, (early, late) in enumerate(zip(numbers, numbers[1:], strict=False), 1):
            if early is not None and late is not None and late <= early:
                self.add((*path, over), f"{over} must ascend, and number {k + 1} does not", "sort them")
                break

    def run(self) -> None:
        """One length of the run, and turns only where something turns; a static analysis has none."""
        run = table(self.raw, "run")
        if run.get("analysis") == "static":
            self.static(run)
            return
        for key in STATIC_ONLY:
            if key in run:
                self.add(("run", key), "a dynamic analysis has no use for this", 'remove it, or set analysis = "static"')
        if "turns" in run and "duration" in run:
            self.add(("run", "duration"), "turns and duration exclude each other", "remove one of the two")
            return
        # A driver that does not say what it does is told itself, and may be meant to turn something.
        idle = all(driver_kind(driver) != "<body>" or (EFFORTS[0] in driver and not moves(driver)) for driver in self.drivers.values())
        if "turns" in run and idle:
            self.add(("run", "turns"), "nothing is driven, so there are no turns to count", "give a duration instead")

    def static(self, run: Raw) -> None:
        """Load factors take the place of time, so nothing has a duration or a speed."""
        for key in ("turns", "duration"):
            if key in run:
                remedy = "remove it; load_factors = [...] says for which loads equilibrium is sought"
                self.add(("run", key), "a static analysis takes no time", remedy)
        if run.get("load_factors") == []:
            self.add(("run", "load_factors"), "there is no load factor to find equilibrium for", "give one at least, or leave the key out")
        for name, driver in self.drivers.items():
            for key, remedy in (
                ("speed", "give a travel with a duration, or a table over times: the load factors take the place of time"),
                ("speeds", "give one torque or force, or a table over times"),
            ):
                if key in driver:
                    self.add(("driver", name, key), "nothing has a speed in a static analysis", remedy)


def shown_name(name: str) -> str:
    """A name in quotes, shortened."""
    return repr(name if len(name) <= NAME_LIMIT else name[: NAME_LIMIT - 3] + "...")


def sides(joint: Raw) -> tuple[str, str]:
    """Bearing and journal, empty where they are no texts."""
    return text(joint, "bearing"), text(joint, "journal")


def body_of(name: str, driver: Raw) -> str:
    """The body that a driver of a body drives."""
    return text(driver, "body", name)


def moves(driver: Raw) -> bool:
    """Whether a driver prescribes a motion; places beside a torque are those of its table."""
    return bool(set(MOTIONS) & set(driver)) and not (set(EFFORTS) & set(driver) and not {"speed", "travel", "amplitude"} & set(driver))


def named_things(raw: Raw) -> Iterator[Path]:
    """Paths of everything that the user gives a name."""
    for section in NAMED:
        for name in table(raw, section):
            # A driver's name is that of its body, and told there, unless it says otherwise.
            if section != "driver" or {"body", "slider", "point"} & set(table(raw, section, name)):
                yield (section, name)
    for body, _ in entries(raw, "body"):
        for key in ("pins", "nodes"):
            yield from (("body", body, key, pin) for pin in table(raw, "body", body, key))


def article(word: Any) -> str:
    """The word with its article."""
    return f"{'an' if str(word)[:1] in 'aeiou' else 'a'} {word}"
