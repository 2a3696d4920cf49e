"""Where round a bearing, and round its journal, a joint with play touches: time in contact, impulse and friction over the angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numerics.elementwise import atan2, sincos
from ..solvers.record import Record
from .losses import lost
from .sliding import contact_time, places

Array = NDArray[np.float64]
SIDES = ("bearing", "journal")


def contact_angle(record: Record, side: str = "bearing") -> Array:
    """Angle (rad, from -pi to pi) of the place of contact seen from the pin of a ``side``, in the frame of that side's body, (outputs, contacts).

    It counts from the x axis of the body, of a link from start to end; of the ground it is the global one. Apart, the place nearest to contact.
    """
    assembly = record.assembly
    if not assembly.contacts:
        return np.zeros((len(record.steps), 0))
    place = places(record)[SIDES.index(side)]
    turned = record.block("particle_theta")[:, list(getattr(assembly.topology, f"contact_{side}"))]
    x, y = place[..., 0], place[..., 1]
    s, c = sincos(turned)
    return np.asarray(atan2(c * y - s * x, c * x + s * y), dtype=float)


@dataclass(frozen=True)
class Around:
    """What a joint's surface bears over its angle, in the frame of its body: ``edges`` (rad, bins + 1), and per contact and bin, (contacts, bins),
    ``time`` in contact (s), ``impulse`` of the normal force (N s) and ``friction`` energy (J).
    """

    side: str
    names: tuple[str, ...]
    edges: Array
    time: Array
    impulse: Array
    friction: Array

    @property
    def middles(self) -> Array:
        """Middle of each bin (rad), shape (bins,)."""
        return np.asarray(0.5 * (self.edges[1:] + self.edges[:-1]), dtype=float)


def around(record: Record, side: str = "bearing", bins: int = 72, window: NDArray[np.bool_] | None = None) -> Around:
    """The surface of a ``side`` ("bearing" or "journal") over its angle, in all or over a window of intervals.

    Time in contact and friction energy are counted step by step in the run and laid at the angle of the output that ends their interval, so that
    over all bins they are those of the run; the impulse is the normal force at the outputs times that time. Raises ValueError for another side.
    """
    if side not in SIDES:
        raise ValueError(f'side = "{side}"; allowed: "bearing" or "journal"')
    edges = np.linspace(-np.pi, np.pi, bins + 1)
    angle, touching = contact_angle(record, side), contact_time(record)
    rubbed = np.diff(lost(record, "friction"), axis=0, prepend=0.0) if record.assembly.contacts else touching
    every = (touching, touching * record.block("contact_normal_force"), rubbed)
    inside = np.ones(len(record.steps), dtype=bool) if window is None else window
    found = np.zeros((3, len(record.assembly.contacts), bins))
    for k in range(len(record.assembly.contacts)):
        for row, values in zip(found, every, strict=True):
            row[k] = np.bincount(bin_of(angle[inside, k], edges), values[inside, k], bins)
    return Around(side, tuple(record.assembly.contacts), edges, *found)


def bin_of(angle: Array, edges: Array) -> NDArray[np.intp]:
    """Which bin an angle (rad) lies in; the last one has both its edges. A histogram of NumPy adds weights of one angle in an order of its own."""
    return np.asarray(np.clip(np.searchsorted(edges, angle, side="right") - 1, 0, len(edges) - 2), dtype=np.intp)
