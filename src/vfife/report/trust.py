"""Reliability of a run as data and sentences: its error, the choice of its step, and whether its turns
repeat.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..measures.error_ranges import BLOW_UP, tries_blew_up
from ..measures.trust import HALVINGS, UNSTABLE_TRY, trust
from ..measures.values import NOT_ESTIMATED
from ..solvers.companions import SENSITIVE
from ..solvers.status import Status
from .amounts import deviations, interval, prefixed
from .design_words import and_words
from .digits import NOT_DETERMINED, Json, is_undetermined, unit_of

if TYPE_CHECKING:
    from ..results.run_data import RunData

MOST_MESHES = 2  # elastic bodies that a sentence names
LEAST_DISTANCE = 5e-5  # of turns (1), below which digits say nothing
FAILURES = (Status.DIVERGED, Status.ENERGY, Status.NOT_CONVERGED)
UNCOMPARED = "the step does not divide a turn, so turns cannot be compared"


def trust_summary(result: RunData) -> dict[str, Any]:
    """Return the entry ``trust`` of a summary; empty for a run without companions or repetitions.

    ``companions``; ``sensitive``; the ``measure`` with the largest error, the relative scatter ``apart`` of
    its values over all step sizes (1), ``low`` and ``high`` of the range that estimates its error; where the
    runs diverge, ``time`` (s) and ``joint``; how many are ``lost``; ``tolerance`` (1) and the steps that were
    ``tried``. A smooth run has no companions, and ``order`` beside the error ``apart``. ``former``, for a run
    that goes on from another one: whether the errors of that one are ``included``, else the ``measure`` with
    the largest of them, ``apart`` and ``sensitive``.
    """
    record = result.record
    estimate = trust(record, result.measures)
    if estimate is None:
        return {}
    entry = dataclasses.asdict(estimate) | {
        "sensitive": estimate.sensitive,
        "tolerance": record.assembly.mechanism.settings.tolerance,
    }
    if not entry["unstable"]:
        del entry["unstable"]
    if former := getattr(result, "arguments", {}).get("former"):
        entry["former"] = former
    parting = entry.pop("parting") or {"time": None, "joint": None}
    wild = 1.0 - 1.0 / BLOW_UP if tries_blew_up(record) else math.inf
    tried = [
        {"step": step, "apart": UNSTABLE_TRY if (scatter or 0.0) > wild else scatter}
        for step, scatter in record.assembly.choice.tried
    ]
    return entry | parting | {"tried": tried, "automatic": record.assembly.choice.automatic}


def turns_summary(result: RunData) -> dict[str, Any]:
    """Return the entry ``turns`` of a summary; empty where turns cannot be compared.

    ``count``, ``motion`` ("periodic", "settling", "unsettled", "not repeating"),
    ``period`` and ``since`` (turns), ``distance`` and ``tolerance`` (1), ``first`` and ``last`` of the turns
    that measures are means over; ``scatters`` where turns of a periodic motion scatter with the step, and
    ``peaks_only`` where they were compared by their largest values alone; ``decay`` (1) where a settling
    motion alternates: see :class:`~vfife.measures.repetition.Turns`.
    """
    motion = result.motion
    if motion is None:
        return {}
    entry = {name: value for name, value in dataclasses.asdict(motion).items() if value is not False}
    if not motion.decay:
        del entry["decay"]
    return entry | {"distance": None if math.isnan(motion.distance) else motion.distance}


def over_several_turns(turns: Json) -> bool:
    """Return whether measures are means over more than one turn."""
    return bool(turns) and turns["last"] > turns["first"]


# --------------------------------------------------------------------------------------------------- verdicts


def verdict(summary: Json) -> str:
    """Return the sentence that leads the summary of a sensitive run or of turns that do not repeat;
    empty for any other.
    """
    trust = summary["trust"]
    if not trust or not trust["sensitive"]:
        return scatter_over_turns(summary)
    if trust.get("unstable"):
        return (
            f"The step of {prefixed(summary['step'], 's')} is unstable: forces grow many times beyond"
            " those at smaller steps. Take a smaller step, and quote no number of this run."
        )
    if is_undetermined(summary, trust["measure"]):
        # Companions and tries have larger steps than the run, repetitions of a smooth run smaller ones.
        growth = (
            "range over more than a million times their values at larger steps, which were unstable or passed"
            " a singular position otherwise"
            if trust["companions"]
            else "grow without bound as the step becomes smaller, as reactions in a singular position do"
        )
        return f"{trust['measure']} is {NOT_DETERMINED}: it and others {growth}. Quote no number of this run."
    if not trust.get("converges", True):
        return (
            "This run is sensitive: with half and a quarter of its step the motion does not converge, so it"
            " depends on the step. Quote no single number: shorten the run, take a smaller step, or quote"
            " means over many turns."
        )
    if not trust["companions"]:
        return (
            f"The step is coarse: {trust['measure']} has an error of about {100.0 * trust['apart']:.2g} %, as"
            f" a run with half the step shows. Use a smaller step{'' if trust['automatic'] else ', or auto'}."
        )
    if trust["lost"]:
        return (
            f"The step is near its stable limit: of {trust['companions']} runs with other step sizes"
            f" {trust['lost']} diverged or blew up, and ranges leave them out. Take a smaller step, and"
            " quote no single number."
        )
    scatter = scatter_over_turns(summary) or _scatter_over_steps(trust, summary["measures"][trust["measure"]])
    return scatter + step_coverage(trust) + unstable_tries(trust)


def unstable_tries(trust: Json) -> str:
    """Return which larger steps were not stable and are left out of ranges; "" without any."""
    tries = trust.get("tried", ())  # none in a summary of a former version
    steps = [prefixed(trial["step"], "s") for trial in tries if (trial["apart"] or 0.0) > 1.0]
    if not steps:
        return ""
    return (
        f" At the steps tried before, {and_words(steps)}, runs diverged or blew up: ranges leave those out."
    )


def former_clause(trust: Json) -> str:
    """Return that the errors of the run from which a run goes on are in no range; "" where they are."""
    former = trust.get("former")
    if not former or former["included"]:
        return ""
    size = (
        f"up to {100.0 * former['apart']:.2g} % at {former['measure']}"
        if former["measure"]
        else "not estimated"
    )
    return f"errors of the run that it goes on from ({size}) are not included"


def step_coverage(trust: Json) -> str:
    """Return that the ranges of a sensitive run cover the steps of its companions only, because its step was
    given; "" for an automatic step, whose tries widen the ranges.
    """
    if trust["automatic"]:
        return ""
    return (
        " The step was given, so no other was tried: ranges cover this step and those of its companions only."
        " Leave the step out for ranges that cover the tries of the automatic step as well."
    )


def static_verdict(result: RunData) -> str:
    """Return a sentence on a coarse mesh of a static analysis, or ""."""
    trust = trust_summary(result)
    if not trust or not trust["sensitive"]:
        return ""
    return (
        f"The mesh is coarse: {trust['measure']} has an error of about {100.0 * trust['apart']:.2g} %, as"
        " other numbers of elements show. Give elastic bodies more elements."
    )


def _scatter_over_steps(trust: Json, value: float) -> str:
    """Return the range of the most sensitive measure over companion runs, and where they diverge."""
    name, width = trust["measure"], trust["high"] - trust["low"]
    bounds = interval(trust["low"], trust["high"], unit_of(name), width, "and", prefix=False)
    share = deviations(trust["low"], trust["high"], value)
    text = (
        f"This run is sensitive: {name} lies between {bounds} ({share} of this run) by runs"
        f" with {trust['companions'] + 1} step sizes."
    )
    if trust["time"] is not None:
        text += f" The runs diverge at {trust['time']:.6g} s (joint {trust['joint']})."
    if sum(trial["apart"] is not None for trial in trust["tried"]) == HALVINGS:
        text += (
            f" Halving the step {HALVINGS} times did not make them agree. Quote the range, not the number."
        )
    return text


def scatter_over_turns(summary: Json) -> str:
    """Return the range of single turns of a run whose turns do not repeat; "" for any other.

    It is that of the force whose turns differ most, among the largest; without forces that of the measure
    with the largest error.
    """
    turns = summary["turns"]
    if not turns or turns["motion"] != "not repeating":
        return ""
    name = _most_scattered(summary) or summary["trust"].get("measure")
    if not name or name not in summary["ranges"]:
        return ""
    bounds = summary["ranges"][name]
    share = deviations(bounds["lowest"], bounds["highest"], summary["measures"][name])
    return (
        f"The {turns['count']} turns do not repeat: single turns of {name} lie {share} from their mean. All"
        f" values are means over turns {turns['first']} to {turns['last']}; values of single turns do not"
        " repeat."
    )


def period_sentence(summary: Json) -> str:
    """Return the period of a motion that repeats every few turns, and how far single turns of the force that
    differs most lie from the mean; "" for any other.
    """
    turns = summary["turns"]
    period = (turns or {}).get("period") or 1
    if period < 2:
        return ""
    groups, name = "pairs" if period == 2 else f"groups of {period}", _most_scattered(summary)
    text = f"Period {period}: the turns repeat in {groups}"
    if not name or not over_several_turns(turns):
        return f"{text}."
    bounds = summary["ranges"][name]
    share = deviations(bounds["lowest"], bounds["highest"], summary["measures"][name])
    return f"{text}, and single turns of {name} lie {share} from their mean."


def without_turns(summary: Json) -> bool:
    """Return whether a run of several turns at constant speed has none that can be compared."""
    many_turns = (summary["run"].get("turns") or 0.0) >= 2.0 - 1e-9
    return not summary["turns"] and many_turns and bool(summary["run"].get("steady"))


def _most_scattered(summary: Json) -> str:
    """Return the largest force whose turns differ most; forces below a tenth of the largest are left out."""
    forces = {
        name: value
        for name, value in summary["measures"].items()
        if name.endswith(".force.max") and name in summary["ranges"]
    }
    large = [name for name, value in forces.items() if value >= 0.1 * max(forces.values())]
    return max(
        large, key=lambda name: _turn_range(summary, name)[1] - _turn_range(summary, name)[0], default=""
    )


def _turn_range(summary: Json, name: str) -> tuple[float, float]:
    """Return the deviation of the lowest and of the highest turn of a measure from its mean, in per cent."""
    bounds, value = summary["ranges"][name], summary["measures"][name]
    low, high = (100.0 * (bounds[key] / value - 1.0) if value else 0.0 for key in ("lowest", "highest"))
    return low, high


# ----------------------------------------------------------------------------------------- lines of a summary


def trust_lines(summary: Json) -> Iterator[str]:
    """Yield lines on the agreement of companions, and the automatic steps that were tried."""
    trust = summary["trust"]
    if not trust:
        yield f"{NOT_ESTIMATED}: {missing_estimate(summary)}"
        return
    if trust["measure"] and not trust["companions"]:
        order = f", order {trust['order']:.2f}" if trust["order"] is not None else ""
        yield (
            f"largest values have errors of about {100.0 * trust['apart']:.1g} % at most"
            f" ({trust['measure']}), from runs with smaller steps{order}"
        )
    elif trust["measure"]:
        sensitive = f": sensitive (beyond {100.0 * SENSITIVE:g} %)" if trust["sensitive"] else ""
        within = f"{100.0 * trust['apart']:.2g} % at {trust['measure']}"
        yield f"this run and {trust['companions']} with other step sizes agree within {within}{sensitive}"
    if clause := former_clause(trust):
        yield clause
    elif "former" in trust:
        yield (
            "companions go on from those of the run before, so that ranges include its errors, but not those"
            " of other steps that it tried"
        )
    if clause := mesh_clause(summary):
        yield f"ranges are those of the step; {clause}"
    elif any(body["elements"] > 0 for body in summary["model"]["bodies"].values()):
        yield "ranges are those of the step; the error of the mesh of elastic bodies is not estimated"
    if trust["tried"]:
        unlike = "first contacts too deep, or energy not accounted for"
        shares = [
            unlike
            if trial["apart"] is None
            else "it or a companion diverged or blew up"
            if trial["apart"] > 1.0
            else f"{100.0 * trial['apart']:.2g} %"
            for trial in trust["tried"]
        ]
        steps = (
            f"{prefixed(trial['step'], 's')} ({share})"
            for trial, share in zip(trust["tried"], shares, strict=True)
        )
        yield f"tried before: {', '.join(steps)}"
        if trust["apart"] > trust["tolerance"]:
            yield f"the tolerance of {100.0 * trust['tolerance']:g} % was not reached"


def missing_estimate(summary: Json) -> str:
    """Return why a run has no ranges, and how to get them."""
    if summary["status"] != Status.COMPLETE:
        return "the run did not reach its end"
    if summary["contacts"]:
        if summary["run"]["loop"] != "generated":
            return (
                f"the {summary['run']['loop']} loop runs companions only if you give their number"
                " (companions = 3), and without them the automatic step is different"
            )
        return "it has no companions; take companions"
    if summary["run"]["loop"] != "generated":
        return f"that takes the generated loop, and this was the {summary['run']['loop']} one"
    if summary["run"].get("long", True):
        return "it was not repeated with smaller steps, because it is long; companions = 1 includes that"
    return (
        "it was not repeated with smaller steps, because its settings exclude that (companions = 0) or it was"
        " continued"
    )


def meshes(summary: Json) -> dict[str, int]:
    """Return the elements of the bodies whose mesh error no range of a run over time covers; a link of two
    particles is one element by definition.
    """
    bodies = summary["model"]["bodies"]
    if summary["run"].get("analysis") == "static":
        return {}
    return {
        name: body["elements"]
        for name, body in bodies.items()
        if body["elements"] and body["model"] != "two-particle"
    }


def mesh_clause(summary: Json) -> str:
    """Return which meshes ranges do not cover, and what to compare; "" without any."""
    elements, bodies = meshes(summary), summary["model"]["bodies"]
    if not elements:
        return ""
    if len(elements) > MOST_MESHES:
        return f"the meshes of {len(elements)} elastic bodies are not covered: compare twice the elements"
    named = [f"{name} ({count} element{'s' * (count > 1)})" for name, count in elements.items()]
    phrase = (
        f"the mesh of {and_words(named)} is" if len(named) == 1 else f"the meshes of {and_words(named)} are"
    )
    links = all(bodies[name]["model"] == "elastic" for name in elements)
    options = " ".join(f"--set body.{name}.elements={2 * count}" for name, count in elements.items())
    return f"{phrase} not covered: compare {options if links else 'twice the elements'}"


def missing_mesh_estimate(summary: Json) -> str:
    """Return why a static analysis has no ranges, and how to get them."""
    bodies = summary["model"]["bodies"].values()
    if summary["status"] != Status.COMPLETE:
        return "the analysis did not reach its end"
    if not any(body["elements"] for body in bodies):
        return "no body is cut into elements that could be halved"
    if any(body["model"] == "two-particle" for body in bodies):
        return "a link of two particles is one element by definition, which cannot be halved"
    if summary["run"].get("long", True):
        return "the repetition on other meshes takes long; companions = 1 includes it"
    if summary["run"]["refined"]:
        return "the repetition with twice the elements found no equilibrium or was interrupted"
    return "companions = 0 excludes the repetition on other meshes"


def turn_lines(summary: Json) -> Iterator[str]:
    """Yield a line on whether turns repeat, since which turn, and with which period."""
    turns = summary["turns"]
    if not turns:
        if without_turns(summary):
            yield f'{UNCOMPARED}; take one that does, or "auto"'
        return
    if turns["distance"] is None:
        return
    count, since, distance = turns["count"], turns["since"], turn_distance(turns["distance"])
    if turns.get("peaks_only"):
        yield "the step does not divide a turn, so turns are compared by their largest values only"
    if turns.get("scatters"):
        interval_text = "every turn" if turns["period"] == 1 else f"every {turns['period']} turns"
        yield (
            f"repeats itself {interval_text}, and turns {since} to {count} scatter about that with the step,"
            f" by {distance}"
        )
        return
    if decay := turns.get("decay"):
        yield f"has not settled in {count} turns: {alternation_words(decay, turns['distance'])}"
        return
    motions = {
        "periodic": (
            f"repeats itself every {turns['period']} turns, from turn {since} of {count} on, to {distance}"
        ),
        "settling": (
            f"has not settled in {count} turns: they approach each other, and are {distance} apart at the end"
        ),
        "unsettled": (
            f"{count} turns do not repeat: the last is {distance} from the nearest before it; more turns show"
            " whether they will"
        ),
        "not repeating": (
            f"{count} turns do not repeat: the last is {distance} from the nearest, as in a motion without a"
            " period or in a longer transient, which more turns or vfife map section tell apart; quote means"
            " over turns, not single turns"
        ),
    }
    if turns["motion"] == "periodic" and turns["period"] == 1:
        yield (
            f"repeats itself from turn {since} on: the last of {count} turns is {distance} from the one"
            " before"
        )
    else:
        yield motions[turns["motion"]]


def alternation_words(decay: float, distance: float) -> str:
    """Return how the turns of a settling motion alternate, as a clause."""
    shrinking = f"{max(100.0 * decay, 0.1):.2g} %"
    return (
        f"they alternate, {turn_distance(distance)} apart, and the difference shrinks by {shrinking} a turn"
    )


def turn_distance(distance: float) -> str:
    """Return the distance of turns (1) as a percentage."""
    if distance < LEAST_DISTANCE:
        return "less than 0.01 %"
    return f"{100.0 * distance:.2g} %" if distance < 0.1 else f"{100.0 * distance:.0f} %"


def settling_sentence(summary: Json) -> str:
    """Return by how much turns differ that do not repeat yet, and how many to run; "" for others."""
    turns = summary["turns"]
    is_open = turns and turns["motion"] in ("settling", "unsettled") and summary["status"] not in FAILURES
    distance = (turns["distance"] or 0.0) if is_open else 0.0
    if distance < LEAST_DISTANCE:
        return ""
    state = "The motion still settles: its" if turns["motion"] == "settling" else "The"
    if decay := turns.get("decay"):
        words = alternation_words(decay, distance)
        return f"{state} turns do not repeat in pairs, {words}. Run {2 * turns['count']} turns."
    options = settling_options(turns["count"])
    return f"{state} turns do not repeat yet ({turn_distance(distance)} apart): run it with {options}."


def settling_options(count: int) -> str:
    """Return the options of a run that ends when its turns repeat, after one of ``count`` turns."""
    return f"--turns {turns_to_settle(count)} --settle 1%"


def turns_to_settle(count: int) -> int:
    """Return a number of turns in which those of a run repeat that did not within ``count``."""
    return 10 * max(count, 4)
