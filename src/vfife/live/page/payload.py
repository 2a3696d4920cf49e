"""Data of a page as JSON: names, indices of numbers, outlines of bodies, strokes, equilibria of static
analyses.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import __version__
from ...assembly.assembled import Assembly, BodyMap
from ...errors import VfifeError
from ...kernels.arrays import Layout
from ...kernels.blocks import BLOCKS
from ...kernels.topology import CURRENT
from ...measures.forces import KINDS, joint_rows, normals, peaks
from ...model.bodies import PointMass
from ...model.drawing.strokes import PairView
from ...model.joints import Gear
from ...model.outlines import DOTTED_NODES, axis_between, corners, drawn_pins, loose_pins, wheels_at
from ...model.springs import AnySpring
from ...modelfile import dump
from ...simulation.result import Result
from ...solvers.record import Record, recorded_rows
from . import strokes
from .page_model import DEPTHS, PageModel

Pin = list[float]  # particle, x and y (m) in its frame


def pin_of(assembly: Assembly, end: str) -> Pin:
    """Return the particle and offset of ``body.pin`` or ``ground.point``."""
    body, _, pin = end.partition(".")
    if body == "ground":
        return [0, *assembly.mechanism.points[pin]]
    body_map = assembly.bodies[body]
    if body_map.elements:
        return [body_map.nodes[pin], 0.0, 0.0]
    return [body_map.particles[0], *map(float, np.subtract(body_map.pins[pin], body_map.reference))]


def centre_of(assembly: Assembly, body: str) -> Pin:
    """Return the centre of mass of a rigid body, or the middle node of a deformable one."""
    body_map = assembly.bodies[body]
    if body_map.elements:
        return [body_map.particles[len(body_map.particles) // 2], 0.0, 0.0]
    return [body_map.particles[0], *map(float, np.subtract(body_map.center, body_map.reference))]


def axis_of(assembly: Assembly, first: str, second: str) -> Pin:
    """Return the axis of relative rotation of two bodies: a common pin, else the centre of mass of the
    second.
    """
    end = axis_between(assembly.mechanism, first, second)
    return centre_of(assembly, second) if end is None else pin_of(assembly, end)


def ends_of(assembly: Assembly, spring: AnySpring) -> tuple[Pin, Pin]:
    """Return the pins of a spring; of one about an axis, that axis twice."""
    if spring.between_pins:
        return pin_of(assembly, spring.first), pin_of(assembly, spring.second)
    axis = axis_of(assembly, spring.first, spring.second)
    return axis, axis


def axes_of(assembly: Assembly, gear: Gear) -> tuple[Pin, Pin]:
    """Return the axes of the two wheels of a gear."""

    def same(first: Pin, second: Pin) -> bool:
        return bool(np.allclose(place(assembly, first), place(assembly, second)))

    return wheels_at(assembly.mechanism, gear, lambda first, second: axis_of(assembly, first, second), same)


def place(assembly: Assembly, pin: Pin) -> tuple[float, float]:
    """Return the start position of a pin (m)."""
    particle, x, y = int(pin[0]), pin[1], pin[2]
    px, py, angle = (
        float(assembly.state[assembly.layout.row(f"particle_{axis}", particle)])
        for axis in ("x", "y", "theta")
    )
    c, s = np.cos(angle), np.sin(angle)
    return float(px + c * x - s * y), float(py + s * x + c * y)


def outline(assembly: Assembly, body: BodyMap) -> dict[str, Any]:
    """Return the outline of a body as connected lists of pins, and whether it is a plate and shows
    its nodes.
    """
    if body.model == "frame":
        pairs = [assembly.topology.frame_nodes[e][:2] for e in body.elements]
        return {
            "pieces": [[[first, 0.0, 0.0], [second, 0.0, 0.0]] for first, second in pairs],
            "plate": False,
            "dots": False,
        }
    if body.elements:
        return {
            "pieces": [[[p, 0.0, 0.0] for p in body.particles]],
            "plate": False,
            "dots": len(body.particles) <= DOTTED_NODES,
        }
    pins = drawn_pins(assembly.mechanism, body.name)
    at = np.array([body.pins[pin] for pin in pins] or [body.center], dtype=float)
    order, plate = corners(at)
    points = at[order] - np.asarray(body.reference)
    return {
        "pieces": [[[body.particles[0], float(x), float(y)] for x, y in points]],
        "plate": plate,
        "dots": False,
    }


Json = dict[str, Any]
ROLES = ("state", "extreme", "parameter")
LEDGER_ROWS = ("reference_inverse_length",)  # of what the next step alone needs, what the ledger reads
# Scratch of contacts that a page's step leaves, so that no page says again which way a contact presses
LEFT = ("nx", "ny")


def base64_of(values: NDArray[Any]) -> str:
    """Return numbers as base64 of their little-endian bits."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode("ascii")


