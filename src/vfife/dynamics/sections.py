"""Poincaré sections of one motion: its series once a turn, the place, time and speed of each contact onset,
and the kind of the motion with the evidence.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..files import write_rows
from ..kinematics.initial import ideal_motion
from ..kinematics.start import Misfit
from ..measures.chaos import Exponent, Verdict, exponent
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..options import with_options
from ..simulation.turn_steps import refuse_large_frame, with_steps
from ..solvers.arguments import Arguments
from ..solvers.impact_section import COLUMNS, Sectioning
from ..solvers.interrupts import ChunkSize
from ..store.studyfile import MapFile
from .maps import MAP_DEFAULTS, Map, MapOptions, MapRows, MapSpec, TurnRun, neighbours_of
from .series import chosen_series, classified, refuse_unknown, series_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Piece = tuple[Array, Array, Array, Array]  # points, growth, onsets and growth with half the step
FINER = 2  # steps of the second motion in one of the section
FIRST_LOOK = 1, 90  # motions, turns


@dataclass(frozen=True)
class SectionSpec(MapSpec):
    """Specification of a section: ``turns``, of which the first ``dropped`` are not recorded; ``series`` with
    their ``units``, recorded once a turn of ``steps`` steps at a ``phase`` (1) of it; and ``contacts`` whose
    onsets are recorded.
    """

    model: str
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    contacts: tuple[str, ...]
    units: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class PoincareSection(Map):
    """A Poincaré section, as far as it is computed.

    ``points`` by series, in SI units, shape (turns,). ``growth``: logarithm of the growth of a small
    difference in each turn, shape (turns,). ``struck`` by contact: a table of its onsets with the columns
    ``time`` (s), ``crank`` (rad, angle of the driven body), ``place`` (rad around the bearing, in its frame;
    NaN in guides and slots), ``speed`` of approach (m/s) and ``count`` (onsets of the same joint in one step,
    which share an entry). ``finer``: growth in each turn of a second motion with half the step, shape
    (turns,); empty in files of former versions.
    """

    file_kind: ClassVar[str] = "section"
    noun: ClassVar[str] = "turns"
    points: Mapping[str, Array]
    growth: Array
    struck: Mapping[str, Mapping[str, Array]]
    finer: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, name: str, spec: SectionSpec, pieces: Iterable[Piece]) -> PoincareSection:
        """Return the section that consists of successive pieces: points, growth, onsets and growth with half
        the step of some turns.
        """
        parts = list(zip(*pieces, strict=True)) or [(), (), (), ()]
        shapes = (len(spec.series),), (), (len(COLUMNS),), ()
        points, growth, onsets, finer = (
            np.concatenate([np.zeros((0, *shape)), *(rows.reshape(-1, *shape) for rows in part)])
            for part, shape in zip(parts, shapes, strict=True)
        )
        struck = {
            contact: dict(zip(COLUMNS[1:], onsets[onsets[:, 0] == k, 1:].T, strict=True))
            for k, contact in enumerate(spec.contacts)
        }
        return cls(name, spec, dict(zip(spec.series, points.T, strict=True)), growth, struck, finer)

    @classmethod
    def read(cls, file: MapFile) -> PoincareSection:
        """Return the section in a map file, as far as it is computed."""
        return cls.of(file.spec["name"], SectionSpec.of(file.spec["asked"]), pieces_of(MapRows(file)))

    @property
    def planned(self) -> int:
        """Number of turns of a complete section."""
        return int(self.spec.turns - self.spec.dropped)

    @property
    def done(self) -> int:
        """Number of turns that are recorded."""
        return len(self.growth)

    @property
    def exponent(self) -> Exponent | None:
        """Largest Lyapunov exponent (1/turn), with its running mean, and a range from the motion with half
        the step; that of a periodic motion whose points scatter is wider.
        """
        return self.verdict.exponent

    @property
    def later_exponent(self) -> Exponent | None:
        """The exponent of the second half of the turns, where that of all is not known and this one is."""
        half = len(self.growth) // 2
        later = self._growth(half) if half and self.exponent is not None and self.exponent.unknown else None
        later = later and later.with_scatter()
        return later if later is not None and later.estimated and not later.unknown else None

    def _growth(self, first: int = 0) -> Exponent | None:
        """Return the exponent of the turns from the ``first`` on, with a range from the motion with half the
        step.
        """
        growth, finer = self.growth[first:], self.finer[first:]
        if len(growth) < 2:
            return None
        largest = exponent(growth)
        if len(finer) < len(growth) or not np.isfinite([*growth, *finer]).all():
            return largest
        return largest.with_finer(exponent(finer))

    @property
    def verdict(self) -> Verdict:
        """Kind of the motion, with the evidence."""
        points = np.stack(list(self.points.values()), axis=1)
        return classified(self.spec, points, self._growth())

    @property
    def kind(self) -> str:
        """Kind of the motion: "period 2", "chaotic", "not settled" (see :attr:`verdict`)."""
        return self.verdict.kind

    @cached_property
    def misfit(self) -> Misfit | None:
        """The given velocity that differs most from that of the run."""
        misfits = ideal_motion(self.mechanism).misfits
        return max(misfits, key=lambda misfit: misfit.size, default=None)

    def plot(self) -> Figure:
        """Return a figure of the points once a turn, the convergence of the exponent, and contact onsets."""
        from ..plots.dynamics import section

        return section(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for every recorded turn."""
        yield ["turn", *self.spec.series, "growth"]
        turns = np.column_stack([*self.points.values(), self.growth]).tolist()
        for turn, row in enumerate(turns, self.spec.dropped + 1):
            yield [turn, *row]

    def write_csv(self, path: str | Path, decimal: str = "point") -> None:
        """Write the table to ``path``, and contact onsets, if any, to NAME.impacts.csv in the same folder."""
        super().write_csv(path, decimal)
        if self.struck:
            write_rows(Path(path).with_suffix(".impacts.csv"), self._onsets())

    def tables(self) -> dict[str, Iterable[Sequence[object]]]:
        """Return the table, and contact onsets, if any, by the titles of their sheets."""
        return super().tables() | ({"impacts": self._onsets()} if self.struck else {})

    def _onsets(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for every contact onset."""
        yield COLUMNS
        for name, onsets in self.struck.items():
            for row in np.column_stack([onsets[column] for column in COLUMNS[1:]]).tolist():
                yield [name, *row]


@with_options(MapOptions, **MAP_DEFAULTS, turns=300)
def poincare_section(
    mechanism: Mechanism, *, joints: Sequence[str] = (), **options: Unpack[MapOptions]
) -> PoincareSection:
    """Compute the Poincaré section of a mechanism's motion: its ``series`` once a turn, and every contact
    onset in ``joints``.

    ``turns`` (300) are simulated, and once more with half the step, for the range of the Lyapunov exponent.
    The first ``dropped`` of them, a third unless given, are not recorded. ``series``, ``phase`` and ``step``
    are as in :func:`~vfife.bifurcation`; the default step is the automatic one of a run of ten turns.

    ``file`` stores what is computed every fifty turns, and the same call continues it to the bit;
    ``progress(done, total)`` is called at the same time. Ctrl-C ends the computation and returns what is
    complete. While the step is searched for, it raises KeyboardInterrupt. ``confirm`` permits work of more
    than an hour. Raises ModelError for a mechanism that has no section, HeldError if another process writes
    the file.
    """
    arguments = Arguments("poincare_section")
    arguments.mechanism(mechanism)
    joints = arguments.names("joints", joints)
    arguments.check()
    run = TurnRun("poincare_section", **options, dropped_share=1 / 3)
    steps = run.step_count([mechanism])
    first = with_steps(mechanism, steps)
    refuse_large_frame(first)
    work = run.work(
        "motion", 1, steps, 1, impacts=bool(joints), first_look=FIRST_LOOK, companions=1,
        companion_steps=float(FINER),
    )  # fmt: skip
    run.begin(work, first)
    series, units = chosen_series(first, run.series)
    contacts = contacts_of(first, joints)
    names = tuple(first.contacts[k] for k in contacts)
    spec = SectionSpec(dump(mechanism), run.turns, run.dropped, series, run.phase, steps, names, units)
    motion = Sectioning(
        first, neighbours_of(mechanism, first, steps), run.phase, run.turns, run.dropped, contacts
    )
    with run.rows(PoincareSection, mechanism.name, spec) as rows:
        rows.done |= dict(enumerate(pieces_of(rows)))
        finer = finer_motion(mechanism, spec, motion.motion.pace, rows)
        for number, (points, growth, struck, _) in rows.done.items():
            rows.done[number] = points, growth, struck, finer.growth(number)
        last = len(rows.done) - 1
        resume = (last, rows.file.state(last)) if rows.file is not None and last >= 0 else None
        for piece in motion.pieces(resume):
            points = series_values(first, motion.row_numbers, piece.rows, series, steps)
            rows.write("arrays", f"struck {piece.number}", piece.struck)
            growth = finer.growth(piece.number)
            rows.write("legs", piece.number, points, piece.growth, piece.state)
            rows.done[piece.number] = points, piece.growth, piece.struck, growth
            run.job.count(motion.cuts[piece.number][1], run.turns, "turns")
    return PoincareSection.of(mechanism.name, spec, rows.done.values())


def contacts_of(first: Assembly, joints: Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of the contacts of ``joints``. Raises ModelError for a joint without clearance."""
    names = list(dict.fromkeys(first.contact_joints))
    message, remedy = "there is no joint with clearance of this name", "name one with clearance"
    refuse_unknown("joints", joints, names, message, remedy, first)
    return tuple(k for k, name in enumerate(first.contact_joints) if name in joints)


class FinerMotion:
    """The growth of a small difference along a second motion, piece by piece, which the file of the map
    keeps.
    """

    def __init__(self, motion: Sectioning, pace: ChunkSize, rows: MapRows) -> None:
        self.motion, self.pace, self.rows = motion, pace, rows
        self.number, self.state = -1, motion.first_state()
        while rows.array(f"finer {self.number + 1}") is not None:
            self.number += 1
        state = rows.array(f"finer state {self.number}")
        if state is None:  # none are kept yet, or the last is damaged
            self.number = -1
        else:
            self.state = state

    def growth(self, number: int) -> Array:
        """Return the logarithm of the growth in the turns of a piece, after those before it."""
        self.motion.motion.pace.look = self.motion.difference.pace.look = self.pace.look
        growth = self.rows.array(f"finer {number}") if number <= self.number else None
        while self.number < number:
            part = self.motion.turns_of(self.number + 1, self.state)
            self.number, self.state, growth = self.number + 1, part.state, part.growth
            self.rows.write("arrays", f"finer state {self.number}", self.state)
            self.rows.write("arrays", f"finer {self.number}", growth)
        return np.zeros(0) if growth is None else growth


def finer_motion(mechanism: Mechanism, spec: SectionSpec, pace: ChunkSize, rows: MapRows) -> FinerMotion:
    """Return the motion of a section with half its step; ``pace`` looks for Ctrl-C."""
    steps = FINER * spec.steps
    first = with_steps(mechanism, steps)
    near = neighbours_of(mechanism, first, steps)
    return FinerMotion(Sectioning(first, near, spec.phase, spec.turns, spec.dropped), pace, rows)


def pieces_of(rows: MapRows) -> list[Piece]:
    """Return the pieces in a map file up to the first that is missing."""
    pieces: list[Piece] = []
    for number, (points, growth) in rows.legs(gaps=False).items():
        struck = rows.array(f"struck {number}")
        if struck is None:
            break
        finer = rows.array(f"finer {number}")
        pieces.append((points, growth, struck, np.zeros(0) if finer is None else finer))
    return pieces
