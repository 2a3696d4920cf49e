"""How far a run can be trusted, in numbers and in sentences: its error, how its step was found, and whether
its turns repeat.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..measures.measured import NOT_ESTIMATED
from ..measures.ranges import HALVINGS, trust
from ..solvers.companions import SENSITIVE
from ..solvers.status import Status
from .digits import amount, prefixed

if TYPE_CHECKING:
    from ..results.view import View

UNITS = {
    "force.max": "N",
    "moment.max": "N m",
    "torque.max": "N m",
    "penetration.max": "m",
    "angular_acceleration.max": "rad/s²",
}  # of what steps are judged by


def trusted(result: View) -> dict[str, Any]:
    """What stands under ``trust`` in a summary.

    ``companions``; ``sensitive``; the ``measure`` that is known worst, how far its values at all step sizes
    lie ``apart`` (1), ``low`` and ``high`` of the range that estimates its error; where the runs diverge,
    ``time`` (s) and ``joint``; how many are ``lost``; ``tolerance`` (1) and the steps that were ``tried``. A
    smooth run has no companions, and ``order`` beside the error ``apart``. Empty for a run that nobody looked
    at.
    """
    record = result.record
    said = trust(record, result.measures)
    if said is None:
        return {}
    found = dataclasses.asdict(said) | {
        "sensitive": said.sensitive,
        "tolerance": record.assembly.mechanism.settings.tolerance,
    }
    parting = found.pop("parting") or {"time": None, "joint": None}
    tried = [{"step": step, "apart": apart} for step, apart in record.assembly.choice.tried]
    return found | parting | {"tried": tried, "automatic": record.assembly.choice.automatic}


def verdict(summary: dict[str, Any]) -> str:
    """The sentence that a sensitive run, or a motion that is not periodic, is told by; empty for any other."""
    found = summary["trust"]
    if not found or not found["sensitive"]:
        return stray(summary)
    if not found["companions"] and summary.get("static"):
        return (
            f"The mesh is coarse: {found['measure']} errs by some {100.0 * found['apart']:.2g} %, as other"
            " numbers of elements tell. Give elastic bodies more elements."
        )
    if not found.get("converges", True):
        return (
            "This run is sensitive: with half and with a quarter of its step the motion does not come closer,"
            " so the steps decide it. Quote no single number: make the run shorter, take a smaller step, or"
            " tell means over many turns."
        )
    if not found["companions"]:
        return (
            f"The step is coarse: {found['measure']} errs by some {100.0 * found['apart']:.2g} %, as a run"
            f" with half of it tells. Take a smaller step{'' if found['automatic'] else ', or auto'}."
        )
    if found["lost"]:
        return (
            f"This run is sensitive: of {found['companions']} runs with other step sizes {found['lost']} left"
            " all bounds. Take a smaller step, and trust no single number."
        )
    if sentence := stray(summary):
        return sentence
    name, value = found["measure"], summary["measures"][found["measure"]]
    low, high = (100.0 * (found[key] / value - 1.0) for key in ("low", "high"))
    unit = next(unit for kind, unit in UNITS.items() if name.endswith(kind))
    where = (
        f" The runs diverge at {found['time']:.6g} s (joint {found['joint']})."
        if found["time"] is not None
        else ""
    )
    width = found["high"] - found["low"]
    bounds = f"{amount(found['low'], '', width).rstrip()} and {amount(found['high'], unit, width)}"
    searched = ""
    if sum(one["apart"] is not None for one in found["tried"]) == HALVINGS:
        searched = (
            f" Halving the step {HALVINGS} times did not bring them together. Quote the range, not the"
            " number."
        )
    return (
        f"This run is sensitive: {name} lies between {bounds} ({low:+.2g} to {high:+.2g} % of this run) "
        f"by runs with {found['companions'] + 1} step sizes.{where}{searched}"
    )


def unestimated(summary: dict[str, Any]) -> str:
    """Why a run has no ranges, and how to get them."""
    if summary["status"] != Status.COMPLETE:
        why = "the run did not come to its end"
    elif summary["contacts"]:
        why = "it has no companions; take companions"
    elif summary["run"]["loop"] != "generated":
        why = f"that takes the generated loop, and this was the {summary['run']['loop']} one"
    else:
        why = (
            "it was not repeated with smaller steps, being long, interrupted, or told not to be; companions ="
            " 1 has it repeated"
        )
    return f"{NOT_ESTIMATED}: {why}"


def lines(summary: dict[str, Any]) -> Iterable[str]:
    """Short lines for the facts of a summary: what the companions say, and what was tried of an automatic
    step.
    """
    found = summary["trust"]
    if not found:
        yield unestimated(summary)
        return
    if found["measure"] and not found["companions"]:
        order = f", order {found['order']:.2f}" if found["order"] is not None else ""
        yield (
            f"largest values err by some {100.0 * found['apart']:.1g} % at the most ({found['measure']}), by"
            f" runs at smaller steps{order}"
        )
        if any(body["elements"] > 0 for body in summary["model"]["bodies"].values()):
            yield "ranges are those of the step; the error of the mesh of elastic bodies is not estimated"
    elif found["measure"]:
        within = f"{100.0 * found['apart']:.2g} % at {found['measure']}"
        yield f"this run and {found['companions']} with other step sizes agree within {within}" + (
            f": sensitive (beyond {100.0 * SENSITIVE:g} %)" if found["sensitive"] else ""
        )
    if found["tried"]:
        unlike = "first contacts too deep, or energy not accounted for"
        shares = (
            unlike if one["apart"] is None else f"{100.0 * one['apart']:.2g} %" for one in found["tried"]
        )
        steps = ", ".join(
            f"{prefixed(one['step'], 's')} ({share})"
            for one, share in zip(found["tried"], shares, strict=True)
        )
        yield f"tried before: {steps}"
        if found["apart"] > found["tolerance"]:
            yield f"the tolerance of {100.0 * found['tolerance']:g} % was not reached"


def turned(result: View) -> dict[str, Any]:
    """What stands under ``turns`` in a summary; empty where turns cannot be compared.

    ``count``, ``motion`` ("periodic", "settling", "unsettled", "not periodic"), ``period`` and ``since``
    (turns), ``distance`` and ``tolerance`` (1), ``first`` and ``last`` of the turns that measures are of: see
    :class:`~vfife.measures.turns.Turns`.
    """
    said = result.motion
    if said is None:
        return {}
    return dataclasses.asdict(said) | {"distance": None if math.isnan(said.distance) else said.distance}


def several(found: dict[str, Any]) -> bool:
    """Whether measures are of more turns than one."""
    return bool(found) and found["last"] > found["first"]


def turn_lines(summary: dict[str, Any]) -> Iterable[str]:
    """Lines for the facts of a summary: whether turns repeat, from which one on, and with which period."""
    found = summary["turns"]
    if not found:
        if (summary["run"]["turns"] or 0.0) >= 2.0 - 1e-9 and summary["run"].get("steady"):
            yield (
                'the step does not divide a turn, so turns cannot be compared; take one that does, or "auto"'
            )
        return
    if found["distance"] is None:
        return
    apart = share(found["distance"])
    if found["motion"] == "periodic":
        if found["period"] == 1:
            yield (
                f"repeats itself from turn {found['since']} on: the last of {found['count']} turns is {apart}"
                " from the one before"
            )
        else:
            yield (
                f"repeats itself every {found['period']} turns, from turn {found['since']} of"
                f" {found['count']} on, to {apart}"
            )
    elif found["motion"] == "settling":
        yield (
            f"has not settled in {found['count']} turns: they come nearer to each other, and are {apart}"
            " apart at the end"
        )
    elif found["motion"] == "unsettled":
        yield (
            f"{found['count']} turns do not repeat: the last is {apart} from the nearest before it; more"
            " turns tell whether they will"
        )
    else:
        yield (
            f"not periodic: {found['count']} turns do not repeat, the last is {apart} from the nearest; means"
            " tell, not single turns"
        )


def share(distance: float) -> str:
    """A distance of turns in per cent."""
    if distance < 5e-5:
        return "less than 0.01 %"
    return f"{100.0 * distance:.2g} %" if distance < 0.1 else f"{100.0 * distance:.0f} %"


def stray(summary: dict[str, Any]) -> str:
    """The sentence by which a motion that is not periodic is told; empty for any other."""
    found = summary["turns"]
    if not found or found["motion"] != "not periodic":
        return ""
    name = summary["trust"].get("measure") or _widest(summary)
    if not name or name not in summary["ranges"]:
        return ""
    low, high = (
        f"{apart:+.0f}" if abs(apart) >= 10.0 else f"{apart:+.2g}" for apart in _astray(summary, name)
    )
    return (
        f"This motion is not periodic: single turns of {name} lie {low} to {high} % from their mean. What is"
        f" told are means over turns {found['first']} to {found['last']}, which hold where single turns do"
        " not."
    )


def _widest(summary: dict[str, Any]) -> str:
    """Of the largest forces, less those below a tenth of the largest of all, the one whose turns differ most."""
    forces = {
        name: value
        for name, value in summary["measures"].items()
        if name.endswith(".force.max") and name in summary["ranges"]
    }
    large = [name for name, value in forces.items() if value >= 0.1 * max(forces.values())]
    return max(large, key=lambda name: _astray(summary, name)[1] - _astray(summary, name)[0], default="")


def _astray(summary: dict[str, Any], name: str) -> tuple[float, float]:
    """By how much the lowest and the highest turn of a measure lie from its mean, in per cent."""
    one, value = summary["ranges"][name], summary["measures"][name]
    return tuple(100.0 * (one[key] / value - 1.0) if value else 0.0 for key in ("lowest", "highest"))  # type: ignore[return-value]
