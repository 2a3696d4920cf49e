"""What impacts cost an ensemble: case c with all its events, in as many lanes as a register holds, over the
lean step alone.
"""

from __future__ import annotations

import dataclasses
import time

import numpy as np
from measure import EXAMPLES, Options, Part, table

from vfife import load_model
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.native import widest
from vfife.compiler.runtime.runner import Runner

STEP, CHUNK = 1e-6, 100
TURN = 0.04


def runner(lanes: int) -> Runner:
    """Case c, each lane with a clearance of its own, so that impacts fall into different steps."""
    base = load_model(EXAMPLES / "four_bar_case_c.toml")
    assemblies = []
    for lane in range(lanes):
        joints = {
            name: dataclasses.replace(joint, clearance=joint.clearance * (1.0 + 0.1 * lane))
            for name, joint in base.clearances.items()
        }
        mechanism = dataclasses.replace(base, joints={**base.joints, **joints})
        assemblies.append(assemble(mechanism, STEP, turns=2, force_step=True))
    first = assemblies[0]
    states, tables = (
        np.stack([getattr(a, name) for a in assemblies], axis=k) for k, name in ((1, "state"), (0, "tables"))
    )
    return Runner(
        first.topology, states, tables, "generated", np.array(first.layout.of("state"), dtype=np.uint32)
    )


def chunks(lanes: int) -> tuple[np.ndarray, np.ndarray]:
    """Time (s) of each chunk of steps, and the contacts that began in it in any lane."""
    model = runner(lanes)
    model.advance(1, 1)
    rows, times, begun, before = model.layout["contact_onsets"], [], [], 0.0
    for _ in range(round(2 * TURN / STEP) // CHUNK):
        at = time.perf_counter()
        model.advance(CHUNK, 1)
        times.append(time.perf_counter() - at)
        now = float(model.states[rows].sum())
        begun.append(now - before)
        before = now
    return np.array(times), np.array(begun)


def measure(options: Options) -> Part:
    """Every chunk the best of several runs; the lean step is that of the chunks in which nothing begins."""
    part, lanes = Part(), widest()
    some = [chunks(lanes) for _ in range(3 if options.quick else 10)]
    times, begun = np.min([found[0] for found in some], axis=0), some[0][1]
    lean = float(np.median(times[begun == 0]))
    whole = float(times.mean())
    part.ratios["events.all_over_lean"] = whole / lean
    each = 1e9 / CHUNK / lanes
    part.measured = {
        "lanes": lanes,
        "contacts_begun": float(begun.sum()),
        "lean_ns": lean * each,
        "all_ns": whole * each,
    }
    rows = [("chunks in which nothing begins", lean * each), ("all, events included", whole * each)]
    title = f"case c in {lanes} lanes, {begun.sum():.0f} contacts begin: ns per step and simulation"
    part.tables.append(table(title, "steps", "ns", rows=rows))
    return part