def payload(model: PageModel) -> Json:
    """Return all data of a page except the text of the step and the sliders."""
    assembly, mechanism, choice = model.assembly, model.assembly.mechanism, model.assembly.choice
    names = [name for name, body in assembly.bodies.items() if body.driven == 0]
    return {
        "version": __version__, "name": mechanism.name, "note": mechanism.note, "model": dump(mechanism),
        "crank": names[0] if names else None, "outputs": choice.outputs, "perTurn": per_turn(assembly),
        "step": choice.step, "damped": assembly.topology.damped,
        "parts": {name: len(values) for name, values in model.parts.items()},
        "vector": base64_of(model.vector), "depths": DEPTHS.tolist(), "own": stepper_data(assembly),
        "ideal": stepper_data(model.ideal) if model.ideal else None, "bodies": bodies(assembly),
        "joints": joints(assembly), "contacts": contacts(assembly), "springs": springs(assembly),
        "loads": loads(assembly), "points": points(assembly),
    }  # fmt: skip


def scratch_rows(layout: Layout) -> list[int]:
    """Return the scratch rows that the page reads in addition to the recorded ones."""
    return [int(row) for name in LEFT for row in layout[name]]


def per_turn(assembly: Assembly) -> int | None:
    """Return the outputs per turn, None without a crank."""
    turn, choice = assembly.choice.turn, assembly.choice
    return None if turn is None else round(turn / choice.step / choice.outputs_every)


def stepper_data(assembly: Assembly) -> Json:
    """Return what the worker needs to step an assembly and to find its numbers: rows by block, rows kept,
    rows of extremes.
    """
    layout, topology = assembly.layout, assembly.topology
    names = [block.name for block in BLOCKS if block.role in ROLES or block.name in (*LEDGER_ROWS, *LEFT)]
    rows = {name: layout[name].tolist() for name in names if len(layout[name])}
    record = _record(assembly)
    extremes = {name: {"block": block, "at": at} for name, (block, at) in peaks(record).items()}
    forces = {
        name: {"block": block, "at": at, "most": extremes[name]}
        for name, (block, at) in joint_rows(record).items()
    }
    return {
        "every": assembly.choice.outputs_every, "again": assembly.mechanism.settings.parts, "rows": rows,
        "joints": forces,
        "kept": [*recorded_rows(assembly).tolist(), *scratch_rows(layout)], "extremes": layout.of("extreme"),
        "free": list(topology.free), "driven": list(topology.driven),
        "present": [kind == CURRENT for kind in topology.strains], "perTurn": per_turn(assembly),
        "torques": {body.name: body.driven for body in assembly.bodies.values() if body.driven is not None},
        "alphas": {name: body.row for name, body in assembly.bodies.items()},
    }  # fmt: skip


def _record(assembly: Assembly) -> Record:
    rows = recorded_rows(assembly)
    return Record(assembly, np.zeros(1, dtype=np.int64), assembly.state[rows][None, :], rows)


def bodies(assembly: Assembly) -> list[Json]:
    """Return the bodies: how they are drawn, and the particles that move them."""
    return [_body(assembly, body) for body in assembly.bodies.values()]


def _body(assembly: Assembly, body: BodyMap) -> Json:
    source = assembly.mechanism.bodies[body.name]
    inverse = assembly.state[assembly.layout["particle_inverse_mass"][list(body.particles)]]
    mass = [1.0 / float(value) if value > 0.0 else 0.0 for value in inverse]
    fixed = sum(value == 0.0 for value in mass)
    left = (body.mass - sum(mass)) / fixed if fixed else 0.0
    loose = loose_pins(assembly.mechanism, body.name, bool(body.elements))
    return {
        "name": body.name, "chord": bool(body.elements), "particles": list(body.particles),
        "masses": [value or left for value in mass],
        "centre": centre_of(assembly, body.name), "driven": body.driven, "row": body.row,
        "turns": not (isinstance(source, PointMass) and source.inertia == 0.0),
        "outline": outline(assembly, body),
        "loose": [pin_of(assembly, f"{body.name}.{pin}") for pin in loose],
    }  # fmt: skip


def joints(assembly: Assembly) -> list[Json]:
    """Return the joints with their pins and strokes."""
    size, entries = extent(assembly), []
    for name, joint in assembly.mechanism.joints.items():
        pins = pin_of(assembly, joint.bearing), pin_of(assembly, joint.journal)
        sides = joint.sides[0][0], joint.sides[1][0]
        angles = (_angle(assembly, pins[0]), _angle(assembly, pins[1]))
        at = strokes.Inputs(place(assembly, pins[0]), place(assembly, pins[1]), angles, size)
        drawn, tilt = strokes.joint_strokes(joint, at, angles, (sides[0] == "ground", sides[1] == "ground"))
        around, *reaches = joint.drawn
        words = {
            "reaches": [reach or 0.0 for reach in reaches],
            "around": [list(point) for point in around],
            "words": joint.words,
            "bodies": sides,
            "turned": sides[0] != "ground",
        }
        entries.append(
            {"name": name, "bearing": pins[0], "journal": pins[1], "strokes": drawn, "tilt": tilt, **words}
        )
    return entries


