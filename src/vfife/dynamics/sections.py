"""Poincaré sections of one motion: what it is once a turn, and where, when and how fast contacts begin; what
it is in a word, and why.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..files import write_rows
from ..job.job import job_of
from ..measures.chaos import Exponent, Verdict, exponent, verdict
from ..model.above import NotebookDocument
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..solvers.impact_section import COLUMNS, Sectioning
from ..store.mapfile import MapFile
from .section_series import (
    MapWork,
    chosen_series,
    kept_in,
    law_words,
    left_out,
    looked,
    refuse_idle,
    refuse_large_frame,
    refuse_unknown,
    seed,
    step_count,
    stepped,
    tupled,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
FIRST_LOOK = 1, 90  # motions, turns
WHAT, DROPPED = "section", 1 / 3


@dataclass(frozen=True)
class SectionSpec:
    """What is asked of a section: ``turns``, the first of them ``dropped``; ``series`` once a turn at a
    ``phase`` (1), ``steps`` in a turn, and ``contacts`` whose onsets are looked at. ``units`` are those of
    the series.
    """

    model: str
    turns: int
    dropped: int
    series: tuple[str, ...]
    phase: float
    steps: int
    contacts: tuple[str, ...]
    units: tuple[str, ...]


@dataclass(frozen=True)
class PoincareSection(NotebookDocument):
    """A section, as far as it is ``done``, so many turns of those that are looked at.

    ``points``: of each series in SI units, shape (turns,). ``growth``: logarithm of the growth of a small
    difference in each turn. ``struck``: of each contact a table of its onsets, columns ``time`` (s),
    ``crank`` (rad, angle of the driven body), ``place`` (rad round the bearing, in its frame; NaN in guides
    and slots), ``speed`` of approach (m/s) and ``count`` (of those in one step, which share an entry).
    """

    name: str
    asked: SectionSpec
    points: Mapping[str, Array]
    growth: Array
    struck: Mapping[str, Mapping[str, Array]]

    @property
    def done(self) -> int:
        """Turns that are looked at."""
        return len(self.growth)

    @property
    def exponent(self) -> Exponent | None:
        """Largest Lyapunov exponent (1/turn), with its running mean."""
        return exponent(self.growth) if len(self.growth) > 1 else None

    @property
    def verdict(self) -> Verdict:
        """What the motion is, and what says so."""
        return verdict(np.stack(list(self.points.values()), axis=1), self.exponent)

    @property
    def laws(self) -> str:
        """Contact and friction laws that it was run with, in words."""
        return law_words(loads(self.asked.model))

    def plot(self) -> Figure:
        """A figure: points once a turn, the exponent as it converges, and the contacts that began."""
        from ..plots.maps import section as drawn

        return drawn(self)

    def write_csv(self, path: str | Path) -> None:
        """Writes a row for every turn that was looked at, and beside it, where contacts were,
        ``NAME.impacts.csv`` with a row for every onset.
        """
        every = np.column_stack([*self.points.values(), self.growth]).tolist()
        write_rows(
            path,
            [
                ["turn", *self.asked.series, "growth"],
                *([self.asked.dropped + turn, *row] for turn, row in enumerate(every, 1)),
            ],
        )
        if self.struck:
            onsets = {
                name: np.column_stack([one[column] for column in COLUMNS[1:]]).tolist()
                for name, one in self.struck.items()
            }
            write_rows(
                Path(path).with_suffix(".impacts.csv"),
                [COLUMNS, *([name, *row] for name, rows in onsets.items() for row in rows)],
            )


def poincare_section(
    mechanism: Mechanism,
    *,
    turns: int = 300,
    dropped: int | None = None,
    series: Sequence[str] = (),
    phase: float = 0.0,
    joints: Sequence[str] = (),
    step: float | None = None,
    file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    confirm: bool = False,
) -> PoincareSection:
    """The Poincaré section of a mechanism's motion: ``turns`` turns, of which ``dropped`` are not looked at,
    a third unless said.

    ``series``: what is looked at once a turn, at a ``phase`` (1) of it, by its name in ``result.series``; the
    penetration and the largest force of a contact, or a place or speed, that vary, unless said. ``joints``
    with play: of these every contact that begins. ``step`` (s): the one that a run of ten turns finds unless
    said, a whole number of them in a turn. With a ``file`` what is known is kept in it every fifty turns, and
    the same call goes on there, to the bit. Ctrl-C leaves what is complete. ``confirm``: make it even where
    it takes more than an hour. Raises ModelError for what cannot be looked at so, HeldError where another
    process writes the file.
    """
    dropped = left_out(dropped, turns, DROPPED)
    refuse_idle(mechanism, turns, dropped)
    steps = step_count([mechanism], step, search=True)
    first = stepped(mechanism, steps)
    refuse_large_frame(first)
    job = job_of("poincare_section", file, confirm, progress, lambda one: progress(one.done, one.steps))  # type: ignore[misc]
    work = MapWork(
        "motion",
        1,
        turns,
        dropped,
        steps,
        1,
        len(series or (1, 1)) + 1,
        struck=bool(joints),
        first_look=FIRST_LOOK,
    )
    job.begin(work.forecast(first, file))
    chosen, units = chosen_series(first, series)
    contacts = struck_contacts(first, joints)
    asked = SectionSpec(
        dump(mechanism),
        turns,
        dropped,
        chosen,
        phase,
        steps,
        tuple(first.contacts[k] for k in contacts),
        units,
    )
    motion = Sectioning(first, seed(mechanism, first, steps), phase, turns, dropped, contacts)
    with job, kept_in(file, {"what": WHAT, "name": mechanism.name, "asked": asked}) as kept:
        found = [] if kept is None else sectioned(kept)
        resume = None if kept is None or not found else (len(found) - 1, kept.state(len(found) - 1))
        try:
            for piece in motion.pieces(resume):
                points = looked(first, motion.kept, piece.rows, chosen, steps)
                if kept is not None:
                    kept.write_row("arrays", f"struck {piece.number}", piece.struck)
                    kept.write_row("legs", piece.number, points, piece.growth, piece.state)
                found.append((points, piece.growth, piece.struck))
                job.count(motion.cuts[piece.number][1], turns, "turns")
        except KeyboardInterrupt:
            if not any(len(points) for points, _, _ in found):
                raise
    return together(mechanism.name, asked, found)


def struck_contacts(first: Assembly, joints: Sequence[str]) -> tuple[int, ...]:
    """Numbers of the contacts of joints. Raises ModelError for a joint without play."""
    known = list(dict.fromkeys(first.contact_joints))
    refuse_unknown(
        "joints",
        joints,
        known,
        "there is no joint with play of this name",
        "name one with clearance",
        first.mechanism.name,
    )
    return tuple(k for k, name in enumerate(first.contact_joints) if name in joints)


def sectioned(kept: MapFile) -> list[tuple[Array, Array, Array]]:
    """Points, growth and onsets of the pieces that a file has."""
    found = []
    for number, (points, growth) in kept.legs(gaps=False).items():
        struck = kept.array(f"struck {number}")
        if struck is None:
            break
        found.append((points, growth, struck))
    return found


def together(name: str, asked: SectionSpec, pieces: Sequence[tuple[Array, Array, Array]]) -> PoincareSection:
    """The section of pieces."""
    points = np.concatenate(
        [np.zeros((0, len(asked.series))), *(one.reshape(-1, len(asked.series)) for one, _, _ in pieces)]
    )
    growth = np.concatenate([np.zeros(0), *(one.reshape(-1) for _, one, _ in pieces)])
    struck = np.concatenate(
        [np.zeros((0, len(COLUMNS))), *(one.reshape(-1, len(COLUMNS)) for _, _, one in pieces)]
    )
    tables = {
        contact: dict(zip(COLUMNS[1:], struck[struck[:, 0] == k, 1:].T, strict=True))
        for k, contact in enumerate(asked.contacts)
    }
    return PoincareSection(name, asked, dict(zip(asked.series, points.T, strict=True)), growth, tables)


def read_section(kept: MapFile) -> PoincareSection:
    """The section in a map file, as far as it is known."""
    said = kept.spec
    return together(said["name"], SectionSpec(**tupled(said["asked"])), sectioned(kept))
