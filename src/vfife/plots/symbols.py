"""Symbols of a mechanism: outlines of bodies, joints, springs, gears and loads, drawn from the strokes of the
model with matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..measures.motion import pin_path
from ..model.drawing.strokes import Block, Curve, JointView, Label, Mark, PairView, Stroke, Surface
from ..model.joints import Gear, Joint
from ..model.loads.load import Push
from ..model.mechanism import Mechanism
from ..model.outlines import CENTER, DOTTED_NODES, axis_between, corners, drawn_pins, wheels_at
from ..model.springs import AnySpring
from ..results.run_data import RunData
from .style import BODIES, GREY, INK, LOADS, SYMBOLS, TEXT_BOX, Array, length_unit


@dataclass
class Sheet:
    """Axes with the positions of a mechanism at an output.

    ``factor`` converts metres into the units drawn, ``size`` is that of the drawing in those units, ``shown``
    the output that is drawn. A body that shares its entry of ``colours`` with an earlier one is ``striped``.
    ``symbols`` are entries of the legend.
    """

    ax: Axes
    result: RunData
    factor: float
    size: float
    shown: int
    colours: dict[str, str]
    striped: frozenset[str] = frozenset()
    symbols: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def for_area(cls, ax: Axes, result: RunData, shown: int, low: Array, high: Array) -> Sheet:
        """Set up axes for what lies between two corners (m), in a length unit that suits them."""
        size = float(np.max(high - low)) or 1.0
        factor, unit = length_unit(size)
        names = list(result.record.assembly.bodies)
        colours = {name: BODIES[k % len(BODIES)] for k, name in enumerate(names)}
        limits = factor * np.stack([low, high], axis=1)
        ax.set(xlim=limits[0], ylim=limits[1], xlabel=f"x ({unit})", ylabel=f"y ({unit})")
        ax.set_autoscale_on(False)
        return cls(ax, result, factor, factor * size, shown, colours, frozenset(names[len(BODIES) :]))

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism of the result."""
        return self.result.record.assembly.mechanism

    def path(self, body: str, pin: str) -> Array:
        """Return the path of a pin in the units drawn, shape (outputs, 2)."""
        return self.factor * pin_path(self.result.record, body, pin)

    def at(self, end: str) -> Array:
        """Return the position of ``body.pin`` in the units drawn, shape (2,)."""
        body, _, pin = end.partition(".")
        return np.asarray(self.path(body, pin)[self.shown], dtype=float)

    def center(self, body: str, output: int) -> Array:
        """Return the centre of mass of a body at an output in the units drawn, shape (2,)."""
        column = list(self.result.record.assembly.bodies).index(body)
        places = [self.result.channels[f"body_{axis}"].values[output, column] for axis in "xy"]
        return self.factor * np.array(places)

    def angles(self, body: str) -> Array:
        """Return the angle of a body (rad), 0 of the ground, shape (outputs,)."""
        if body == "ground":
            return np.zeros(len(self.result.record.steps))
        column = list(self.result.record.assembly.bodies).index(body)
        return np.asarray(self.result.channels["body_angle"].values[:, column], dtype=float)

    def colour(self, body: str) -> str:
        """Return the colour of a body; that of ink for the ground."""
        return self.colours.get(body, INK)

    def line(self, points: Any, **look: Any) -> Any:
        """Draw a line through points (n, 2)."""
        style: dict[str, Any] = {"color": INK, "lw": 1.2, "zorder": 5} | look
        return self.ax.plot(*np.asarray(points, dtype=float).T, **style)[0]

    def hatched(self, first: Array, second: Array, inward: Array, depth: float) -> None:
        """Draw a surface from one point to another, its material hatched on the side of ``inward``."""
        self.line([first, second], lw=1.4, zorder=2)
        corners = np.array([first, second, second + depth * inward, first + depth * inward])
        self.ax.fill(*corners.T, facecolor="none", edgecolor=GREY, hatch="//////", lw=0.0, zorder=1.5)

    def box(self, centre: Array, direction: Array, length: float, height: float, **look: Any) -> Any:
        """Draw a rectangle with its length along a unit vector."""
        across = np.array([-direction[1], direction[0]])
        corners = [
            centre + 0.5 * (i * length * direction + j * height * across)
            for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        return self.ax.fill(*np.array(corners).T, **look)[0]


MARKS: dict[str, dict[str, Any]] = {
    "ring": {"marker": "o", "ms": 8, "mfc": "white", "mew": 1.4, "zorder": 7},
    "dot": {"marker": "o", "ms": 3.5, "zorder": 8},
    "pin": {"marker": "o", "ms": 6.5, "mfc": "white", "mew": 2.0, "zorder": 7},
    "square": {"marker": "s", "ms": 6, "zorder": 7},
    "bearing": {"marker": "o", "ms": 11, "mfc": "white", "mew": 1.8},
}
INNER: dict[str, dict[str, Any]] = {
    "bearing": {"marker": "o", "ms": 7.5, "mfc": "#cfcfcf", "mew": 0.9}
}  # of a sign of two
DASHES: dict[str, Any] = {"-": "-", "-.": "-.", ":": (0, (2, 2))}


def draw(sheet: Sheet, strokes: Iterable[Stroke], bodies: tuple[str, str] = ("ground", "ground")) -> None:
    """Draw the strokes of a joint, spring or gear between two bodies, whose colours they may take; those with
    a sign enter the legend.
    """
    colours = {
        "ink": INK,
        "grey": GREY,
        "spring": SYMBOLS,
        "bearing": sheet.colour(bodies[0]),
        "journal": sheet.colour(bodies[1]),
    }
    symbols: dict[str, list[Any]] = {}
    for stroke in strokes:
        if isinstance(stroke, Surface):
            sheet.hatched(stroke.first, stroke.second, stroke.inward, stroke.depth)
            continue
        artist = _stroke(sheet, stroke, colours[stroke.colour])
        if stroke.sign:
            symbols.setdefault(stroke.sign, []).append(artist)
    sheet.symbols |= {
        name: artists[0] if len(artists) == 1 else tuple(artists) for name, artists in symbols.items()
    }


def _stroke(sheet: Sheet, stroke: Curve | Block | Mark, colour: str) -> Any:
    if isinstance(stroke, Curve):
        look = {"lw": stroke.width, "zorder": stroke.rank, "ls": DASHES[stroke.dashes], "alpha": stroke.fade}
        return sheet.line(stroke.points, color=colour, **look)
    if isinstance(stroke, Mark):
        at: Any = ([], []) if stroke.at is None else stroke.at
        looks = [MARKS[stroke.shape], *([INNER[stroke.shape]] if stroke.shape in INNER else [])]
        drawn = tuple(
            sheet.ax.plot(*at, ls="", **({"mec": colour, "mfc": colour} | look))[0] for look in looks
        )
        return drawn if len(drawn) > 1 else drawn[0]
    box = stroke.centre, stroke.direction, stroke.length, stroke.height
    # Below the bodies, because the rod of a piston ends inside it.
    sheet.box(*box, facecolor="white", edgecolor="none", zorder=2.6)
    sheet.box(*box, facecolor=colour, alpha=0.35, edgecolor="none", zorder=2.7)
    return sheet.box(*box, facecolor="none", edgecolor=colour, lw=1.8, zorder=5)


@dataclass(frozen=True)
class Outline:
    """``path`` (m), shape (outputs, corners, 2), with NaN between separate pieces; ``plate`` if it encloses
    an area, ``dots`` at its nodes.
    """

    path: Array
    plate: bool = False
    dots: bool = False


def outline_of(result: RunData, name: str) -> Outline:
    """Return the nodes of an elastic link, members of a frame, or the pins of a rigid body that lie on its
    hull.
    """
    record = result.record
    body = record.assembly.bodies[name]
    if body.model == "frame":
        return Outline(_members(result, list(body.elements)))
    if body.elements:
        return Outline(_particles(result, list(body.particles)), dots=len(body.particles) <= DOTTED_NODES)
    pins = drawn_pins(record.assembly.mechanism, name)
    order, plate = corners(np.array([body.pins[pin] for pin in pins], dtype=float))
    pins = [pins[k] for k in order]
    return Outline(np.stack([pin_path(record, name, pin) for pin in pins or [CENTER]], axis=1), plate)


def _particles(result: RunData, nodes: list[int]) -> Array:
    return np.stack([result.record.block(f"particle_{axis}")[:, nodes] for axis in "xy"], axis=2)


def _members(result: RunData, elements: list[int]) -> Array:
    pairs = np.array([result.record.assembly.topology.frame_nodes[e][:2] for e in elements])
    ends = [_particles(result, list(pairs[:, k])) for k in (0, 1)]
    gaps = np.full_like(ends[0], np.nan)
    return np.asarray(np.stack([*ends, gaps], axis=2).reshape(len(gaps), -1, 2), dtype=float)


def draw_joints(sheet: Sheet) -> None:
    """Draw every joint, and the points of the ground that carry one."""
    for joint in sheet.mechanism.joints.values():
        draw(sheet, joint.strokes(joint_view(sheet, joint)), (joint.sides[0][0], joint.sides[1][0]))


def joint_view(sheet: Sheet, joint: Joint) -> JointView:
    """Return the position of a joint on the sheet."""
    bodies = (joint.sides[0][0], joint.sides[1][0])
    angles = [sheet.angles(body) for body in bodies]

    def travel_range(tilt: float) -> tuple[float, float]:
        away = sheet.path(*joint.sides[1]) - sheet.path(*joint.sides[0])
        direction = angles[0] + tilt
        travel = np.cos(direction) * away[:, 0] + np.sin(direction) * away[:, 1]
        return float(travel.min()), float(travel.max())

    current, start = ((float(angles[0][k]), float(angles[1][k])) for k in (sheet.shown, 0))
    ground = (bodies[0] == "ground", bodies[1] == "ground")
    at = sheet.at(joint.bearing)
    return JointView(
        at, sheet.at(joint.journal), current, start, ground, sheet.factor, sheet.size, travel_range,
        lambda: _leaving(sheet, joint, at),
    )  # fmt: skip


def _leaving(sheet: Sheet, joint: Joint, at: Array) -> Array:
    """Return the unit vector along one of the axes in which a body that is clamped to the ground
    leaves it.
    """
    body = next(owner for owner, _ in joint.sides if owner != "ground")
    body_map = sheet.result.record.assembly.bodies[body]
    if body_map.elements:
        nodes = sheet.factor * _particles(sheet.result, list(body_map.particles))[0]
        gap = np.linalg.norm(nodes - at, axis=1)
        target = nodes[np.argsort(gap)[min(1, len(nodes) - 1)]]
    else:
        target = sheet.center(body, 0)
    dx, dy = target - at
    return np.array([np.sign(dx) or 1.0, 0.0]) if abs(dx) >= abs(dy) else np.array([0.0, np.sign(dy)])


def label_places(sheet: Sheet) -> list[tuple[Label, list[str]]]:
    """Labels of joints with the names that they show; joints in one place share a label."""
    places: list[tuple[Label, list[str]]] = []
    for name, joint in sheet.mechanism.joints.items():
        label = joint.label(joint_view(sheet, joint))
        for place, names in places:
            if np.linalg.norm(place.at - label.at) < 0.02 * sheet.size and place.fixed == label.fixed:
                names.append(name)
                break
        else:
            places.append((label, [name]))
    return places


def joint_names(sheet: Sheet, sides: Mapping[str, Callable[[Array], Array]], farther: float = 0.0) -> None:
    """Write the names of joints beside their symbols. An entry of ``sides`` gives the side as a unit vector,
    for the position of the symbol; ``farther`` in points.
    """
    look = TEXT_BOX | {"fontsize": 9}
    for label, names in label_places(sheet):
        at, text = label.at, ", ".join(names)
        if label.fixed:
            sheet.ax.text(at[0], at[1], text, **look)
            continue
        offset = name_reach(text, farther) * sides[text](at)
        sheet.ax.annotate(text, (at[0], at[1]), xytext=tuple(offset), textcoords="offset points", **look)


def name_reach(text: str, farther: float) -> Array:
    """Return the half axes (points) of the ellipse around a symbol on which the middle of its name lies."""
    return np.array([12.0 + 2.6 * len(text), 17.0]) + farther


def draw_springs(sheet: Sheet) -> None:
    """Draw every spring."""
    for spring in sheet.mechanism.springs.values():
        draw(sheet, spring.strokes(spring_view(sheet, spring)))


def spring_view(sheet: Sheet, spring: AnySpring) -> PairView:
    """Return the position of a spring on the sheet: its pins, or twice the axis about which its bodies
    rotate.
    """
    if spring.between_pins:
        return PairView(sheet.at(spring.first), sheet.at(spring.second), 0.0, sheet.size)
    at = axis_of(sheet, spring.first, spring.second)
    return PairView(at, at, float(sheet.angles(spring.first)[sheet.shown]), sheet.size)


def draw_gears(sheet: Sheet) -> None:
    """Draw every gear and belt, with a spoke that shows how each wheel has turned."""
    for gear in sheet.mechanism.gears.values():
        view, bodies = gear_view(sheet, gear), (gear.first, gear.second)
        draw(sheet, gear.strokes(view), bodies)
        for body, (centre, radius) in zip(bodies, gear.wheels(view), strict=True):
            angle = sheet.angles(body)[sheet.shown]
            spoke = [centre, centre + radius * np.array([np.cos(angle), np.sin(angle)])]
            sheet.line(spoke, color=sheet.colour(body), lw=1.8, zorder=2.8)


def gear_view(sheet: Sheet, gear: Gear) -> PairView:
    """Return the position of a gear on the sheet: the axes of its wheels."""
    wheels = wheels_at(sheet.mechanism, gear, partial(axis_of, sheet), lambda a, b: bool(np.allclose(a, b)))
    return PairView(*wheels, 0.0, sheet.size)


def axis_of(sheet: Sheet, first: str, second: str) -> Array:
    """Return the axis about which two bodies rotate against each other: a pin, else the centre of mass of the
    second.
    """
    end = axis_between(sheet.mechanism, first, second)
    return sheet.center(second, sheet.shown) if end is None else sheet.at(end)


def arrows(sheet: Sheet, length: float) -> list[tuple[Array, Array]]:
    """Return the tip and tail of the arrow of each force and driven point."""
    forces = [(f"{push.body}.{push.pin}", push.acts[:2]) for push in pushes(sheet) if any(push.acts[:2])]
    forces += [
        (driver.point, driver.direction) for driver in sheet.mechanism.drivers.values() if driver.point
    ]
    return [
        (sheet.at(end), sheet.at(end) - length * np.array(force) / np.hypot(*force)) for end, force in forces
    ]


def pushes(sheet: Sheet) -> list[Push]:
    """Return the forces and moments of loads on bodies that can move."""
    loads = sheet.mechanism.loads.values()
    return [push for load in loads for push in load.pushes(sheet.mechanism.joints) if push.body != "ground"]


def draw_loads(sheet: Sheet) -> None:
    """Draw arrows for forces and driven points, arcs for moments."""
    look: dict[str, Any] = {"arrowstyle": "-|>", "color": LOADS, "lw": 2.0, "mutation_scale": 14.0}
    look |= {"shrinkA": 0.0, "shrinkB": 0.0}
    for tip, tail in arrows(sheet, 0.13 * sheet.size):
        sheet.ax.annotate("", tuple(tip), xytext=tuple(tail), arrowprops=look | {"shrinkB": 5.0}, zorder=8)
    for push in pushes(sheet):
        if not push.acts[2]:
            continue
        turn = np.linspace(-2.4, 1.2, 60) * np.sign(push.acts[2])
        arc = sheet.at(f"{push.body}.{push.pin}") + 0.045 * sheet.size * np.stack(
            [np.cos(turn), np.sin(turn)], axis=1
        )
        sheet.line(arc, color=LOADS, lw=2.0, zorder=8)
        sheet.ax.annotate("", tuple(arc[-1]), xytext=tuple(arc[-4]), arrowprops=look, zorder=8)
    if sheet.mechanism.loads or any(driver.point for driver in sheet.mechanism.drivers.values()):
        sheet.symbols["load"] = sheet.ax.plot([], [], color=LOADS, lw=2.0)[0]
