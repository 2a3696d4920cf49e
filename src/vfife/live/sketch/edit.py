"""The state that an operation changes: tables of a model file, and where its parts are at the start."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

from ...errors import Fault, ModelError, suggestion
from ...kinematics.initial import Motion
from ...model.bodies import Frame, Link, PointMass, RigidBody
from ...model.mechanism import Mechanism
from ...model.rows import FixedDistance, Guided, place_row
from ...modelfile import loads
from ...modelfile.edits import rewritten
from ...modelfile.tables import Raw, table
from ...units import number, quantity_in_si
from .pose import Point, Pose, Side, pin_side, turned

FINENESS = 1e-4  # of the size of a mechanism: resolution of lengths, rounded down to a power of ten
ANGLE = 1e-5  # rad, resolution of angles
QUANTITY = re.compile(r"\s*([-+0-9.eE]+)\s*(\S.*?)\s*")


@dataclass(eq=False)
class Edit:
    """The tables of a model, changed in place by an operation, and its ``pose`` before."""

    raw: Raw
    pose: Pose
    file: str | None = None

    @classmethod
    def of(cls, text: str, file: str | None = None) -> Edit:
        """Return the state of a valid model file; its tables are beside ``file``. Raises ModelError."""
        return cls(tomllib.loads(text), Pose.of(loads(text, file=file)), file)

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism before the operation."""
        return self.pose.mechanism

    # -------------------------------------------------------------------------------------------- arguments

    def side(self, pin: Any) -> Side:
        """Return the body and name of a pin. Raises ModelError if there is none."""
        pins = [".".join(side) for side in self.pose.sides]
        if pin not in pins:
            raise refusal(f"there is no pin {pin!r}", suggestion(str(pin), pins, "name one that is there"))
        return pin_side(pin)

    def entry(self, section: str, name: Any) -> dict[str, Any]:
        """Return a named table. Raises ModelError if there is none."""
        entries = table(self.raw, section)
        if not isinstance(name, str) or not isinstance(entries.get(name), dict):
            remedy = suggestion(str(name), entries, "name one that is there")
            raise refusal(f"there is no {section} {name!r}", remedy)
        result: dict[str, Any] = entries[name]
        return result

    def name(self, section: str, stem: str) -> str:
        """Return a name that is free in a section: the ``stem``, if necessary with a number."""
        return unused(stem, {*table(self.raw, section), "ground"})

    # -------------------------------------------------------------------------------------------- quantities

    def length(self, value: float, old: Any = None) -> Any:
        """Return a length (m) as it is written in place of the ``old`` one."""
        step = resolution(self.pose.size)
        if old is not None and abs(number(old, "m") - value) < 0.5 * step:
            return old
        bare = isinstance(old, int | float) and old != 0
        unit = unit_of(old) or ("" if bare else length_unit(self.raw))
        return quantity_text(value, step, unit)

    def place(self, point: Point, old: Any = None) -> list[Any]:
        """Return a place (m) as it is written in place of the ``old`` one."""
        olds = old if isinstance(old, list) and len(old) == 2 else (None, None)
        return [self.length(value, written) for value, written in zip(point, olds, strict=True)]

    # ------------------------------------------------------------------------------------------------ places

    def move(self, side: Side, target: Point) -> None:
        """Move one pin to a place (m); the other pins of its body remain where they are."""
        body, pin = side
        if body == "ground":
            ground = self.raw["ground"]
            ground[pin] = self.place(target, ground[pin])
            return
        part, entry = self.mechanism.bodies[body], self.entry("body", body)
        if isinstance(part, Link) and pin in part.own_points:
            self.span(
                part,
                entry,
                *(target if name == pin else self.pose.place((body, name)) for name in part.own_points),
            )
        elif (isinstance(part, RigidBody) and pin == "center" and not self._holds_others(body)) or isinstance(
            part, PointMass
        ):
            self._translate(entry, body, target)
        elif isinstance(part, RigidBody) and pin == "center":
            entry["center"] = self.place(self.pose.local(body, target), entry.get("center"))
        else:
            pins = entry["nodes" if isinstance(part, Frame) else "pins"]
            pins[pin] = self.place(self.pose.local(body, target), pins[pin])

    def span(self, link: Link, entry: dict[str, Any], start: Point, end: Point) -> None:
        """Place a link between two points (m); its other pins remain where they are."""
        length = math.dist(start, end)
        if length < resolution(self.pose.size):
            raise refusal(f"{link.name} would have no length", "leave a distance between its ends")
        direction = math.atan2(end[1] - start[1], end[0] - start[0])
        origin, old_direction = self.pose.place((link.name, "start")), self.pose.angle(link.name)

        def local(point: Point) -> Point:
            (x, y), (dx, dy) = origin, turned(point, old_direction)
            return turned((x + (dx - start[0]), y + (dy - start[1])), -direction)

        self.lengthen(link, entry, length)
        if abs(math.remainder(direction - link.angle, 2.0 * math.pi)) > ANGLE:
            entry["angle"] = angle(direction, entry.get("angle"))
        if "position" in entry:
            entry["position"] = self.place(start, entry["position"])
        for name, place in link.pins.items():
            entry["pins"][name] = self.place(local(place), entry["pins"][name])
        if link.via:
            entry["via"] = [
                self.place(local(place), old) for place, old in zip(link.via, entry["via"], strict=True)
            ]

    def lengthen(self, link: Link, entry: dict[str, Any], length: float) -> None:
        """Give a link a length (m); its centre of mass keeps its share of it."""
        entry["length"] = self.length(length, entry["length"])
        if link.center_at:
            entry["center_at"] = self.length(link.center_at * length / link.length, entry["center_at"])

    def _translate(self, entry: dict[str, Any], body: str, target: Point) -> None:
        """Move a body so that its centre comes to a place (m)."""
        x, y = (
            a + b - c
            for a, b, c in zip(self.pose.origin(body), target, self.pose.place((body, "center")), strict=True)
        )
        if "position" in entry:
            entry["position"] = self.place((x, y), entry["position"])

    def _holds_others(self, body: str) -> bool:
        """Return whether joints hold a body at pins other than its centre."""
        sides = [side for joint in self.mechanism.joints.values() for side in joint.sides]
        return any(side[0] == body and side[1] != "center" for side in sides)

    def on_guides(self, cluster: tuple[Side, ...], target: Point) -> Point:
        """Return the place nearest to ``target`` (m) that the guides of a pin allow."""
        for joint in self.mechanism.joints.values():
            bearing, journal = joint.sides
            row = place_row(joint.rows())
            if isinstance(row, Guided) and journal in cluster and bearing not in cluster:
                bx, by = self.pose.place(bearing)
                dx, dy = turned(row.unit(), self.pose.angle(bearing[0]))
                distance = (target[0] - bx) * dx + (target[1] - by) * dy
                target = bx + distance * dx, by + distance * dy
        return target

    def stretch_rods(self, cluster: tuple[Side, ...], target: Point) -> None:
        """Give the joints that keep a moved pin at a distance their new length."""
        for name, joint in self.mechanism.joints.items():
            ends = [side for side in joint.sides if side not in cluster]
            if isinstance(place_row(joint.rows()), FixedDistance) and len(ends) == 1:
                entry = self.entry("joint", name)
                entry["length"] = self.length(math.dist(self.pose.place(ends[0]), target), entry["length"])

    def fixed_text(self, original: str) -> str:
        """Return the text of the changed model with its bodies where they were before.

        A body that fewer joints hold, or another one, would be closed from its approximate angle into another
        place; such bodies get their angle, then also their position, as they were. Bodies that must move
        remain as they are. Raises ModelError if the model is not valid.
        """
        first = text = self.text(original)
        if not isinstance(self.pose.motion, Motion):
            return first
        for positions in (False, True):
            if not self._displaced(text):
                return text
            for body in self._displaced(text, 0.02):
                entry, turned = self.entry("body", body), self.pose.angle(body)
                if "angle" in entry or abs(turned) > ANGLE:
                    entry["angle"] = angle(turned, entry.get("angle"))
                if positions or "position" in entry:
                    entry["position"] = self.place(self.pose.origin(body), entry.get("position"))
            text = self.text(original)
        return first if self._displaced(text) else text

    def _displaced(self, text: str, share: float = 1.0) -> list[str]:
        """Return the bodies that are elsewhere at the start of a text, by more than a ``share`` of what can
        be seen: all if it does not close, none if that is because too many joints hold them.
        """
        present, fine = Pose.of(loads(text, file=self.file)), 3.0 * resolution(self.pose.size) * share
        bodies = [name for name in present.mechanism.bodies if name in self.mechanism.bodies]
        if not isinstance(present.motion, Motion):
            return bodies if present.surplus <= 0 else []
        return [
            name
            for name in bodies
            if math.dist(present.origin(name), self.pose.origin(name)) > fine
            or abs(math.remainder(present.angle(name) - self.pose.angle(name), 2.0 * math.pi)) > 1e-3 * share
        ]

    def text(self, original: str) -> str:
        """Return the text of the changed model. Raises ModelError if it is not valid."""
        changed = rewritten(original, self.raw)
        loads(changed, file=self.file)
        return changed


