"""Members of a study of case c: steps and members per second, of a core and of all, beside one lane, the C
program's lanes and a pool of peers.
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from candidates import STRICT
from environments import Missing, run
from limit import COMPILER, ask, build
from measure import EXAMPLES, Options, Part, interleaved, seconds, table

from vfife import load_model
from vfife.compiler.runtime.native import stream_lanes
from vfife.compiler.runtime.runner import Runner
from vfife.modelfile.parameter import Parameter
from vfife.solvers.record import recorded_rows
from vfife.studies.engine.cases import Cases, run_cases
from vfife.studies.spec.plan import CaseSpec

MODEL = EXAMPLES / "four_bar_case_c.toml"
WANTED = ("C.force.max", "C.force.lip", "follower.angular_acceleration.max", "C.impacts")
TURNS = 4
ASSEMBLED = 1000
# Models and the length in which their cases differ.
LENGTHS = {
    "four_bar": ("four_bar_case_b.toml", "body.coupler.length"),
    "compressor": ("compressor.toml", "body.rod.length"),
}
LENGTH_LIMIT = 5e-4  # s of the processor that assembling such a case shall take in a batch
CORES = os.cpu_count() or 1
LANES = stream_lanes(3)  # case c has three contacts


def clearances(count: int) -> list[dict[str, float | str]]:
    """Members whose three clearances are those of a Latin hypercube's strata."""
    draw = np.random.default_rng(1)
    found = [1e-4 + 2e-4 * (draw.permutation(count) + 0.5) / count for _ in "BCD"]
    return [
        {f"joint.{name}.clearance": float(column[k]) for name, column in zip("BCD", found, strict=True)}
        for k in range(count)
    ]


def grid() -> list[dict[str, float | str]]:
    """Twenty clearances by ten speeds."""
    sizes, speeds = np.linspace(5e-5, 5e-4, 20), np.linspace(105.0, 210.0, 10)
    return [
        {**{f"joint.{name}.clearance": float(c) for name in "BCD"}, "driver.crank.speed": float(w)}
        for w in speeds
        for c in sizes
    ]


class Study:
    """Members of case c at their automatic steps."""

    def __init__(self, numbers: list[dict[str, float | str]], turns: int) -> None:
        self.base, self.numbers, self.turns, self.steps = load_model(MODEL), numbers, turns, 0

    def members(self, workers: int) -> float:
        """Wall time (s) of all of them."""
        began = time.perf_counter()
        found = [
            one
            for _, one in run_cases(self.base, self.numbers, CaseSpec(WANTED, self.turns), workers=workers)
        ]
        self.steps = sum(one.steps for one in found)
        if len(found) != len(self.numbers) or any(one.status != "complete" for one in found):
            raise RuntimeError("a member is not complete")
        return time.perf_counter() - began

    def one_lane(self) -> float:
        """Wall time (s) a step of the loop with one lane and nothing beside it, over the turns of the first
        member.
        """
        assembly: Any = Cases(self.base, CaseSpec(WANTED, self.turns)).case(0, self.numbers[0]).assembly  # type: ignore[union-attr]
        runner = Runner(
            assembly.topology,
            assembly.state[:, None],
            assembly.tables[None],
            "generated",
            recorded_rows(assembly),
        )
        runner.advance(1, 1)
        return (
            seconds(lambda: runner.advance(assembly.choice.outputs_every, assembly.choice.outputs))
            / assembly.choice.steps
        )


def assembly_time(numbers: list[dict[str, float | str]]) -> float:
    """Time of the processor (s) a member of making what goes into a lane, when the first one is there."""
    made = Cases(load_model(MODEL), CaseSpec(WANTED, 1)).prepare_each([numbers[0], *numbers])
    next(made)
    began = time.process_time()
    deque(made, maxlen=0)
    return (time.process_time() - began) / len(numbers)


class Lengths:
    """Assembly of cases that differ in a length, beside what a step of their loop takes with one lane."""

    def __init__(self, name: str, path: str, count: int) -> None:
        self.base = load_model(EXAMPLES / name)
        self.parameter, self.spec = Parameter(self.base, path), CaseSpec(("*",), 1)
        length, shares = self.parameter.get(), 0.01 * np.random.default_rng(1).uniform(-1.0, 1.0, count)
        self.numbers: list[dict[str, float | str]] = [{path: length * (1.0 + share)} for share in shares]
        assembly: Any = Cases(self.base, self.spec).case(0, self.numbers[0]).assembly  # type: ignore[union-attr]
        self.choice = assembly.choice
        self.runner = Runner(
            assembly.topology,
            assembly.state[:, None],
            assembly.tables[None],
            "generated",
            recorded_rows(assembly),
        )
        self.runner.advance(1, 1)

    def step(self) -> float:
        """Time of the processor (s) a step."""
        began = time.process_time()
        self.runner.advance(self.choice.outputs_every, self.choice.outputs)
        return (time.process_time() - began) / self.choice.steps

    def batch(self) -> float:
        """Time of the processor (s) a case of a batch, when the first one is there."""
        made = Cases(self.base, self.spec).prepare_each(self.numbers)
        next(made)
        began = time.process_time()
        deque(made, maxlen=0)
        return (time.process_time() - began) / (len(self.numbers) - 1)

    def alone(self) -> float:
        """Time of the processor (s) a case that is assembled by itself."""
        began = time.process_time()
        for numbers in self.numbers[:10]:
            Cases(self.parameter.set(*numbers.values()), self.spec).case(0, {})
        return (time.process_time() - began) / 10


