"""Sections of one long motion: once a turn, and at impacts (place on the bearing, speed and crank angle of
each contact onset).

The motion records one row a turn. Onsets need every step, so a second thread repeats the turns from their
start states and searches the steps for onsets while the motion goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..kernels.topology import LINE, SLOT
from ..numerics.elementwise import atan2, sincos
from .interrupts import Workers, one_behind
from .tangents import ALIGNED, LyapunovRunner, Neighbours
from .turn_runner import TurnRunner

Array = NDArray[np.float64]
COLUMNS = ("contact", "time", "crank", "place", "speed", "count")
PER_CONTACT = ("contact_onsets", "contact_approach", "contact_penetration")
WIDE = len(PER_CONTACT) + 6
TURNS = 50  # of a piece
AT_ONCE = 20_000  # steps that are recorded one by one before they are searched


class ImpactSection(NamedTuple):
    """The search for contact onsets: the contacts, the ``rows`` of S that are recorded for it, and the table
    of onsets, one row each with the columns ``COLUMNS``.

    ``contact``: index among the searched contacts. ``time`` (s) of the onset, interpolated inside its step.
    ``crank``: angle (rad) of the driven body. ``place``: angle (rad) of the journal around the bearing, in
    the bearing's frame; NaN on a line or in a slot. ``speed`` (m/s) of approach, as the step located it.
    ``count``: number of contacts of the same joint that began in this step; ``speed`` is their mean.
    """

    assembly: Assembly
    contacts: Sequence[int]
    rows: NDArray[np.uint32]

    @classmethod
    def of(cls, assembly: Assembly, contacts: Sequence[int]) -> ImpactSection:
        """Return the search for onsets of these contacts."""
        layout, topology = assembly.layout, assembly.topology
        rows = [
            (
                layout.row("particle_theta", topology.driven[0])
                if topology.driven
                else layout.row("particle_theta", 0)
            )
        ]
        for k in contacts:
            bodies = topology.contact_bearing[k], topology.contact_journal[k]
            rows += [layout.row(block, k) for block in PER_CONTACT]
            rows += [layout.row(f"particle_{axis}", body) for body in bodies for axis in ("x", "y", "theta")]
        return cls(assembly, contacts, np.array(rows, dtype=np.uint32))

    def find_onsets(
        self, state: Array, done: int, steps: int, look: Callable[[], None] | None = None
    ) -> Array:
        """Return the onsets in ``steps`` steps from a state, shape (rows,), after ``done`` steps, in the
        order of time, shape (onsets, columns).
        """
        runner = TurnRunner([self.assembly], recorded=self.rows, look=look)
        runner.restore(state, done)
        previous, parts = state[self.rows][None, :], [np.zeros((0, len(COLUMNS)))]
        while steps > 0:
            count = min(steps, AT_ONCE)
            rows = np.concatenate([previous, runner.record(1, count)[:, :, 0]])
            parts += [self._onsets(rows, runner.done - count - 1, k) for k in range(len(self.contacts))]
            previous, steps = rows[-1:], steps - count
        onsets = np.concatenate(parts)
        return onsets[np.argsort(onsets[:, 1], kind="stable")]

    def _onsets(self, rows: Array, first: int, k: int) -> Array:
        """Return the onsets of contact number k in the rows of steps from ``first`` on."""
        contact, values = self.contacts[k], rows[:, 1 + WIDE * k : 1 + WIDE * (k + 1)]
        at = np.flatnonzero(np.diff(values[:, 0]) > 0.0)
        start, end = values[at], values[at + 1]
        low, high = start[:, 2], end[:, 2]
        share = np.where((low < 0.0) & (high > 0.0), -low / np.where(high > low, high - low, 1.0), 0.5)
        crank = rows[at, 0] + share * (rows[at + 1, 0] - rows[at, 0])
        began = end[:, 0] - start[:, 0]
        speed, time = (end[:, 1] - start[:, 1]) / began, (first + at + share) * self.assembly.choice.step
        place = self._place(contact, start[:, 3:] + share[:, None] * (end[:, 3:] - start[:, 3:]))
        return np.column_stack([np.full(len(at), float(k)), time, crank, place, speed, began])

    def _place(self, contact: int, bodies: Array) -> Array:
        """Return the angle (rad) of the journal around the bearing from positions of both bodies, shape
        (onsets, 6).
        """
        layout, state = self.assembly.layout, self.assembly.state
        if self.assembly.topology.contact_kind[contact] in (LINE, SLOT):
            return np.full(len(bodies), np.nan)
        centres = []
        for side, (x, y, angle) in (("bearing", bodies.T[:3]), ("journal", bodies.T[3:])):
            px, py = (float(state[layout.row(f"contact_{side}_{axis}", contact)]) for axis in "xy")
            s, c = sincos(angle)
            centres.append((x + c * px - s * py, y + s * px + c * py))
        (bx, by), (jx, jy) = centres
        angles: Array = np.mod(atan2(jy - by, jx - bx) - bodies[:, 2], 2.0 * np.pi)
        return angles


@dataclass(frozen=True)
class Piece:
    """Some turns: ``rows`` recorded once a turn, shape (turns, rows), the logarithm of the ``growth`` of a
    small difference in each turn, shape (turns,), the onsets ``struck`` (:class:`ImpactSection`), and the
    ``state`` after them, shape (rows,) or (2 rows,).
    """

    number: int
    rows: Array
    growth: Array
    struck: Array
    state: Array


class Turns(NamedTuple):
    """Rows and growth of some turns, and the state after them."""

    rows: Array
    growth: Array
    state: Array


class Sectioning:
    """A motion of ``turns`` turns, the first ``dropped`` not recorded, at a ``phase`` (1) of the turn, and at
    impacts of some ``contacts``.

    A turn and the way to the phase come before these. ``near`` are neighbours whose difference is followed.
    The motion is divided into pieces, after each of which it can be continued.
    """

    def __init__(
        self,
        assembly: Assembly,
        near: Neighbours,
        phase: float,
        turns: int,
        dropped: int,
        contacts: Sequence[int] = (),
    ) -> None:
        self.assembly, self.dropped, self.lead = assembly, dropped, max(0, dropped - ALIGNED)
        spans = ((0, self.lead), (self.lead, dropped), (dropped, turns))
        self.cuts = [(k, min(k + TURNS, last)) for first, last in spans for k in range(first, last, TURNS)]
        self.motion, self.difference = TurnRunner([assembly], phase), LyapunovRunner([assembly], [near])
        self.row_numbers = self.motion.row_numbers
        self.impacts = ImpactSection.of(assembly, contacts) if contacts else None

    def pieces(self, resume: tuple[int, Array] | None = None) -> Iterator[Piece]:
        """Yield the pieces; ``resume`` is number and state of the piece after which to continue."""
        with Workers(1) as workers:
            self.motion.pace.look = self.difference.pace.look = workers.halt.look
            for number, part, onsets in one_behind(self._turns_of_pieces(workers, resume)):
                yield Piece(
                    number,
                    part.rows,
                    part.growth,
                    np.zeros((0, len(COLUMNS))) if onsets is None else onsets.result(),
                    part.state,
                )

    def first_state(self) -> Array:
        """Return the state before the first piece, shape (rows,)."""
        self.motion.begin()
        return self.motion.states[:, 0].copy()

    def turns_of(self, number: int, state: Array) -> Turns:
        """Return the turns of one piece from the state before it, without onsets."""
        first, last = self.cuts[number]
        return self._turns(first, last, state, self.motion.begins + first * self.motion.turn)

    def _turns_of_pieces(
        self, workers: Workers, resume: tuple[int, Array] | None
    ) -> Iterator[tuple[int, Turns, Future[Array] | None]]:
        motion = self.motion
        if resume is None:
            motion.begin()
        number, state = (-1, motion.states[:, 0].copy()) if resume is None else resume
        for first, last in self.cuts[number + 1 :]:
            number, done, onsets = number + 1, motion.begins + first * motion.turn, None
            if self.impacts is not None and first >= self.dropped:
                start = state[: self.assembly.layout.rows].copy()
                onsets = workers.submit(
                    self.impacts.find_onsets, start, done, (last - first) * motion.turn, workers.look
                )
            part = self._turns(first, last, state, done)
            state = part.state
            yield number, part, onsets

    def _turns(self, first: int, last: int, state: Array, done: int) -> Turns:
        """Make the turns from ``first`` to ``last`` from a state; dropped turns have no rows and no
        growth.
        """
        empty = np.zeros((0, len(self.row_numbers))), np.zeros(0)
        if last <= self.lead:
            self.motion.restore(state, done)
            self.motion.skip(last - first)
            return Turns(*empty, self.motion.states[:, 0].copy())
        self.difference.begin([self.assembly], state[:, None], done)
        rows, growth = self.difference.turns([self.assembly], last - first)
        part = (rows[:, :, 0], growth[:, 0]) if first >= self.dropped else empty
        return Turns(*part, self.difference.states[:, 0].copy())