def unused(stem: str, names: Collection[str]) -> str:
    """Return ``stem``, if necessary with a number, that is none of the names."""
    candidates = (stem, *(f"{stem}-{k}" for k in range(2, len(names) + 3)))
    return next(name for name in candidates if name not in names)


def refusal(message: str, remedy: str) -> ModelError:
    """Return the error of an operation that cannot be done."""
    return ModelError([Fault("", message, remedy=remedy)], "sketch")


def finite(*values: Any) -> Point:
    """Return two numbers. Raises ModelError for anything else."""
    if len(values) != 2 or not all(
        isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        for value in values
    ):
        raise refusal(f"{values!r} are not finite numbers", "give coordinates in m")
    return float(values[0]), float(values[1])


# --------------------------------------------------------------------------- quantities as a user writes them


def resolution(size: float) -> float:
    """Return the resolution (m) of lengths in a mechanism of a ``size`` (m)."""
    return 10.0 ** math.floor(math.log10(size * FINENESS)) if size > 0.0 else 1e-6


def unit_of(value: Any) -> str:
    """Return the unit of a value as written; "" for a bare number and for anything else."""
    match = QUANTITY.fullmatch(value) if isinstance(value, str) else None
    return match[2] if match else ""


def length_unit(raw: Raw) -> str:
    """Return the unit in which a model gives its lengths; "" if it gives them as bare numbers."""
    values: Iterable[Any] = [
        *(body.get("length") for body in table(raw, "body").values() if isinstance(body, dict)),
        *(part for point in table(raw, "ground").values() if isinstance(point, list) for part in point),
    ]
    return next((unit for value in values if (unit := unit_of(value))), "")


def quantity_text(value: float, step: float, unit: str) -> Any:
    """Return a number (SI), rounded to a ``step`` (SI), as a bare number or as a text with its unit.

    >>> quantity_text(0.41237, 1e-4, "mm"), quantity_text(0.41237, 1e-4, "")
    ('412.4 mm', 0.4124)
    """
    factor = quantity_in_si("1", unit) if unit else 1.0
    decimals = max(0, -math.floor(math.log10(step / factor) + 1e-9))
    text = f"{round(value / factor, decimals) + 0.0:.{decimals}f}"
    if unit:
        return f"{text.rstrip('0').rstrip('.') if '.' in text else text} {unit}"
    number = float(text)
    return int(number) if number == int(number) else number


def angle(value: float, old: Any) -> Any:
    """Return an angle (rad) within half a turn, in the unit of the angle before; in degrees if there is
    none.
    """
    turned = math.remainder(value, 2.0 * math.pi)
    unit = unit_of(old) or ("" if isinstance(old, float) else "deg")
    return quantity_text(turned, ANGLE, unit)
