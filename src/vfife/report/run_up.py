"""Words on the run-up of a motor, on a motor that does not turn its machine, and on journals that jump."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from .design_words import and_words
from .digits import Json
from .trust import FAILURES

RISE = 0.9  # of the least speed in later turns: a start below it is a run-up, no fluctuation of a turn
WITH_RUN_UP = "with the run-up"


def run_ups(summary: Json) -> dict[str, float]:
    """Return the drivers that run a machine up in a run whose measures include that, and their speeds (rad/s)
    at its start.
    """
    if summary["part"] != "whole run" or summary["status"] in FAILURES:
        return {}
    return {
        name: effort["start"]
        for name, effort in _motors(summary)
        if effort["turns"] and effort["start"] < RISE * effort["low"]["value"]
    }


def stalls(summary: Json) -> list[str]:
    """Return words on each motor that stands at the end of a run, or with which a body on gears, or every
    body, is less than a turn on.
    """
    if summary["status"] in FAILURES:
        return []
    return [
        f"Driver {name}: {words}."
        for name, effort in _motors(summary)
        if effort["curve"] and (words := _stall(effort))
    ]


def _stall(effort: Json) -> str:
    """Return how far a motor does not turn its machine; "" for one that does."""
    if not effort["turns"]:
        return "no body is a whole turn on at the end of the run"
    parts = [
        f"{body} is only {math.floor(100.0 * share) / 100.0:.2g} of a turn on"
        for body, share in effort.get("parts", {}).items()
    ]
    stands = ["what it turns stands"] * effort.get("stands", False)
    return f"{and_words([*stands, *parts])} at the end of the run" if stands or parts else ""


def motor_sentence(summary: Json, remedy: bool = False) -> str:
    """Return that values include a run-up, or that a motor does not turn its machine, and a ``remedy``; ""
    for other runs.
    """
    if sentences := stalls(summary):
        text = " ".join(sentences)
        action = (
            "If the machine should go round, look for a torque that is too small for the loads or has the"
            " wrong sign, for a gear with the inverse ratio, or take a longer run."
        )
    elif ups := run_ups(summary):
        starts = [f"{name} from {_rpm(speed) if speed else 'rest'}" for name, speed in ups.items()]
        text = f"Forces, knocks and friction include the run-up of {and_words(starts)}."
        action = "The machine in operation: vfife run MODEL --start-from RUN."
    else:
        return ""
    return f"{text} {action}" if remedy else text


def run_up_note(summaries: Mapping[str, Json]) -> str:
    """Return which of several runs include a run-up, where others do not; "" else."""
    ups = [name for name, summary in summaries.items() if run_ups(summary)]
    if not ups or len(ups) == len(summaries):
        return ""
    return (
        f"Forces, knocks and friction of {and_words(ups)} include the run-up of a motor: their changes"
        " against a run without one compare different motions."
    )


def _rpm(speed: float) -> str:
    """Return a speed (rad/s) that a run reached, to three digits."""
    return f"about {float(f'{30.0 * speed / math.pi:.3g}'):,g} rpm"


def jump_caution(joints: Sequence[str]) -> str:
    """Return a sentence on joints whose clearance is not that of the run from which a run goes on."""
    return (
        f"The clearance of {and_words(list(joints))} is not that of the run from which this one goes on: the"
        " journals jump to it at the start, and the hardest knocks and largest forces may be those of this"
        " jump. For values without it, go on from the end of this run with the same model (--start-from)."
    )


def _motors(summary: Json) -> Iterator[tuple[str, Json]]:
    """Yield name and figures of drivers that turn a body; files of former versions have no speed at the
    start.
    """
    for name, effort in summary.get("efforts", {}).items():
        if not effort["linear"] and "start" in effort:
            yield name, effort
