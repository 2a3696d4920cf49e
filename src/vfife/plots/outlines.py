"""Bodies as lines: what of each is drawn, at all outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..analysis.motion import pin_path
from ..model.outlines import CENTER, FEW, corners, drawn_pins

if TYPE_CHECKING:
    from ..results.view import View

Array = NDArray[np.float64]


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
    pins = drawn_pins(record.assembly.mechanism, name)
    order, plate = corners(np.array([body.pins[pin] for pin in pins], dtype=float))
    pins = [pins[k] for k in order]
    return Outline(np.stack([pin_path(record, name, pin) for pin in pins or [CENTER]], axis=1), plate)


def _particles(result: View, nodes: list[int]) -> Array:
    return np.stack([result.record.block(f"particle_{axis}")[:, nodes] for axis in "xy"], axis=2)


def _members(result: View, elements: list[int]) -> Array:
    pairs = np.array([result.record.assembly.topology.frame_nodes[e][:2] for e in elements])
    ends = [_particles(result, list(pairs[:, k])) for k in (0, 1)]
    gaps = np.full_like(ends[0], np.nan)
    return np.asarray(np.stack([*ends, gaps], axis=2).reshape(len(gaps), -1, 2), dtype=float)
