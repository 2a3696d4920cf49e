"""How far a run can be trusted, in numbers and in sentences: the error that runs with other step sizes estimate, and how its step was found."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..analysis.measured import NOT_ESTIMATED
from ..analysis.ranges import HALVINGS, trust
from ..solvers.companions import SENSITIVE
from ..solvers.status import Status
from .digits import amount, prefixed
from .turns import stray

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

    ``companions``; ``sensitive``; the ``measure`` that is known worst, how far its values at all step sizes lie ``apart`` (1),
    ``low`` and ``high`` of the range that estimates its error; where the runs diverge, ``time`` (s)
    and ``joint``; how many are ``lost``; ``tolerance`` (1) and the steps that were ``tried``. A smooth run has no
    companions, and ``order`` beside the error ``apart``. Empty for a run that nobody looked at.
    """
    record = result.record
    said = trust(record, result.measures)
    if said is None:
        return {}
    told = dataclasses.asdict(said) | {"sensitive": said.sensitive, "tolerance": record.assembly.mechanism.settings.tolerance}
    parting = told.pop("parting") or {"time": None, "joint": None}
    tried = [{"step": step, "apart": apart} for step, apart in record.assembly.choice.tried]
    return told | parting | {"tried": tried, "automatic": record.assembly.choice.automatic}


def verdict(told: dict[str, Any]) -> str:
    """The sentence that a sensitive run, or a motion that is not periodic, is told by; empty for any other."""
    found = told["trust"]
    if not found or not found["sensitive"]:
        return stray(told)
    if not found["companions"] and told.get("static"):
        return (
            f"The mesh is coarse: {found['measure']} errs by some {100.0 * found['apart']:.2g} %, as other numbers of elements tell. "
            "Give elastic bodies more elements."
        )
    if not found.get("converges", True):
        return (
            "This run is sensitive: with half and with a quarter of its step the motion does not come closer, so the steps decide it. Quote no "
            "single number: make the run shorter, take a smaller step, or tell means over many turns."
        )
    if not found["companions"]:
        return (
            f"The step is coarse: {found['measure']} errs by some {100.0 * found['apart']:.2g} %, as a run with half of it tells. "
            f"Take a smaller step{'' if found['automatic'] else ', or auto'}."
        )
    if found["lost"]:
        return (
            f"This run is sensitive: of {found['companions']} runs with other step sizes {found['lost']} left all bounds. "
            "Take a smaller step, and trust no single number."
        )
    if sentence := stray(told):
        return sentence
    name, value = found["measure"], told["measures"][found["measure"]]
    low, high = (100.0 * (found[key] / value - 1.0) for key in ("low", "high"))
    unit = next(unit for kind, unit in UNITS.items() if name.endswith(kind))
    where = f" The runs diverge at {found['time']:.6g} s (joint {found['joint']})." if found["time"] is not None else ""
    width = found["high"] - found["low"]
    bounds = f"{amount(found['low'], '', width).rstrip()} and {amount(found['high'], unit, width)}"
    searched = ""
    if sum(one["apart"] is not None for one in found["tried"]) == HALVINGS:
        searched = f" Halving the step {HALVINGS} times did not bring them together. Quote the range, not the number."
    return (
        f"This run is sensitive: {name} lies between {bounds} ({low:+.2g} to {high:+.2g} % of this run) "
        f"by runs with {found['companions'] + 1} step sizes.{where}{searched}"
    )


def unestimated(told: dict[str, Any]) -> str:
    """Why a run has no ranges, and how to get them."""
    if told["status"] != Status.COMPLETE:
        why = "the run did not come to its end"
    elif told["contacts"]:
        why = "it has no companions; take companions"
    elif told["run"]["loop"] != "generated":
        why = f"that takes the generated loop, and this was the {told['run']['loop']} one"
    else:
        why = "it was not repeated with smaller steps, being long, interrupted, or told not to be; companions = 1 has it repeated"
    return f"{NOT_ESTIMATED}: {why}"


def lines(told: dict[str, Any]) -> Iterable[str]:
    """Short lines for the facts of a summary: what the companions say, and what was tried of an automatic step."""
    found = told["trust"]
    if not found:
        yield unestimated(told)
        return
    if found["measure"] and not found["companions"]:
        order = f", order {found['order']:.2f}" if found["order"] is not None else ""
        yield f"largest values err by some {100.0 * found['apart']:.1g} % at the most ({found['measure']}), by runs at smaller steps{order}"
        if any(body["elements"] > 0 for body in told["model"]["bodies"].values()):
            yield "ranges are those of the step; the error of the mesh of elastic bodies is not estimated"
    elif found["measure"]:
        within = f"{100.0 * found['apart']:.2g} % at {found['measure']}"
        yield f"this run and {found['companions']} with other step sizes agree within {within}" + (
            f": sensitive (beyond {100.0 * SENSITIVE:g} %)" if found["sensitive"] else ""
        )
    if found["tried"]:
        unlike = "first contacts too deep, or energy not accounted for"
        shares = (unlike if one["apart"] is None else f"{100.0 * one['apart']:.2g} %" for one in found["tried"])
        steps = ", ".join(f"{prefixed(one['step'], 's')} ({share})" for one, share in zip(found["tried"], shares, strict=True))
        yield f"tried before: {steps}"
        if found["apart"] > found["tolerance"]:
            yield f"the tolerance of {100.0 * found['tolerance']:g} % was not reached"
