"""How long a model waits for its step when nothing is kept: tracing, writing, compiling and loading, in a new
process.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import elastic
import size
from measure import EXAMPLES, Options, Part, table

from vfife import Mechanism, load_model
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime import loops, native
from vfife.compiler.trace.straight_line import trace

LIMITS = {"case_c": 0.4, "four_bar_22": 1.0, "bar_40": 2.0, "frame_200": 10.0}  # s
LANES = (1, 4)


def model(name: str) -> Mechanism:
    """The mechanism of a row."""
    if name == "case_c":
        return load_model(EXAMPLES / "four_bar_case_c.toml")
    if name == "four_bar_22":
        return elastic.four_bar(8)
    return elastic.bar(40) if name == "bar_40" else size.lattice(200)


def taken(name: str, lanes: int) -> dict[str, float]:
    """Seconds, and the lines of the lean step; called where nothing was traced before."""
    topology = assemble(model(name), "auto", duration=1e-2).topology
    native.processor()  # loads LLVM, which every run does
    began = time.perf_counter()
    loops.straight_line(topology, lanes)
    took = time.perf_counter() - began
    return {"seconds": took, "lines": len(trace(topology).operations)}


def ask(name: str, lanes: int) -> dict[str, float]:
    """The same in a process of its own with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        variables = dict(os.environ, VFIFE_CACHE=folder)
        command = [sys.executable, str(Path(__file__).resolve()), name, str(lanes)]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=variables)
    result: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return result


def measure(options: Options) -> Part:
    """The best of several, and how the time grows with the lines."""
    part, rows = Part(), []
    for name, limit in LIMITS.items():
        for lanes in LANES:
            some = [ask(name, lanes) for _ in range(1 if options.quick else 3)]
            best = min(some, key=lambda found: found["seconds"])
            part.measured[f"{name}, {lanes}"] = best
            rows.append(
                (
                    name.replace("_", " "),
                    str(lanes),
                    f"{best['lines']:.0f}",
                    best["seconds"],
                    1e3 * best["seconds"] / best["lines"],
                    limit,
                )
            )
        part.ratios[f"compilation.{name}"] = (
            max(part.measured[f"{name}, {lanes}"]["seconds"] for lanes in LANES) / limit
        )
    part.tables.append(
        table("trace and compilation", "model", "lanes", "lines", "s", "ms a line", "limit", rows=rows)
    )
    return part


if __name__ == "__main__":
    print(json.dumps(taken(sys.argv[1], int(sys.argv[2]))))
