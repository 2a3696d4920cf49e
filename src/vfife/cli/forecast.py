"""What a study will cost before it is begun: time from a few of its members, bytes from one; members that share no compiled step."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly
    from ..model.mechanism import Mechanism
    from ..study.plan import Asked, Plan

LOOKED_AT = 5  # members that are assembled for a forecast
SHARED = 0.75  # of the lanes' speed that is had
BYTES = 400, 60  # of a member, and of each number it has or leaves
MOST_KINDS = 12
PARTS = 360  # of a turn, of which whole numbers of steps go into lanes
MADE = 0.03  # s that it takes to assemble a member and to read what it leaves, one after another


def forecast(numbers: Sequence[dict[str, Any]], base: Mechanism, asked: Asked, target: Path, anew: bool = False) -> dict[str, Any]:
    """Members to compute, steps of each, seconds, bytes; estimates, and called so."""
    from ..results.member_errors import sample_size
    from ..study.run_missing import RATIO

    left = list(numbers)
    if target.is_file() and not anew:
        from ..results.studied import Study
        from ..results.studyfile import hash_of

        there = {one.hash for one in Study.open(target).done}
        left = [one for one in left if hash_of(one) not in there]
    chosen = [left[k * (len(left) - 1) // max(LOOKED_AT - 1, 1)] for k in range(min(LOOKED_AT, len(left)))]
    found = expected(chosen, len(left), len(numbers) - len(left), base, asked, target)
    found["seconds"] *= 1.0 + sample_size(len(numbers)) / (RATIO * max(len(left), 1))  # a sample is repeated with coarser steps
    return found


def sought(
    chosen: Sequence[dict[str, Any]], members: int, at_once: int, base: Mechanism, asked: Asked, target: Path, anew: bool = False
) -> dict[str, Any]:
    """The same of a search for so many members, some of which are ``chosen``; those that end in its file already are taken for its own."""
    done = 0
    if target.is_file() and not anew:
        from ..results.studied import Study

        done = min(len(Study.open(target).done), members)
    return expected(chosen, members - done, done, base, asked, target, at_once)


def expected(
    chosen: Sequence[dict[str, Any]], left: int, done: int, base: Mechanism, asked: Asked, target: Path, at_once: float = float("inf")
) -> dict[str, Any]:
    """What so many members will cost that are ``left``, from those ``chosen`` of them; ``at_once`` are asked for together.

    Members of which a turn holds no whole number of outputs, as a step that is given may have it, go into no lanes.
    """
    from ..codegen.native import stream_lanes
    from ..errors import VfifeError
    from ..files import free_bytes
    from ..job.cost import run_cost
    from ..study.member import streams

    seconds, steps, contacts, unfit = [0.0], [0], 0, set()
    for one in chosen:
        try:
            assembly = member(base, one, asked)
        except VfifeError:  # told when it is run
            continue
        seconds.append(run_cost(assembly).seconds)
        steps.append(assembly.choice.steps)
        contacts = max(contacts, len(assembly.topology.contact_bearing))
        if not streams(assembly) and not assembly.choice.automatic and assembly.choice.turn is not None:
            unfit.add(assembly.choice.turn)
    cores, lanes = os.cpu_count() or 1, 1 if unfit else stream_lanes(contacts)
    each, count = sum(seconds), max(len(seconds) - 1, 1)
    free = free_bytes(target)
    first, more = BYTES
    return {
        "members": left,
        "done": done,
        "steps": sum(steps) / count,
        "seconds": left * (each / count / min(cores * max(1.0, SHARED * lanes), at_once) + MADE),
        "bytes": left * (first + more * len(next(iter(chosen), {}))),
        "free": float("inf") if free is None else free,
        "workers": cores,
        "lanes": lanes,
        "turns": unfit,
    }


def member(base: Mechanism, numbers: dict[str, Any], asked: Asked) -> Assembly:
    """A member assembled."""
    from ..assembly.assemble import assemble
    from ..modelfile import dump, loads

    return assemble(loads(dump(base), list(numbers.items())), asked.step, turns=float(asked.turns))


def too_much(found: dict[str, Any], place: Path) -> str:
    """What of a forecast may not be meant, in words; empty where nothing is."""
    from ..job.cost import LONG, SHARE
    from .terminal import amount_of_bytes, span

    said = []
    if found["seconds"] > LONG:
        said.append(f"some {span(found['seconds'])} for {found['members']:,} members of {found['steps']:,.0f} steps each")
    if found["bytes"] > SHARE * found["free"]:
        said.append(f"some {amount_of_bytes(found['bytes'])} on a disk that has {amount_of_bytes(found['free'])} left")
    return " and ".join(said)


def refuse_absurd(found: dict[str, Any], place: Path, yes: bool, what: str = "study") -> None:
    """The end of what nobody can mean, before anything is begun."""
    from .terminal import STORAGE, fail

    if much := too_much(found, place):
        if found["bytes"] > found["free"]:
            fail(f"{place}: this {what} takes {much}. Nothing was begun, and nothing is touched.", STORAGE)
        if not yes:
            fail(f"this {what} takes {much}; add --yes if that is meant, or ask for fewer members or turns. Nothing was begun.")


def tell_forecast(found: dict[str, Any], place: Path, plan: Plan) -> None:
    """The forecast in a line, and what of the measures does not heed the turns that are chosen."""
    from ..study.study_file import beside_last
    from .terminal import amount_of_bytes, counted, span, tell

    done = f" beside {found['done']:,} that are there" if found["done"] else ""
    tell(
        "forecast",
        f"{counted(found['members'], 'member')}{done}, some {found['steps']:,.0f} steps each: {span(found['seconds'])} with "
        f"{found['workers']} threads of {counted(found['lanes'], 'lane')}, {amount_of_bytes(found['bytes'])} in {place}.",
        "bold",
    )
    if said := beside_last(plan.asked):
        tell("note", said)
    if found["turns"] and found["lanes"] == 1:
        tell("note", one_by_one(found["turns"], plan.asked))


def one_by_one(turns: set[float], asked: Asked) -> str:
    """Why members go into no lanes, in words, and what step of theirs would."""
    said = f"a turn of the crank is no whole number of outputs at the step that is given, {asked.step:g} s: members run one by one, not in lanes"
    if len(turns) > 1:
        return f'{said}; with step = "auto" many more run in a second.'
    (turn,) = turns
    fitting = turn / (PARTS * math.ceil(turn / asked.step / PARTS))
    return f'{said}; with step = "{fitting!r} s" or "auto" many more run in a second.'


def groups(numbers: Sequence[dict[str, Any]], base: Mechanism) -> list[str]:
    """Members of other topologies, which share no lanes, in words: those that differ in words or in whole numbers of the model."""
    from ..modelfile.parameter import Parameter

    paths = [path for path in next(iter(numbers), {}) if Parameter(base, path).quantity is None]
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
