"""What a page is given: names, places of numbers, strokes and numbers, as JSON."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..analysis.forces import KINDS, joint_rows, peaks
from ..assembly.assembled import Assembly, BodyMap
from ..kernels.arrays import Layout
from ..kernels.blocks import BLOCKS
from ..kernels.topology import CURRENT
from ..model.bodies import PointMass
from ..model.joints import Gear
from ..model.outlines import loose_pins
from ..model.strokes import PairSeen
from ..modelfile import dump
from ..solvers.record import Record, recorded_rows
from . import outlines, strokes
from .together import DEPTHS, Together

Json = dict[str, Any]
ROLES = ("state", "extreme", "parameter")
ALSO = ("reference_inverse_length",)  # of what the next step alone needs, what the ledger reads
LEFT = ("nx", "ny")  # scratch of contacts that a page's step leaves, so that no page says again which way a contact presses


def packed(values: NDArray[Any]) -> str:
    """Numbers as their little-endian bits, in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode("ascii")


def given(found: Together) -> Json:
    """All that a page knows of a mechanism, but the text of its step and its sliders."""
    own = found.own
    names = [name for name, body in own.bodies.items() if body.driven == 0]
    return {
        "version": __version__, "name": own.mechanism.name, "note": own.mechanism.note, "model": dump(own.mechanism),
        "crank": names[0] if names else None, "outputs": own.choice.outputs, "perTurn": per_turn(own), "step": own.choice.step,
        "damped": own.topology.damped, "parts": {name: len(values) for name, values in found.parts.items()}, "vector": packed(found.vector),
        "depths": DEPTHS.tolist(), "own": stepped(own), "ideal": stepped(found.ideal) if found.ideal else None, "bodies": bodies(own),
        "joints": joints(own), "contacts": contacts(own), "springs": springs(own), "loads": loads(own), "points": points(own),
    }  # fmt: skip


def left(layout: Layout) -> list[int]:
    """Scratch rows that the step of a page leaves, behind those that a run records."""
    return [int(row) for name in LEFT for row in layout[name]]


def per_turn(assembly: Assembly) -> int | None:
    """Outputs of a turn; None without a crank."""
    turn, choice = assembly.choice.turn, assembly.choice
    return None if turn is None else round(turn / choice.step / choice.outputs_every)


def stepped(assembly: Assembly) -> Json:
    """What it takes to step an assembly and to find its numbers: rows by block, those that are kept, those that begin anew."""
    layout, topology = assembly.layout, assembly.topology
    told = [block.name for block in BLOCKS if block.role in ROLES or block.name in (*ALSO, *LEFT)]
    rows = {name: layout[name].tolist() for name in told if len(layout[name])}
    record = _record(assembly)
    most = {name: {"block": block, "at": at} for name, (block, at) in peaks(record).items()}
    own = {name: {"block": block, "at": at, "most": most[name]} for name, (block, at) in joint_rows(record).items()}
    return {
        "every": assembly.choice.outputs_every, "again": assembly.mechanism.settings.parts, "rows": rows, "joints": own,
        "kept": [*recorded_rows(assembly).tolist(), *left(layout)], "extremes": layout.of("extreme"),
        "free": list(topology.free), "driven": list(topology.driven),
        "present": [kind == CURRENT for kind in topology.strains], "perTurn": per_turn(assembly),
        "torques": {body.name: body.driven for body in assembly.bodies.values() if body.driven is not None},
        "alphas": {name: body.row for name, body in assembly.bodies.items()},
    }  # fmt: skip


def _record(assembly: Assembly) -> Record:
    kept = recorded_rows(assembly)
    return Record(assembly, np.zeros(1, dtype=np.int64), assembly.state[kept][None, :], kept)


def bodies(assembly: Assembly) -> list[Json]:
    """Bodies: how they are drawn, and where their motion is found."""
    return [_body(assembly, body) for body in assembly.bodies.values()]


def _body(assembly: Assembly, body: BodyMap) -> Json:
    noun = assembly.mechanism.bodies[body.name]
    inverse = assembly.state[assembly.layout["particle_inverse_mass"][list(body.particles)]]
    mass = [1.0 / float(value) if value > 0.0 else 0.0 for value in inverse]
    held = sum(value == 0.0 for value in mass)
    left = (body.mass - sum(mass)) / held if held else 0.0
    loose = loose_pins(assembly.mechanism, body.name, bool(body.elements))
    return {
        "name": body.name, "chord": bool(body.elements), "particles": list(body.particles), "masses": [value or left for value in mass],
        "centre": outlines.centre_of(assembly, body.name), "driven": body.driven, "row": body.row,
        "turns": not (isinstance(noun, PointMass) and noun.inertia == 0.0), "outline": outlines.drawn(assembly, body),
        "loose": [outlines.pin_of(assembly, f"{body.name}.{pin}") for pin in loose],
    }  # fmt: skip


