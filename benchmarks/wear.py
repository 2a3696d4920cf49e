"""What wear costs in a step: keeping it, and meeting worn surfaces, relative to the same step without."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

import numpy as np
from measure import EXAMPLES, Options, Part, interleaved, table

from vfife import load_model
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner
from vfife.compiler.trace.straight_line import trace
from vfife.joints import Wear
from vfife.laws import Ambrosio
from vfife.solvers.record import recorded_rows

LANES = (1, 4)
MODELS = {"case_c": "four_bar_case_c", "loose_pin": "slider_crank_loose_pin"}
PROFILE = (1e-6, *(1e-6 / k for k in range(2, 16)))  # m, eight harmonics
KEPT, WORN = (
    Wear(bearing=1e-15, journal=1e-16),
    Wear(bearing=1e-15, bearing_profile=PROFILE, journal_profile=PROFILE),
)
CASES: dict[str, Wear | None] = {"none": None, "kept": KEPT, "worn": WORN}


def stepping(model: str, wear: Wear | None, lanes: int, steps: int) -> tuple[Callable[[], float], int]:
    """Runs so many steps of the generated loop, and the operations of its lean step; ns per step and
    simulation. All joints rub.
    """
    m = load_model(EXAMPLES / f"{model}.toml")
    rub = Ambrosio(coefficient=0.1, v0=1e-4, v1=1e-2)
    m.joints.update(
        {name: dataclasses.replace(joint, wear=wear, friction=rub) for name, joint in m.contacts.items()}
    )
    a = assemble(m, 1e-6, duration=1e-2, force_step=True)
    states, tables = np.repeat(a.state[:, None], lanes, axis=1), np.repeat(a.tables[None, :], lanes, axis=0)
    runner = Runner(a.topology, states, tables, "generated", recorded_rows(a))
    runner.advance(10, 1)

    def run() -> float:
        began = time.perf_counter()
        runner.advance(steps, 1)
        return 1e9 * (time.perf_counter() - began) / (steps * lanes)

    return run, len(trace(a.topology).operations)


def measure(options: Options) -> Part:
    """All in one run, in turn, so that what slows the machine slows all alike."""
    part = Part()
    steps, rounds = 4000, 30 if options.quick else 200
    made = {
        (name, case, lanes): stepping(file, wear, lanes, steps)
        for name, file in MODELS.items()
        for case, wear in CASES.items()
        for lanes in LANES
    }
    best = interleaved(rounds, {" ".join(map(str, key)): run for key, (run, _) in made.items()})
    rows = []
    for name in MODELS:
        for case in CASES:
            own = [best[f"{name} {case} {lanes}"] for lanes in LANES]
            over = [value / best[f"{name} none {lanes}"] for value, lanes in zip(own, LANES, strict=True)]
            rows.append((f"{name}, {case}", float(made[name, case, 1][1]), own[0], over[0], own[1], over[1]))
            if case != "none":
                part.ratios |= {
                    f"wear.{case}_{name}_{lanes}_lane{'s' * (lanes > 1)}": ratio
                    for lanes, ratio in zip(LANES, over, strict=True)
                }
    part.tables.append(
        table(
            "A step of joints that wear",
            "model",
            "operations",
            "ns, 1 lane",
            "ratio",
            "ns, 4 lanes",
            "ratio",
            rows=rows,
        )
    )
    part.measured = {"ns_per_step": best}
    return part
