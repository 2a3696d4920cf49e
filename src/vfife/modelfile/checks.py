"""Checks across the tables of a model file, on the raw tables, to find what they can whatever else is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..laws import MATERIALS
from ..quantities import shown
from ..schema import body_kind
from .faults import Fault, Path, place, suggestion
from .lawtables import read_law
from .tables import IDLE_KEYS, NAMED, Raw, amount, entries, own_pins, pins, table

NAME_LIMIT = 64


class Checks:
    """One walk through a model; ``faults`` are what it found."""

    def __init__(self, raw: Raw, given: set[Path]) -> None:
        self.raw, self.given = raw, given
        self.faults: list[Fault] = []
        self.materials = (*MATERIALS, *table(raw, "material"))
        self.names()
        for name, body in entries(raw, "body"):
            self.body(name, body)
        sides: dict[frozenset[str], str] = {}
        for name, joint in entries(raw, "joint"):
            self.joint(name, joint, sides)
        for name, driver in entries(raw, "driver"):
            self.driver(name, driver)
        for name, load in entries(raw, "load"):
            self.load(name, load)
        self.run()

    def add(self, path: Path, what: str, remedy: str, limit: str = "") -> None:
        """One fault more, with the value that stands at the path."""
        holder = table(self.raw, *(str(part) for part in path[:-1]))
        value = shown(holder[path[-1]]) if path[-1] in holder else ""
        self.faults.append(Fault(place(path, self.given), what, value, limit, remedy))

    def names(self) -> None:
        """Names can be parts of a path."""
        if not any(True for _ in entries(self.raw, "body")):
            self.add(("body",), "the model has no body", "add a table such as [body.crank]")
        if "ground" in table(self.raw, "body"):
            self.add(("body", "ground"), '"ground" is what does not move', "call the body otherwise")
        for path in named_things(self.raw):
            name = str(path[-1])
            if not (0 < len(name) <= NAME_LIMIT and name.isprintable() and name == name.strip() and "." not in name):
                remedy = f"choose a name of 1 to {NAME_LIMIT} printable signs without dots"
                self.add((*path[:-1], ""), f"the name {shown(name)} cannot be part of a path", remedy)

    def body(self, name: str, body: Raw) -> None:
        """Keys that go together, and names of materials and pins."""
        self.material(("body", name), body, "material")
        for pin in table(body, "pins"):
            if pin in ("center", *own_pins(body)):
                self.add(("body", name, "pins", pin), "the body has a pin of this name already", "call it otherwise")
        if body_kind(body) == "<link>":
            self.link(name, body, body.get("model", "rigid"))
        if moving(body.get("velocity")) and self.turned(name):
            remedy = "remove it; the driver sets the velocity"
            self.add(("body", name, "velocity"), "a driven body has no initial velocity of its own", remedy)

    def link(self, name: str, body: Raw, model: Any) -> None:
        """What the model of a link needs, and what it has no use for."""
        for key in IDLE_KEYS.get(model, ()) if isinstance(model, str) else ():
            if key in body:
                users = " or ".join(other for other, idle in IDLE_KEYS.items() if key not in idle)
                remedy = f"remove it, or set model to {users}"
                self.add(("body", name, key), f"{article(model)} link has no use for this", remedy)
        if model in ("elastic", "two-particle") and "section" not in body:
            remedy = "add section = { area = ..., second_moment = ... } or { square = ... }"
            self.add(("body", name, "section"), f"{article(model)} link needs a section, which is missing", remedy)
        elif "mass" not in body and "section" not in body:
            self.add(("body", name, "mass"), "the link has neither a mass nor a section", "add one of the two")
        if isinstance(body.get("section"), dict):
            self.section(("body", name, "section"), body["section"])
        release, held = body.get("release", "none"), self.driven_end(name)
        if model in ("elastic", "two-particle") and held and release in (held, "both"):
            remedy = f'set model = "rigid", or release the other end only: the driver turns {name}.{held}'
            self.add(("body", name, "release"), "no driver can turn a link by an end that is released", remedy)

    def section(self, path: Path, section: Raw) -> None:
        """Area and second moment, or exactly one shape."""
        shapes = [key for key in ("square", "rectangle", "round") if key in section]
        both = {"area", "second_moment"} & set(section)
        if (len(shapes) == 1 and not both) or (not shapes and len(both) == 2):
            return
        what = "the section is described more than once" if shapes else "the section is not complete"
        limit = "area and second_moment together, or one of square, rectangle, round"
        self.add(path, what, "give one of these", limit)

    def joint(self, name: str, joint: Raw, sides: dict[frozenset[str], str]) -> None:
        """Both sides exist and differ, no pair is joined twice, the journal fits into its bearing, laws are known."""
        bearing, journal = joint.get("bearing"), joint.get("journal")
        for key, side in (("bearing", bearing), ("journal", journal)):
            self.side(("joint", name, key), side, ground=True)
        if isinstance(bearing, str) and isinstance(journal, str):
            if bearing.partition(".")[0] == journal.partition(".")[0]:
                remedy = "name a pin of another body, or of the ground"
                self.add(("joint", name, "journal"), "bearing and journal are on the same body", remedy)
            other = sides.setdefault(frozenset((bearing, journal)), name)
            if other != name:
                self.add(("joint", name, ""), f"joint {other} connects the same two pins already", "remove one of the two")
        self.material(("joint", name), joint, "bearing_material")
        self.material(("joint", name), joint, "journal_material")
        self.clearance(name, joint)
        for kind in ("contact", "friction"):
            if isinstance(joint.get(kind), dict) and joint.get("kind") != "ideal":
                self.faults += read_law(kind, joint[kind], ("joint", name, kind), self.given)[1]

    def clearance(self, name: str, joint: Raw) -> None:
        """The journal is smaller than its bearing by the clearance, and something of it remains."""
        size, radius = amount(joint, "clearance", "m"), amount(joint, "bearing_radius", "m")
        if size is not None and radius is not None and radius > 0.0 and size >= radius:
            limit = f"above 0 m and below bearing_radius = {radius:g} m"
            remedy = "check the units of both: clearance is bearing radius less journal radius"
            self.add(("joint", name, "clearance"), "as large as the bearing: no journal is left", remedy, limit)

    def driver(self, name: str, driver: Raw) -> None:
        """The body exists and turns about one ideal joint to the ground; one kind of driver, its lists alike."""
        path: Path = ("driver", name)
        if name not in table(self.raw, "body"):
            remedy = suggestion(name, table(self.raw, "body"), "name the table after the body that it drives")
            self.add((*path, ""), f"there is no body {name!r} to drive", remedy)
        elif self.turned(name) and len(self.pivots(name)) != 1 and not self.dangling():
            found = " and ".join(self.pivots(name)) or "none"
            remedy = 'hold the body by one joint of kind "ideal" whose other side is a point of the ground'
            self.add((*path, ""), f"a driven body turns about one ideal joint to the ground; here: {found}", remedy)
        kinds = [key for key in ("speed", "angles", "torque") if key in driver]
        if len(kinds) != 1:
            what = f"{' and '.join(kinds)} exclude each other" if kinds else "nothing says what the driver does"
            limit = "speed (with ramp), or angles and times, or torque (with times)"
            self.add((*path, ""), what, "give one of these", limit)
            return
        kind = kinds[0]
        if "ramp" in driver and kind != "speed":
            self.add((*path, "ramp"), f"a ramp goes with a speed, not with {kind}", "remove it")
        if "times" in driver and kind == "speed":
            self.add((*path, "times"), "times go with angles or torque, not with a speed", "remove it")
        elif kind == "angles" or "times" in driver or isinstance(driver.get("torque"), list):
            self.series(path, driver, kind)

    def load(self, name: str, load: Raw) -> None:
        """It acts at a pin of a body; its lists are alike."""
        self.side(("load", name, "at"), load.get("at"), ground=False)
        if "times" in load or "factors" in load:
            self.series(("load", name), load, "factors")

    def series(self, path: Path, holder: Raw, key: str) -> None:
        """Times ascend, two at least, and each has its value."""
        times, values = holder.get("times"), holder.get(key)
        for missing, other in (("times", key), (key, "times")):
            if missing not in holder:
                self.add((*path, missing), f"{other} and {missing} go together, and {missing} is missing", "add it")
        if not isinstance(times, list) or key not in holder:
            return
        if not isinstance(values, list) or len(values) != len(times):
            count = len(values) if isinstance(values, list) else 1
            self.add((*path, key), f"{count} for {len(times)} times", "give each time its value", f"{len(times)} values")
        if len(times) < 2:
            self.add((*path, "times"), "a table over time needs at least two times", "add more, or leave it out")
        seconds = [amount({"t": time}, "t", "s") for time in times]
        for k, (early, late) in enumerate(zip(seconds, seconds[1:], strict=False), 1):
            if early is not None and late is not None and late <= early:
                self.add((*path, "times"), f"times must ascend, and number {k + 1} does not", "sort them")
                break

    def run(self) -> None:
        """One length of the run, and turns only where something turns."""
        run = table(self.raw, "run")
        if "turns" in run and "duration" in run:
            self.add(("run", "duration"), "turns and duration exclude each other", "remove one of the two")
            return
        # A driver that does not say what it does is told itself, and may be meant to turn something.
        idle = all("torque" in driver and not self.turned(name) for name, driver in entries(self.raw, "driver"))
        if "turns" in run and idle:
            self.add(("run", "turns"), "nothing is driven, so there are no turns to count", "give a duration instead")

    def side(self, path: Path, side: Any, *, ground: bool) -> None:
        """A text ``body.pin`` names a pin that exists."""
        if not isinstance(side, str):
            return  # missing or of another type: the schema tells
        body, _, pin = side.partition(".")
        bodies = [*table(self.raw, "body"), *(["ground"] if ground else [])]
        if body not in bodies:
            every = [f"{name}.{pin}" for name in bodies for pin in pins(self.raw, name)]
            what = f"there is no body {body!r}" if body != "ground" else "a load on the ground moves nothing"
            self.add(path, what, suggestion(side, every, 'name a pin as "body.pin"'))
        elif pin not in pins(self.raw, body):
            what = f"{body} has no {'point' if body == 'ground' else 'pin'} {pin!r}" if pin else "the pin is missing"
            listed = [f"{body}.{one}" for one in pins(self.raw, body)]
            self.add(path, what, suggestion(side, listed, "name one that is there, or add it"))

    def material(self, path: Path, holder: Raw, key: str) -> None:
        """A material that is named exists."""
        name = holder.get(key)
        if isinstance(name, str) and name not in self.materials:
            remedy = suggestion(name, self.materials, f"add a table [material.{name}]")
            self.add((*path, key), "there is no material of this name", remedy)

    def turned(self, name: str) -> bool:
        """Whether a driver prescribes the angle of a body."""
        return bool({"speed", "angles"} & set(table(self.raw, "driver", name)))

    def dangling(self) -> bool:
        """Whether a joint names a body that does not exist: which bodies it holds is not known then."""
        known = {"ground", *table(self.raw, "body")}
        sides = [str(joint.get(side, "")) for _, joint in entries(self.raw, "joint") for side in ("bearing", "journal")]
        return not known >= {side.partition(".")[0] for side in sides}

    def pivots(self, name: str) -> list[str]:
        """Ideal joints between a body and the ground."""
        found = []
        for joint, entry in entries(self.raw, "joint"):
            held = {str(entry.get(side, "")).partition(".")[0] for side in ("bearing", "journal")}
            if held == {name, "ground"} and entry.get("kind", "ideal") == "ideal":
                found.append(joint)
        return found

    def driven_end(self, name: str) -> str:
        """The end of a link that a driver turns, or nothing."""
        joints = self.pivots(name) if self.turned(name) else []
        for joint in joints[:1]:
            for side in ("bearing", "journal"):
                body, _, pin = str(table(self.raw, "joint", joint).get(side, "")).partition(".")
                if body == name:
                    return pin
        return ""


def named_things(raw: Raw) -> Iterator[Path]:
    """Paths of everything that the user gives a name."""
    for section in NAMED:
        if section == "driver":
            continue  # named after a body, and told there
        yield from ((section, name) for name in table(raw, section))
    for body, _ in entries(raw, "body"):
        yield from (("body", body, "pins", pin) for pin in table(raw, "body", body, "pins"))


def moving(velocity: Any) -> bool:
    """Whether a velocity has a part that is not zero."""
    parts = zip(velocity, ("m/s", "m/s", "rad/s"), strict=False) if isinstance(velocity, list) else ()
    return any(amount({"v": value}, "v", unit) for value, unit in parts)


def article(word: Any) -> str:
    """The word with its article."""
    return f"{'an' if str(word)[:1] in 'aeiou' else 'a'} {word}"
