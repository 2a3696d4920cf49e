"""Numbers that change the time of a turn of the crank: a run with a duration has no derivatives by them.

The measures of a run are those of its last turn, the last 360 degrees before its end. With a number of turns
this part of the motion follows the crank. With a duration it moves through the motion as the speed changes:
single impacts enter and leave it in jumps, and no slope describes how the measures change.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from ...errors import Fault, ModelError, VfifeError
from ...model.functions import turn_of
from ...model.mechanism import Mechanism
from ...modelfile.parameter import Parameter
from .finite_difference import NEIGHBOUR_SHARE

REASON = (
    "the run has a duration, and this number changes the time of a turn: the last turn is then another part"
    " of the motion"
)
REMEDY = "give the run as turns (turns, --turns)"
Values = Mapping[str, float]


def turn_numbers(mechanism: Mechanism, chosen: Values) -> list[str]:
    """Return the paths of those numbers that change the time of a turn."""
    turn, paths = turn_of(mechanism), []
    for path, value in chosen.items():
        if not path.startswith("driver."):
            continue
        with suppress(VfifeError):
            changed = Parameter(mechanism, path).set(value + NEIGHBOUR_SHARE * abs(value))
            if turn_of(changed) != turn:
                paths.append(path)
    return paths


def without_turn_numbers(mechanism: Mechanism, chosen: Values) -> tuple[dict[str, float], dict[str, str]]:
    """Return the numbers by which a run of a mechanism can be differentiated and, if its settings have a
    duration, those that change the time of a turn, with the reason. Raises ModelError if there are no others.
    """
    paths = turn_numbers(mechanism, chosen) if mechanism.settings.duration is not None else []
    remaining_numbers = {path: value for path, value in chosen.items() if path not in paths}
    if paths and not remaining_numbers:
        raise ModelError([Fault(f"to {path!r}", REASON, "", "", REMEDY) for path in paths], mechanism.name)
    return remaining_numbers, dict.fromkeys(paths, f"{REASON}; {REMEDY}")
