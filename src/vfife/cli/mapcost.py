"""What maps, sections, basins and waterfalls will cost before they are begun: time from the cost of a step, bytes from what is kept."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .terminal import STORAGE, amount_of_bytes, counted, fail, sentences, span, tell

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

# Time of a step of so many lanes, and of one that carries a difference along, in that of a step of one lane.
LANES = {1: (1.0, 3.2), 2: (1.1, 3.3), 4: (1.1, 3.7)}
STRUCK = 1.8  # of a step that is looked at for onsets
PACKED, BESIDE = 0.8, 2.8  # of the bytes of numbers; steps of both companions, in those of their member
MADE, TURNED = 0.02, 0.06  # s that it takes to assemble a start and to look at what became of it; and where the crank is turned to it first
SHARED = 0.75  # of the lanes' speed that a stream of members has
PATIENCE = 60.0  # s beyond which a first look is named
ALIGNED = 10  # turns in which a difference is turned before it counts


@dataclass(frozen=True)
class Brief:
    """A first look at the same: fewer members of fewer turns, and the ``words`` that ask for it."""

    members: int
    turns: int
    words: str

    def of(self, work: Work) -> Work:
        """The work that it is."""
        left = work.dropped * self.turns // work.turns
        return replace(work, members=min(work.members, self.members), turns=self.turns, dropped=left, brief=None)


@dataclass(frozen=True)
class Work:
    """What is to be done: so many ``members``, each of ``turns``, ``dropped`` of them, of so many ``steps`` (0: there is no turn to count, which is
    told when it is begun), in so many ``lanes`` at once, a difference being watched or not (``grown``); of ``companions`` members again, and with
    onsets looked for (``struck``). ``kept``: numbers of a turn that is looked at. ``made``: time (s) to
    assemble one. ``brief``: what takes less time."""

    members: int
    noun: str
    turns: int
    dropped: int
    steps: float
    lanes: int
    kept: float
    companions: int = 0
    grown: bool = True
    struck: bool = False
    made: float = MADE
    brief: Brief | None = None

    def steps_of_one(self, cores: int) -> float:
        """Turns of one lane that a member takes as long as, with all cores at work."""
        if self.lanes not in LANES:  # a stream of members, as in a study
            return self.turns / (cores * max(1.0, SHARED * self.lanes))
        plain, derived = LANES[self.lanes]
        before = max(0, self.dropped - ALIGNED) if self.grown else self.turns
        first, second = plain * before, derived * (self.turns - before)
        if self.lanes == 2:  # a second thread carries the differences of two members at once, while the motion goes on
            second = LANES[4][1] / 2 * (self.turns - before)
            return max(plain * self.turns, second) if cores > 1 else plain * self.turns + second
        if self.lanes == 1:
            return first + max(second, STRUCK * (self.turns - self.dropped) * self.struck)
        return (first + second) / (self.lanes * cores)


def forecast(work: Work, mechanism: Mechanism, place: Path) -> dict[str, Any]:
    """Members that are left, steps of each, seconds, bytes; estimates, and called so."""
    from ..assembly.assemble import assemble
    from ..results.cost import estimate
    from ..results.tables import free_bytes

    cores = os.cpu_count() or 1
    found = estimate(assemble(mechanism, turns=1.0))
    step = 1e-9 * found["ns_per_step"]
    each = step * work.steps * work.steps_of_one(cores) + work.made * (work.lanes > 2) / cores
    left = max(work.members - known(place), 0)
    again = BESIDE * min(work.companions, left)
    size = PACKED * 8 * (work.turns - work.dropped) * work.kept
    if work.lanes < 3:  # the state to go on from is kept
        size += 8 * found["rows"] * work.lanes
    free = free_bytes(place)
    return {
        "members": left, "steps": work.steps * work.turns, "seconds": each * (left + again), "bytes": size * left,
        "free": float("inf") if free is None else free, "workers": min(cores, 2) if work.lanes < 3 else cores, "lanes": work.lanes,
    }  # fmt: skip


def known(place: Path) -> int:
    """Members that a map file has."""
    from ..errors import VfifeError
    from ..results.mapfile import MapFile

    if not place.exists():
        return 0
    try:
        with MapFile.open(place) as file:
            return len(file.members())
    except VfifeError:  # told when it is gone on with
        return 0


def told_of(work: Work, mechanism: Mechanism, place: Path, yes: bool, quiet: bool) -> None:
    """The forecast, and the end of what nobody can mean."""
    from .forecast import too_much

    if not work.steps:
        return
    with sentences(str(place)):
        found = forecast(work, mechanism, place)
    if much := too_much(found, place):
        if found["bytes"] > found["free"]:
            fail(f"{place}: this map takes {much}. Nothing was begun, and nothing is touched.", STORAGE)
        if not yes:
            fail(f"this map takes {much}; add --yes if that is meant, or ask for fewer members or turns. Nothing was begun.")
    if not quiet and found["members"]:
        tell(
            "forecast",
            f"{counted(found['members'], work.noun)}, some {found['steps']:,.0f} steps each: {span(found['seconds'])} with "
            f"{counted(found['workers'], 'thread')}, {amount_of_bytes(found['bytes'])} in {place}.",
            "bold",
        )
    if not quiet and found["seconds"] > PATIENCE and found["members"] == work.members and (brief := work.brief) is not None:
        seconds = forecast(brief.of(work), mechanism, place)["seconds"]
        tell("note", f"for a first look: {brief.words} -o first{place.suffix}, some {span(seconds)}.")