def contacts(assembly: Assembly) -> list[Json]:
    """Return joint, kind and bodies of each contact."""
    topology = assembly.topology
    pairs = zip(topology.contact_kind, topology.contact_bearing, topology.contact_journal, strict=True)
    return [
        {"name": name, "joint": joint, "kind": KINDS[kind], "bearing": bearing, "journal": journal}
        for name, joint, (kind, bearing, journal) in zip(
            assembly.contacts, assembly.contact_joints, pairs, strict=True
        )
    ]


def springs(assembly: Assembly) -> list[Json]:
    """Return springs and gears with their pins and strokes."""
    size, entries = extent(assembly), []
    pairs: list[tuple[Any, tuple[Pin, Pin], tuple[str, str]]] = [
        (spring, ends_of(assembly, spring), ("ground" if spring.between_pins else spring.first, "ground"))
        for spring in assembly.mechanism.springs.values()
    ]
    pairs += [
        (gear, axes_of(assembly, gear), (gear.first, gear.second))
        for gear in assembly.mechanism.gears.values()
    ]
    for part, (first, second), sides in pairs:
        start, end = place(assembly, first), place(assembly, second)
        turner = 0 if sides[0] == "ground" else assembly.bodies[sides[0]].particles[0]
        drawn = strokes.pair_strokes(
            part, strokes.Inputs(start, end, (_angle(assembly, [turner]), 0.0), size)
        )
        wheels = (
            part.wheels(PairView(np.array(start), np.array(end), 0.0, size)) if isinstance(part, Gear) else ()
        )
        turned = [
            [0 if side == "ground" else assembly.bodies[side].particles[0], float(r)]
            for side, (_, r) in zip(sides, wheels, strict=False)
        ]
        entries.append(
            {
                "name": part.name,
                "words": part.words,
                "wheels": turned,
                "bearing": first,
                "journal": second,
                "turner": turner,
                "bodies": sides,
                "strokes": drawn,
            }
        )
    return entries


def loads(assembly: Assembly) -> list[Json]:
    """Return constant forces and moments: where they act on a body that can move, and the particle that turns
    their direction (None for the ground).
    """
    entries = []
    for load in assembly.mechanism.loads.values():
        for push in load.pushes(assembly.mechanism.joints):
            if push.body == "ground":
                continue
            at = pin_of(assembly, f"{push.body}.{push.pin}") if push.pin else centre_of(assembly, push.body)
            turner = push.aligned or (push.body if push.follow else "ground")
            particle = 0 if turner == "ground" else assembly.bodies[turner].particles[0]
            entries.append({"name": load.name, "at": at, "acts": list(push.acts), "turner": particle})
    return entries


def points(assembly: Assembly) -> list[list[float]]:
    """Return the points of the ground (m)."""
    return [[float(x), float(y)] for x, y in assembly.mechanism.points.values()]


def _angle(assembly: Assembly, pin: Pin) -> float:
    return float(assembly.state[assembly.layout.row("particle_theta", int(pin[0]))])


def extent(assembly: Assembly) -> float:
    """Return the approximate size of a drawing (m): the largest extent of the mechanism at its start."""
    at = [
        place(assembly, pin)
        for body in assembly.bodies.values()
        for piece in outline(assembly, body)["pieces"]
        for pin in piece
    ]
    for joint in assembly.mechanism.joints.values():
        for end, reach in zip((joint.bearing, joint.journal), joint.drawn[1:], strict=True):
            x, y = place(assembly, pin_of(assembly, end))
            at += [(x - reach, y - reach), (x + reach, y + reach)] if reach else []
    spread = np.ptp(np.array([*at, *assembly.mechanism.points.values()], dtype=float).reshape(-1, 2), axis=0)
    return float(spread.max(initial=0.0)) or 1.0


def static_payload(result: Result) -> Json:
    """Return the data of a page of equilibria: all rows, and the directions of contact forces. Raises
    VfifeError if only the start was computed.
    """
    record = result.record
    if len(record.steps) < 2:
        raise VfifeError(
            "no equilibrium but the start was found, so there is no load path to show."
            f" {record.message}".rstrip()
        )
    pressed = normals(record)
    rows = np.hstack([record.rows, pressed[..., 0], pressed[..., 1]])
    notes = (
        []
        if record.status == "complete"
        else [f"the analysis ended {record.status} at load factor {result.time[-1]:g}"]
    )
    return payload(PageModel(record.assembly, None)) | {
        "outputs": len(rows) - 1, "factors": result.time.tolist(), "path": base64_of(rows), "slides": [],
        "groups": [], "notes": notes, "texts": True,
    }  # fmt: skip
