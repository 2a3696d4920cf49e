"""Sections at impacts: where on its bearing, how fast and at which crank angle each contact begins, step by step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..kernels.topology import LINE, SLOT
from ..numerics.elementwise import atan2, sincos
from .interrupts import Pace
from .lyapunov import plain_runner

Array = NDArray[np.float64]
COLUMNS = ("contact", "time", "crank", "place", "speed", "count")
PER_CONTACT = ("contact_onsets", "contact_approach", "contact_penetration")
WIDE = len(PER_CONTACT) + 6
AT_ONCE = 20_000  # steps that are recorded one by one before they are looked through


class Strikes(NamedTuple):
    """Rows of S that tell onsets of some contacts, and what they tell: one row for each contact that began, in the order of ``COLUMNS``.

    ``contact``: which of those that are looked at; ``time`` (s) of the onset, interpolated inside its step; ``crank``: the angle (rad) of the
    driven body then; ``place``: the angle (rad) round the bearing, in its frame, at which the journal is, NaN on a line or in a slot; ``speed``
    (m/s): that of approach, as the step located it; ``count``: contacts of the same joint that began in this step, whose mean speed is told.
    """

    assembly: Assembly
    contacts: Sequence[int]
    rows: NDArray[np.uint32]

    @classmethod
    def of(cls, assembly: Assembly, contacts: Sequence[int]) -> Strikes:
        """Of such contacts."""
        layout, topology = assembly.layout, assembly.topology
        rows = [layout.row("particle_theta", topology.driven[0]) if topology.driven else layout.row("particle_theta", 0)]
        for k in contacts:
            bodies = topology.contact_bearing[k], topology.contact_journal[k]
            rows += [layout.row(block, k) for block in PER_CONTACT]
            rows += [layout.row(f"particle_{axis}", body) for body in bodies for axis in ("x", "y", "theta")]
        return cls(assembly, contacts, np.array(rows, dtype=np.uint32))

    def over(self, state: Array, done: int, steps: int, look: Callable[[], None] | None = None) -> Array:
        """The onsets in so many steps after the first ``done``, from a state, shape (rows,): shape (onsets, columns)."""
        runner, pace = plain_runner([self.assembly], self.rows), Pace(look)
        runner.states[:, 0], runner.done = state, done
        before, found = state[self.rows][None, :], [np.zeros((0, len(COLUMNS)))]
        while steps > 0:
            some = min(steps, AT_ONCE)
            rows = np.concatenate([before, pace.advance(runner, 1, some)[:, :, 0]])
            found += [self._onsets(rows, runner.done - some - 1, k) for k in range(len(self.contacts))]
            before, steps = rows[-1:], steps - some
        every = np.concatenate(found)
        return every[np.argsort(every[:, 1], kind="stable")]

    def _onsets(self, rows: Array, first: int, k: int) -> Array:
        """Those of one contact in rows of steps from the ``first`` on."""
        contact, own = self.contacts[k], rows[:, 1 + WIDE * k : 1 + WIDE * (k + 1)]
        at = np.flatnonzero(np.diff(own[:, 0]) > 0.0)
        before, after = own[at], own[at + 1]
        low, high = before[:, 2], after[:, 2]
        share = np.where((low < 0.0) & (high > 0.0), -low / np.where(high > low, high - low, 1.0), 0.5)
        crank = rows[at, 0] + share * (rows[at + 1, 0] - rows[at, 0])
        began = after[:, 0] - before[:, 0]
        speed, time = (after[:, 1] - before[:, 1]) / began, (first + at + share) * self.assembly.choice.step
        place = self._place(contact, before[:, 3:] + share[:, None] * (after[:, 3:] - before[:, 3:]))
        return np.column_stack([np.full(len(at), float(k)), time, crank, place, speed, began])

    def _place(self, contact: int, bodies: Array) -> Array:
        """Angle of the journal round the bearing, from positions of both bodies, shape (onsets, 6)."""
        layout, state = self.assembly.layout, self.assembly.state
        if self.assembly.topology.contact_kind[contact] in (LINE, SLOT):
            return np.full(len(bodies), np.nan)
        centres = []
        for side, (x, y, angle) in (("bearing", bodies.T[:3]), ("journal", bodies.T[3:])):
            px, py = (float(state[layout.row(f"contact_{side}_{axis}", contact)]) for axis in "xy")
            s, c = sincos(angle)
            centres.append((x + c * px - s * py, y + s * px + c * py))
        (bx, by), (jx, jy) = centres
        found: Array = np.mod(atan2(jy - by, jx - bx) - bodies[:, 2], 2.0 * np.pi)
        return found
