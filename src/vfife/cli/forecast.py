"""What a study will cost before it is begun: time from a few of its members, bytes from one; members that share no compiled step."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..model.mechanism import Mechanism

LOOKED_AT = 5  # members that are assembled for a forecast
SHARED = 0.75  # of the lanes' speed that is had
BYTES = 400, 60  # of a member, and of each number it has or leaves
MOST_KINDS = 12


def forecast(numbers: Sequence[dict[str, Any]], base: Mechanism, turns: int, target: Path, anew: bool = False) -> dict[str, Any]:
    """Members to compute, steps of each, seconds, bytes; estimates, and called so."""
    from ..codegen.native import widest
    from ..errors import VfifeError
    from ..results.tables import free_bytes
    from .cost import estimate

    left = list(numbers)
    if target.is_file() and not anew:
        from ..results.studied import Study
        from ..results.studyfile import hash_of

        there = {one.hash for one in Study.open(target).done}
        left = [one for one in left if hash_of(one) not in there]
    chosen = [left[k * (len(left) - 1) // max(LOOKED_AT - 1, 1)] for k in range(min(LOOKED_AT, len(left)))]
    seconds, steps = [0.0], [0]
    for one in chosen:
        try:
            assembly = member(base, one, turns)
        except VfifeError:  # told when it is run
            continue
        seconds.append(estimate(assembly)["seconds"])
        steps.append(assembly.choice.steps)
    cores, lanes = os.cpu_count() or 1, widest()
    each, count = sum(seconds), max(len(seconds) - 1, 1)
    free = free_bytes(target)
    first, more = BYTES
    return {
        "members": len(left),
        "done": len(numbers) - len(left),
        "steps": sum(steps) / count,
        "seconds": each / count * len(left) / (cores * max(1.0, SHARED * lanes)),
        "bytes": len(left) * (first + more * len(next(iter(numbers), {}))),
        "free": float("inf") if free is None else free,
        "workers": cores,
        "lanes": lanes,
    }


def member(base: Mechanism, numbers: dict[str, Any], turns: int) -> Assembly:
    """A member assembled."""
    from ..assembly.assemble import assemble
    from ..modelfile import dump, loads

    return assemble(loads(dump(base), list(numbers.items())), turns=float(turns))


def too_much(found: dict[str, Any], place: Path) -> str:
    """What of a forecast may not be meant, in words; empty where nothing is."""
    from .cost import LONG, SHARE
    from .terminal import amount_of_bytes, span

    said = []
    if found["seconds"] > LONG:
        said.append(f"some {span(found['seconds'])} for {found['members']:,} members of {found['steps']:,.0f} steps each")
    if found["bytes"] > SHARE * found["free"]:
        said.append(f"some {amount_of_bytes(found['bytes'])} on a disk that has {amount_of_bytes(found['free'])} left")
    return " and ".join(said)


def groups(numbers: Sequence[dict[str, Any]], base: Mechanism) -> list[str]:
    """Members of other topologies, which share no lanes, in words: those that differ in words or in whole numbers of the model."""
    from ..fields import Measure
    from ..modelfile import dump
    from ..modelfile.read import raw_of
    from ..study.places import held_at

    raw = raw_of(dump(base), "model")
    paths = [path for path in next(iter(numbers), {}) if not isinstance(held_at(raw, steps_of(path)), Measure)]
    counted: dict[tuple[Any, ...], int] = {}
    for one in numbers if paths else ():
        key = tuple(one[path] for path in paths)
        counted[key] = counted.get(key, 0) + 1
    if len(counted) < 2:
        return []
    words = [", ".join(f"{path} = {value:g}" if isinstance(value, float) else f"{path} = {value}" for path, value in zip(paths, key, strict=True))
             for key in counted]  # fmt: skip
    listed = "; ".join(f"{text}: {count:,}" for text, count in list(zip(words, counted.values(), strict=True))[:MOST_KINDS])
    more = "; ..." if len(counted) > MOST_KINDS else ""
    return [f"members of {len(counted)} kinds are run group by group, each with its own compiled step ({listed}{more})."]


def steps_of(path: str) -> tuple[str | int, ...]:
    """Keys and indices of a path in full."""
    return tuple(int(part) if part.isdecimal() else part for part in path.split("."))
