"""The impacts of a run, one by one as far as its outputs tell them apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..solvers.record import Record
from .losses import lost
from .motion import times


@dataclass(frozen=True)
class Impact:
    """A contact that began in a joint with play, or ``count`` of them where several began between two outputs.

    It came after ``since`` (s) and up to ``time`` (s), the output that shows it, where the crank stands at ``crank`` (degrees, None without one).
    ``speed`` (m/s) is that of approach along the normal, located inside the step; of several their mean. ``energy`` (J) is what normal damping took
    and ``depth`` (m) the deepest penetration, both from there to the next entry of the joint.
    """

    joint: str
    since: float
    time: float
    crank: float | None
    count: int
    speed: float | None
    energy: float
    depth: float


@dataclass(frozen=True)
class Impacts:
    """All of them in the order of time, and how many the outputs tell apart: ``alone`` of ``count``. ``before`` (J): lost before any began."""

    entries: tuple[Impact, ...]
    before: float

    @property
    def count(self) -> int:
        """Contacts that began."""
        return sum(one.count for one in self.entries)

    @property
    def alone(self) -> int:
        """Those that have an entry of their own."""
        return sum(one.count == 1 for one in self.entries)

    def hardest(self, most: int) -> tuple[Impact, ...]:
        """The entries that lost most energy, the hardest first."""
        return tuple(sorted(self.entries, key=lambda one: -one.energy)[:most])


def impacts(record: Record) -> Impacts:
    """The contacts that began in a run, by the counts, sums of speeds and works that the step keeps at every onset.

    None is missed, however short: those that began between the same two outputs share an entry that says how many they are. More outputs tell
    more of them apart. Energies over all entries, with what was lost before the first, are the ledger's loss in contacts. Records of an older
    version have no speeds.
    """
    assembly = record.assembly
    if not assembly.contacts or not record.keeps("contact_onsets"):
        return Impacts((), 0.0)
    time, crank = times(record), crank_angle(record)
    onsets, work = record.block("contact_onsets"), lost(record, "impact")
    speeds = record.block("contact_approach") if record.keeps("contact_approach") else None
    depths = record.block("contact_penetration_max")
    found: list[Impact] = []
    before = 0.0
    for k, name in enumerate(assembly.contacts):
        began = np.diff(onsets[:, k], prepend=0.0)
        at = np.flatnonzero(began > 0.0)
        before += float(work[at[0] - 1, k]) if len(at) and at[0] > 0 else 0.0 if len(at) else float(work[-1, k])
        for row, following in zip(at.tolist(), [*at.tolist(), len(time)][1:], strict=True):  # none, where a contact never began
            spent = work[following - 1, k] - (work[row - 1, k] if row else 0.0)
            mean = None if speeds is None else float((speeds[row, k] - (speeds[row - 1, k] if row else 0.0)) / began[row])
            angle = None if crank is None else float(crank[row])
            depth = max(float(depths[row:following, k].max()), 0.0)
            found.append(Impact(name, float(time[max(row - 1, 0)]), float(time[row]), angle, int(began[row]), mean, float(spent), depth))
    return Impacts(tuple(sorted(found, key=lambda one: (one.time, one.joint))), before)


def crank_angle(record: Record) -> np.ndarray | None:
    """Angle of the first driven body (degrees, not reduced to one turn), or None without one."""
    driven = record.assembly.topology.driven
    return np.degrees(record.block("particle_theta")[:, driven[0]]) if driven else None
