"""Bodies as lines: what of each is drawn, at all outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..analysis.motion import pin_path
from ..model.bodies import Link

if TYPE_CHECKING:
    from ..results.view import View

Array = NDArray[np.float64]
FEW = 30  # nodes of an elastic link that are still shown as dots
CENTER = "center"


@dataclass(frozen=True)
class Outline:
    """``path`` (m), shape (outputs, corners, 2), with NaN between pieces that do not hang together; ``plate`` if it encloses an area."""

    path: Array
    plate: bool = False
    dots: bool = False


def outline(result: View, name: str) -> Outline:
    """Nodes of an elastic link, members of a frame, or the pins of a rigid body that lie on its hull."""
    record = result.record
    body = record.assembly.bodies[name]
    if body.model == "frame":
        return Outline(_members(result, list(body.elements)))
    if body.elements:
        return Outline(_particles(result, list(body.particles)), dots=len(body.particles) <= FEW)
    pins = drawn_pins(result, name)
    at = np.array([body.pins[pin] for pin in pins] or [(0.0, 0.0)])
    plate = len(pins) > 2 and not _collinear(at)
    if plate:
        corners = _hull(at)
        pins = [pins[k] for k in (*corners, corners[0])]
    elif len(pins) > 2:
        pins = [pins[k] for k in np.argsort(at @ (at[np.argmax(np.linalg.norm(at - at[0], axis=1))] - at[0]))]
    return Outline(np.stack([pin_path(record, name, pin) for pin in pins or [CENTER]], axis=1), plate)


def drawn_pins(result: View, name: str) -> list[str]:
    """Pins of a rigid body that are drawn: its own, and those that something is fixed to; the centre of mass where there is but one pin."""
    mechanism = result.record.assembly.mechanism
    noun = mechanism.bodies[name]
    own = ["start", "end"] if isinstance(noun, Link) else [pin for pin in noun.points if pin != CENTER]
    pins = list(dict.fromkeys([*own, *(pin for pin in noun.points if pin in attached(result, name))]))
    if len(pins) == 1 and np.any(noun.points[pins[0]]) and CENTER in noun.points and pins != [CENTER]:
        pins.append(CENTER)
    return pins


def attached(result: View, name: str) -> set[str]:
    """Pins of a body that a joint, spring or bushing takes hold of."""
    mechanism = result.record.assembly.mechanism
    ends = [end for joint in mechanism.joints.values() for end in (joint.bearing, joint.journal)]
    ends += [end for spring in mechanism.springs.values() for end in (spring.first, spring.second)]
    return {pin for body, _, pin in (end.partition(".") for end in ends) if body == name}


def loose_pins(result: View, name: str) -> list[str]:
    """Pins of a body that nothing takes hold of: feet, pens and ends, whose paths are worth seeing."""
    noun = result.record.assembly.mechanism.bodies[name]
    own = noun.points if not result.record.assembly.bodies[name].elements else [pin for pin in ("start", "end") if pin in noun.points]
    held = attached(result, name)
    return [pin for pin in own if pin != CENTER and pin not in held]


def _particles(result: View, nodes: list[int]) -> Array:
    return np.stack([result.record.block(f"particle_{axis}")[:, nodes] for axis in "xy"], axis=2)


def _members(result: View, elements: list[int]) -> Array:
    pairs = np.array([result.record.assembly.topology.frame_nodes[e][:2] for e in elements])
    ends = [_particles(result, list(pairs[:, k])) for k in (0, 1)]
    gaps = np.full_like(ends[0], np.nan)
    return np.asarray(np.stack([*ends, gaps], axis=2).reshape(len(gaps), -1, 2), dtype=float)


def _hull(points: Array) -> list[int]:
    """Corners of the convex hull, anticlockwise, by Andrew's chain."""
    order = sorted(range(len(points)), key=lambda k: (float(points[k, 0]), float(points[k, 1])))

    def half(indices: list[int]) -> list[int]:
        chain: list[int] = []
        for k in indices:
            while len(chain) > 1 and _turn(points[chain[-2]], points[chain[-1]], points[k]) <= 0.0:
                chain.pop()
            chain.append(k)
        return chain[:-1]

    return half(order) + half(order[::-1])


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _collinear(points: Array) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[-1] < 1e-9 * spread[0])