def joints(assembly: Assembly) -> list[Json]:
    """Joints with their pins and strokes."""
    size, found = extent(assembly), []
    for name, joint in assembly.mechanism.joints.items():
        pins = outlines.pin_of(assembly, joint.bearing), outlines.pin_of(assembly, joint.journal)
        sides = joint.sides[0][0], joint.sides[1][0]
        angles = (_angle(assembly, pins[0]), _angle(assembly, pins[1]))
        at = strokes.Asked(outlines.place(assembly, pins[0]), outlines.place(assembly, pins[1]), angles, size)
        drawn, tilt = strokes.of_joint(joint, at, angles, (sides[0] == "ground", sides[1] == "ground"))
        around, *reaches = joint.drawn
        words = {
            "reaches": [reach or 0.0 for reach in reaches],
            "around": [list(point) for point in around],
            "words": joint.words,
            "bodies": sides,
            "turned": sides[0] != "ground",
        }
        found.append({"name": name, "bearing": pins[0], "journal": pins[1], "strokes": drawn, "tilt": tilt, **words})
    return found


def contacts(assembly: Assembly) -> list[Json]:
    """Contacts: their joint, kind and bodies."""
    topology = assembly.topology
    pairs = zip(topology.contact_kind, topology.contact_bearing, topology.contact_journal, strict=True)
    return [
        {"name": name, "joint": joint, "kind": KINDS[kind], "bearing": bearing, "journal": journal}
        for name, joint, (kind, bearing, journal) in zip(assembly.contacts, assembly.contact_joints, pairs, strict=True)
    ]


def springs(assembly: Assembly) -> list[Json]:
    """Springs and gears: their pins and strokes."""
    size, found = extent(assembly), []
    pairs: list[tuple[Any, tuple[outlines.Pin, outlines.Pin], tuple[str, str]]] = [
        (spring, outlines.ends_of(assembly, spring), ("ground" if spring.between_pins else spring.first, "ground"))
        for spring in assembly.mechanism.springs.values()
    ]
    pairs += [(gear, outlines.axes_of(assembly, gear), (gear.first, gear.second)) for gear in assembly.mechanism.gears.values()]
    for noun, (first, second), sides in pairs:
        one, two = outlines.place(assembly, first), outlines.place(assembly, second)
        turner = 0 if sides[0] == "ground" else assembly.bodies[sides[0]].particles[0]
        drawn = strokes.of_pair(noun, strokes.Asked(one, two, (_angle(assembly, [turner]), 0.0), size))
        wheels = noun.wheels(PairSeen(np.array(one), np.array(two), 0.0, size)) if isinstance(noun, Gear) else ()
        turned = [[0 if side == "ground" else assembly.bodies[side].particles[0], float(r)] for side, (_, r) in zip(sides, wheels, strict=False)]
        found.append(
            {
                "name": noun.name,
                "words": noun.words,
                "wheels": turned,
                "bearing": first,
                "journal": second,
                "turner": turner,
                "bodies": sides,
                "strokes": drawn,
            }
        )
    return found


def loads(assembly: Assembly) -> list[Json]:
    """Forces and moments that are given: where they act on a body that can move, and which particle turns their direction (the ground: none)."""
    found = []
    for load in assembly.mechanism.loads.values():
        for push in load.pushes(assembly.mechanism.joints):
            if push.body == "ground":
                continue
            at = outlines.pin_of(assembly, f"{push.body}.{push.pin}") if push.pin else outlines.centre_of(assembly, push.body)
            turner = push.aligned or (push.body if push.follow else "ground")
            particle = 0 if turner == "ground" else assembly.bodies[turner].particles[0]
            found.append({"name": load.name, "at": at, "acts": list(push.acts), "turner": particle})
    return found


def points(assembly: Assembly) -> list[list[float]]:
    """Points of the ground (m)."""
    return [[float(x), float(y)] for x, y in assembly.mechanism.points.values()]


def _angle(assembly: Assembly, pin: outlines.Pin) -> float:
    return float(assembly.state[assembly.layout.row("particle_theta", int(pin[0]))])


def extent(assembly: Assembly) -> float:
    """About the size of a drawing (m): the largest side of what the mechanism spans at its start."""
    at = [outlines.place(assembly, pin) for body in assembly.bodies.values() for piece in outlines.drawn(assembly, body)["pieces"] for pin in piece]
    for joint in assembly.mechanism.joints.values():
        for end, reach in zip((joint.bearing, joint.journal), joint.drawn[1:], strict=True):
            x, y = outlines.place(assembly, outlines.pin_of(assembly, end))
            at += [(x - reach, y - reach), (x + reach, y + reach)] if reach else []
    spread = np.ptp(np.array([*at, *assembly.mechanism.points.values()], dtype=float).reshape(-1, 2), axis=0)
    return float(spread.max(initial=0.0)) or 1.0
