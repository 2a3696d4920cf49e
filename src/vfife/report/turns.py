"""Whether the turns of a run repeat, in numbers and in sentences."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..results.view import View


def turned(result: View) -> dict[str, Any]:
    """What stands under ``turns`` in a summary; empty where turns cannot be compared.

    ``count``, ``motion`` ("periodic", "settling", "unsettled", "not periodic"), ``period`` and ``since`` (turns), ``distance`` and ``tolerance``
    (1), ``first`` and ``last`` of the turns that measures are of: see :class:`~vfife.analysis.turns.Turns`.
    """
    said = result.motion
    if said is None:
        return {}
    told = dataclasses.asdict(said)
    return told | {"distance": None if math.isnan(said.distance) else said.distance}


def several(found: dict[str, Any]) -> bool:
    """Whether measures are of more turns than one."""
    return bool(found) and found["last"] > found["first"]


def lines(told: dict[str, Any]) -> Iterable[str]:
    """Lines for the facts of a summary: whether turns repeat, from which one on, and with which period."""
    found = told["turns"]
    if not found:
        if (told["run"]["turns"] or 0.0) >= 2.0 - 1e-9 and told["run"].get("steady"):
            yield 'the step does not divide a turn, so turns cannot be compared; take one that does, or "auto"'
        return
    if found["distance"] is None:
        return
    apart = share(found["distance"])
    if found["motion"] == "periodic":
        if found["period"] == 1:
            yield f"repeats itself from turn {found['since']} on: the last of {found['count']} turns is {apart} from the one before"
        else:
            yield f"repeats itself every {found['period']} turns, from turn {found['since']} of {found['count']} on, to {apart}"
    elif found["motion"] == "settling":
        yield f"has not settled in {found['count']} turns: they come nearer to each other, and are {apart} apart at the end"
    elif found["motion"] == "unsettled":
        yield f"{found['count']} turns do not repeat: the last is {apart} from the nearest before it; more turns tell whether they will"
    else:
        yield f"not periodic: {found['count']} turns do not repeat, the last is {apart} from the nearest; means tell, not single turns"


def share(distance: float) -> str:
    """A distance of turns in per cent."""
    if distance < 5e-5:
        return "less than 0.01 %"
    return f"{100.0 * distance:.2g} %" if distance < 0.1 else f"{100.0 * distance:.0f} %"


def stray(told: dict[str, Any]) -> str:
    """The sentence by which a motion that is not periodic is told; empty for any other."""
    found = told["turns"]
    if not found or found["motion"] != "not periodic":
        return ""
    name = told["trust"].get("measure") or _widest(told)
    if not name or name not in told["ranges"]:
        return ""
    low, high = (f"{apart:+.0f}" if abs(apart) >= 10.0 else f"{apart:+.2g}" for apart in _astray(told, name))
    return (
        f"This motion is not periodic: single turns of {name} lie {low} to {high} % from their mean. "
        f"What is told are means over turns {found['first']} to {found['last']}, which hold where single turns do not."
    )


def _widest(told: dict[str, Any]) -> str:
    """Of the largest forces, less those below a tenth of the largest of all, the one whose turns differ most."""
    forces = {name: value for name, value in told["measures"].items() if name.endswith(".force.max") and name in told["ranges"]}
    large = [name for name, value in forces.items() if value >= 0.1 * max(forces.values())]
    return max(large, key=lambda name: _astray(told, name)[1] - _astray(told, name)[0], default="")


def _astray(told: dict[str, Any], name: str) -> tuple[float, float]:
    """By how much the lowest and the highest turn of a measure lie from its mean, in per cent."""
    one, value = told["ranges"][name], told["measures"][name]
    return tuple(100.0 * (one[key] / value - 1.0) if value else 0.0 for key in ("lowest", "highest"))  # type: ignore[return-value]