def lengths(part: Part, quick: bool) -> None:
    """Thousands of steps as long as which assembly takes, in a batch and alone."""
    rows: list[tuple[Any, ...]] = []
    for key, (name, path) in LENGTHS.items():
        one = Lengths(name, path, 100 if quick else 530)
        best = interleaved(2 if quick else 5, {"step": one.step, "batch": one.batch, "alone": one.alone})
        part.ratios |= {
            f"study.length_{kind}_{key}": 1e-3 * best[kind] / best["step"] for kind in ("batch", "alone")
        }
        part.ratios[f"study.assembly_length_{key}"] = best["batch"] / LENGTH_LIMIT
        part.measured[f"length_{key}"] = best
        rows.append((key, 1e9 * best["step"], 1e3 * best["batch"], 1e3 * best["alone"]))
    title = "cases that differ in a length: a step with one lane, and assembly"
    part.tables.append(table(title, "model", "ns/step", "ms in a batch", "ms alone", rows=rows))


def pool(part: Part) -> float:
    """Crank revolutions per second of as many processes as there are cores, each the fastest peer's script at
    the largest step that is right.
    """
    rival = STRICT["c"]

    def one(_: int) -> float:
        return float(
            run(rival.name, rival.script, "--case", "c", "--repeat", "3", *rival.command)["wall_per_rev_s"]
        )

    try:
        with ThreadPoolExecutor(CORES) as workers:
            return sum(1.0 / each for each in workers.map(one, range(CORES)))
    except Missing as error:
        part.notes.append(f"study: no pool of peers: {error}")
        return math.nan


def c_lanes(part: Part, steps: int) -> float:
    """ns per step and simulation of the C program with vfife's step and ledger, in as many lanes as members;
    the best of three.
    """
    if shutil.which(COMPILER) is None:
        part.notes.append(f"study: no C compiler here ({COMPILER})")
        return math.nan
    with tempfile.TemporaryDirectory() as folder:
        program = build(Path(folder))[f"ledger_{LANES if LANES >= 4 else 1}"]
        return min(ask(program, steps)["ns"] for _ in range(3))


def measure(options: Options) -> Part:
    """Everything in turns, the best of several."""
    part = Part()
    study, whole = Study(clearances(16 if options.quick else 96), TURNS), Study(grid(), 10)
    study.members(1)  # compile
    two = min(2, CORES)
    runs = {
        "lane": study.one_lane,
        "core": lambda: study.members(1),
        "two": lambda: study.members(two),
        "all": lambda: study.members(CORES),
    }
    best = interleaved(2 if options.quick else 5, runs)
    best["grid"] = min(whole.members(CORES) for _ in range(1 if options.quick else 3))
    best["assembly"] = min(assembly_time(clearances(ASSEMBLED)) for _ in range(3))
    best["c"] = c_lanes(part, 200_000) * 1e-9
    each = best["core"] / study.steps
    part.ratios = {
        f"study.core_over_one_lane_{LANES}_lanes": best["lane"] / each,
        "study.two_cores_over_one": best["core"] / best["two"],
        "study.grid_20_by_10": best["grid"] / 3.0,
        "study.assembly": best["assembly"] / 1e-4,
    }
    part.ratios |= {"study.core_over_c_lanes": each / best["c"]} if math.isfinite(best["c"]) else {}
    turns = len(study.numbers) * TURNS / best["all"]
    peers = pool(part) if options.peers else math.nan
    part.ratios |= {"study.all_over_peer_pool": turns / peers} if math.isfinite(peers) else {}
    part.measured = {
        **best,
        "steps": study.steps,
        "members": len(study.numbers),
        "grid_steps": whole.steps,
        "cores": CORES,
        "peer_turns_per_s": peers,
    }
    count = len(study.numbers)
    rows: list[tuple[Any, ...]] = [
        ("one lane, one core", None, 1e-6 / best["lane"]),
        (f"study, {LANES} lanes, one core", count / best["core"], 1e-6 * study.steps / best["core"]),
        (f"study, {LANES} lanes, {CORES} cores", count / best["all"], 1e-6 * study.steps / best["all"]),
        (
            f"20 clearances by 10 speeds, ten turns, {CORES} cores: {best['grid']:.2f} s",
            200 / best["grid"],
            1e-6 * whole.steps / best["grid"],
        ),
        ("C program's lanes, one core", None, 1e-6 / best["c"]),
        (f"fastest peer, {CORES} processes", peers / TURNS, None),
    ]
    part.tables.append(
        table(
            f"members of {TURNS} turns and million steps a second",
            "what",
            "members/s",
            "M steps/s",
            rows=rows,
        )
    )
    part.notes.append(
        f"study: a member that differs in numbers of play is assembled in {1e3 * best['assembly']:.3f} ms"
    )
    lengths(part, options.quick)
    return part
