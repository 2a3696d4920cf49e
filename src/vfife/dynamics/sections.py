"""Poincaré sections of one motion: its series once a turn, and where, when and how fast contacts begin; its
kind, with the evidence.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Unpack

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..files import write_rows
from ..measures.chaos import Exponent, Verdict, exponent, verdict
from ..model.mechanism import Mechanism
from ..modelfile import dump
from ..options import with_options
from ..simulation.turn_steps import refuse_large_frame, with_steps
from ..solvers.impact_section import COLUMNS, Sectioning
from ..store.mapfile import MapFile
from .maps import (
    MAP_DEFAULTS,
    Map,
    MapOptions,
    MapRows,
    MapSpec,
    TurnRun,
    chosen_series,
    neighbours_of,
    refuse_unknown,
    series_values,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Piece = tuple[Array, Array, Array]  # points, growth and onsets of some turns
FIRST_LOOK = 1, 90  # motions, turns


@dataclass(frozen=True)
class SectionSpec(MapSpec):
    """A section of ``turns``, the first of them ``dropped``: ``series`` with their ``units`` once a turn of
    so many ``steps``, at a ``phase`` (1) of it, and onsets of ``contacts``.
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
    """A Poincaré section, as far as it is known.

    ``points``: of each series in SI units, shape (turns,). ``growth``: logarithm of the growth of a small
    difference in each turn. ``struck``: of each contact a table of its onsets with the columns ``time`` (s),
    ``crank`` (rad, angle of the driven body), ``place`` (rad round the bearing, in its frame; NaN in guides
    and slots), ``speed`` of approach (m/s) and ``count`` (of those in one step, which share an entry).
    """

    kind: ClassVar[str] = "section"
    points: Mapping[str, Array]
    growth: Array
    struck: Mapping[str, Mapping[str, Array]]

    @classmethod
    def of(cls, name: str, spec: SectionSpec, pieces: Iterable[Piece]) -> PoincareSection:
        """The section of successive pieces."""
        shapes = (-1, len(spec.series)), (-1,), (-1, len(COLUMNS))
        parts: list[list[Array]] = [
            [np.zeros(shape)] for shape in ((0, len(spec.series)), (0,), (0, len(COLUMNS)))
        ]
        for piece in pieces:
            for part, one, shape in zip(parts, piece, shapes, strict=True):
                part.append(one.reshape(shape))
        points, growth, onsets = (np.concatenate(part) for part in parts)
        struck = {
            contact: dict(zip(COLUMNS[1:], onsets[onsets[:, 0] == k, 1:].T, strict=True))
            for k, contact in enumerate(spec.contacts)
        }
        return cls(name, spec, dict(zip(spec.series, points.T, strict=True)), growth, struck)

    @classmethod
    def read(cls, file: MapFile) -> PoincareSection:
        """The section in a map file, as far as it is known."""
        return cls.of(file.spec["name"], SectionSpec.of(file.spec["asked"]), pieces_of(MapRows(file)))

    @property
    def done(self) -> int:
        """Turns that were looked at."""
        return len(self.growth)

    @property
    def exponent(self) -> Exponent | None:
        """Largest Lyapunov exponent (1/turn), with its running mean."""
        return exponent(self.growth) if len(self.growth) > 1 else None

    @property
    def verdict(self) -> Verdict:
        """Kind of the motion, with the evidence."""
        return verdict(np.stack(list(self.points.values()), axis=1), self.exponent)

    def plot(self) -> Figure:
        """A figure of the points once a turn, the exponent as it converges, and the contacts that began."""
        from ..plots.dynamics import section

        return section(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a row for every turn that was looked at."""
        yield ["turn", *self.spec.series, "growth"]
        turns = np.column_stack([*self.points.values(), self.growth]).tolist()
        for turn, row in enumerate(turns, self.spec.dropped + 1):
            yield [turn, *row]

    def write_csv(self, path: str | Path) -> None:
        """Write the table, and the onsets of contact into NAME.impacts.csv beside it, if there are any."""
        super().write_csv(path)
        if self.struck:
            onsets = {
                name: np.column_stack([one[column] for column in COLUMNS[1:]]).tolist()
                for name, one in self.struck.items()
            }
            write_rows(
                Path(path).with_suffix(".impacts.csv"),
                [COLUMNS, *([name, *row] for name, table in onsets.items() for row in table)],
            )


@with_options(MapOptions, **MAP_DEFAULTS, turns=300)
def poincare_section(
    mechanism: Mechanism, *, joints: Sequence[str] = (), **options: Unpack[MapOptions]
) -> PoincareSection:
    """Compute the Poincaré section of a mechanism's motion: its ``series`` once a turn, and every contact
    that begins in ``joints``.

    ``turns`` (300) are simulated, of which the first ``dropped``, a third unless given, are not looked at.
    ``series``, ``phase`` and ``step`` are as in :func:`~vfife.bifurcation`; the step is that which a run of
    ten turns finds, unless given. A ``file`` keeps what is computed every fifty turns, and the same call
    continues it, to the bit. ``progress(done, total)`` is called then. Ctrl-C leaves what is complete.
    ``confirm``: compute even what takes more than an hour. Raises ModelError for a mechanism that cannot be
    looked at so, HeldError where another process writes the file.
    """
    run = TurnRun("poincare_section", **options, dropped_share=1 / 3)
    steps = run.step_count([mechanism])
    first = with_steps(mechanism, steps)
    refuse_large_frame(first)
    run.begin(run.work("motion", 1, steps, 1, impacts=bool(joints), first_look=FIRST_LOOK), first)
    series, units = chosen_series(first, run.series)
    contacts = contacts_of(first, joints)
    names = tuple(first.contacts[k] for k in contacts)
    spec = SectionSpec(dump(mechanism), run.turns, run.dropped, series, run.phase, steps, names, units)
    motion = Sectioning(
        first, neighbours_of(mechanism, first, steps), run.phase, run.turns, run.dropped, contacts
    )
    with run.rows(PoincareSection, mechanism.name, spec) as rows:
        rows.done |= dict(enumerate(pieces_of(rows)))
        last = len(rows.done) - 1
        resume = (last, rows.file.state(last)) if rows.file is not None and last >= 0 else None
        for piece in motion.pieces(resume):
            points = series_values(first, motion.row_numbers, piece.rows, series, steps)
            rows.write("arrays", f"struck {piece.number}", piece.struck)
            rows.write("legs", piece.number, points, piece.growth, piece.state)
            rows.done[piece.number] = points, piece.growth, piece.struck
            run.job.count(motion.cuts[piece.number][1], run.turns, "turns")
    return PoincareSection.of(mechanism.name, spec, rows.done.values())


def contacts_of(first: Assembly, joints: Sequence[str]) -> tuple[int, ...]:
    """Numbers of the contacts of joints. Raises ModelError for a joint without clearance."""
    names = list(dict.fromkeys(first.contact_joints))
    refuse_unknown(
        "joints", joints, names, "there is no joint with play of this name", "name one with clearance", first
    )
    return tuple(k for k, name in enumerate(first.contact_joints) if name in joints)


def pieces_of(rows: MapRows) -> list[Piece]:
    """The pieces in a map file, up to the first that is missing."""
    pieces = []
    for number, (points, growth) in rows.legs(gaps=False).items():
        struck = rows.array(f"struck {number}")
        if struck is None:
            break
        pieces.append((points, growth, struck))
    return pieces
