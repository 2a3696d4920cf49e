"""Members of streams in eight lanes beside four, by topology: what
:func:`vfife.compiler.runtime.native.stream_lanes` follows from.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

from measure import EXAMPLES, Options, Part, table

from vfife import load_model
from vfife.compiler.runtime.native import stream_lanes, widest
from vfife.model.functions import turn_of
from vfife.model.mechanism import Mechanism
from vfife.simulation.simulate import prepare
from vfife.solvers.arguments import RunArguments
from vfife.solvers.ensemble import advance, placed

MODELS = (
    "four_bar_ideal", "six_bar_press", "quick_return", "jansen_leg", "four_bar", "four_bar_case_b",
    "four_bar_case_c", "slider_crank_loose_guide", "compressor",
)  # fmt: skip
STEPS, MEMBERS = 40_000, 32  # of a member, about; of a stream


def members(mechanism: Mechanism, steps: int) -> list[Any]:
    """Equal members of so many steps at the automatic step."""
    size = prepare(mechanism, RunArguments(turns=1.0, companions=0)).assembly.choice.step
    turns = max(1, round(steps * size / (turn_of(mechanism) or 1.0)))
    return [placed(mechanism, size, turns, 20) for _ in range(MEMBERS)]


def times(every: list[Any], repeats: int) -> dict[int, list[float]]:
    """Processor time (s) of all members on one thread, by the number of lanes, in alternation."""
    found: dict[int, list[float]] = {4: [], 8: []}
    for repeat in range(repeats + 1):
        for lanes, own in found.items():
            began = time.process_time()
            advance(every, lanes=lanes, workers=1)
            own += [time.process_time() - began] if repeat else []  # the first one compiles
    return found


def measure(options: Options) -> Part:
    """Medians of quotients of pairs; above 1 where eight lanes are faster."""
    part = Part()
    if widest() < 8:
        part.notes.append("lanes: left out; this processor has no registers of eight numbers")
        return part
    rows = []
    for name in MODELS:
        every = members(load_model(EXAMPLES / f"{name}.toml"), STEPS // 4 if options.quick else STEPS)
        found, contacts = times(every, 2 if options.quick else 5), len(every[0].topology.contact_bearing)
        gain = statistics.median(four / eight for four, eight in zip(found[4], found[8], strict=True))
        each = [1e9 * min(found[lanes]) / (MEMBERS * every[0].choice.steps) for lanes in (4, 8)]
        part.measured[name] = {
            "contacts": contacts,
            "elements": len(every[0].topology.frame_nodes),
            "gain": gain,
            "ns": each,
        }
        rows.append((name, contacts, *(f"{one:.1f}" for one in each), f"{gain:.2f}", stream_lanes(contacts)))
    free = [one["gain"] for one in part.measured.values() if not one["contacts"]]
    part.ratios["lanes.least_gain_of_eight_without_contact"] = min(free)
    heads = ("model", "contacts", "four lanes", "eight lanes", "gain", "lanes of a stream")
    part.tables.append(table("members of streams: ns of processor time a step and member", *heads, rows=rows))
    return part
