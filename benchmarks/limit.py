"""How near vfife's loops are to a program written by hand for one mechanism, limit/four_bar_limit.c: time,
motion.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from limit_model import FOLLOWER_PIN, runner
from measure import HERE, Options, Part, seconds, table

from vfife.compiler.runtime.native import widest

SOURCE = HERE / "limit" / "four_bar_limit.c"
FLAGS = ["-O3", "-march=native", "-ffast-math"]
SAME_BITS = [
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-math-errno",
]  # no fused products, no sums in another order: vfife's own terms
VARIANTS = {
    # as it was given: damping and friction at half-step velocities, onset speed at the end of a step
    "limit": FLAGS,
    "located": [*FLAGS, "-DLOCATED"],  # vfife's step: onset located, damping and friction in closed form
    "ledger": [*FLAGS, "-DLOCATED", "-DLEDGER"],  # and the works, powers and extremes that vfife keeps
    "exact": [
        *SAME_BITS,
        "-DLOCATED",
        "-DLEDGER",
    ],  # and with operations as they are written, as for the same bits everywhere
}
WIDE = (1, 4, 8) if widest() >= 8 else (1, 4)
LOOPS = {f"generated_{lanes}_lane{'s' * (lanes > 1)}": ("generated", lanes) for lanes in WIDE} | {
    "data_driven": ("data-driven", 1)
}
LINE = re.compile(r"simulation (?P<ns>\S+).* N  onsets (?P<onsets>\S+).*pin (?P<x>\S+) (?P<y>\S+)")
COMPILER = os.environ.get("CC", "gcc")


def build(folder: Path) -> dict[str, Path]:
    """Compiles every variant for one lane and for several."""
    return {f"{name}_{lanes}": compiled(folder, name, lanes) for name in VARIANTS for lanes in WIDE}


def compiled(folder: Path, variant: str, lanes: int) -> Path:
    """Compiles a variant."""
    out = folder / f"{variant}_{lanes}"
    options = [*VARIANTS[variant], f"-DLANES={lanes}"]
    subprocess.run([COMPILER, *options, str(SOURCE), "-o", str(out), "-lm"], check=True)
    return out


def ask(program: Path, steps: int) -> dict[str, float]:
    """What a program prints after a number of steps."""
    text = subprocess.run([str(program), str(steps)], check=True, capture_output=True, text=True).stdout
    found = LINE.search(text)
    if found is None:
        raise RuntimeError(f"{program.name} printed {text!r}")
    return {name: float(value) for name, value in found.groupdict().items()}


def time_loops(steps: int) -> dict[str, float]:
    """ns per step and simulation of vfife's loops from the start, the best of three, in this process."""
    best = {}
    for name, (loop, lanes) in LOOPS.items():
        runner(loop, lanes).advance(10, 1)  # compile
        models = [runner(loop, lanes) for _ in range(3)]
        took = min(seconds(lambda model=model: model.advance(steps, 1)) for model in models)
        best[name] = 1e9 * took / steps / lanes
    return best


def ask_loops(steps: int) -> dict[str, float]:
    """The same in a process of its own, as the C program's: where code and data come to lie is drawn anew."""
    command = [sys.executable, str(Path(__file__).resolve()), str(steps)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return result


def rounds(programs: dict[str, Path], steps: int, count: int) -> dict[str, float]:
    """Best ns per step and simulation of everything, asked in turn."""
    best: dict[str, float] = {}
    for _ in range(count):
        found = ask_loops(steps)
        for name, program in programs.items():
            found[name] = min(ask(program, steps)["ns"] for _ in range(3))
        best = {name: min(best.get(name, value), value) for name, value in found.items()}
    return best


def position(steps: int) -> tuple[float, float, float]:
    """Follower pin (m) at t = steps * dt and the onsets so far; vfife's step n begins with the
    drift to t_n.
    """
    model = runner("generated")
    model.advance(steps + 1, 1)
    x, y = (
        float(model.states[model.layout.row(name, FOLLOWER_PIN), 0]) for name in ("particle_x", "particle_y")
    )
    return x, y, float(model.states[model.layout["contact_onsets"], 0].sum())


def agreement(programs: dict[str, Path], steps: tuple[int, ...]) -> list[dict[str, float]]:
    """Distance (m) of the follower pin in the C program and in vfife."""
    rows = []
    for n in steps:
        x, y, onsets = position(n)
        row: dict[str, float] = {"steps": n, "onsets": onsets, "x": x, "y": y}
        for name in ("limit", "located"):
            other = ask(programs[f"{name}_1"], n)
            row[name] = ((other["x"] - x) ** 2 + (other["y"] - y) ** 2) ** 0.5
            if name == "located":
                row["located_onsets"] = other["onsets"]
        rows.append(row)
    return rows


def measure(options: Options) -> Part:
    """Times of all variants in one run, and how far their motions are apart."""
    if shutil.which(COMPILER) is None:
        return Part(
            notes=[f"limit: left out, no C compiler here ({COMPILER} was looked for; CC names another)"]
        )
    part = Part()
    steps = 200_000 if options.quick else 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        programs = build(Path(folder))
        best = rounds(programs, steps, 2 if options.quick else 8)
        moved = agreement(programs, (2000, 20_000))
    part.measured = {"ns_per_step_and_simulation": best, "steps": steps, "agreement": moved, "flags": FLAGS}
    rows: list[tuple[Any, ...]] = []
    for name, (_, lanes) in LOOPS.items():
        against = {variant: best[name] / best[f"{variant}_{lanes}"] for variant in VARIANTS}
        for variant, ratio in against.items():
            part.ratios[f"limit.{name}" if variant == "limit" else f"limit.{variant}_{name}"] = ratio
        rows.append((name.replace("_", " "), best[name], *against.values()))
    for variant in VARIANTS:
        all_widths = ", ".join(f"{best[f'{variant}_{lanes}']:.1f}" for lanes in WIDE)
        rows.append((f"C, {variant}: {', '.join(map(str, WIDE))} lanes", all_widths, *[None] * len(VARIANTS)))
    title = (
        "ns per step and simulation; ratio to the C program as given, with vfife's step, with its ledger too,"
        " and with operations as written"
    )
    part.tables.append(table(title, "loop", "ns", "given", "located", "ledger", "exact", rows=rows))
    rows = [
        (str(r["steps"]), r["limit"], r["located"], f"{r['onsets']:.0f}, {r['located_onsets']:.0f}")
        for r in moved
    ]
    columns = ("after steps", "C as given", "C located", "onsets vfife, C")
    part.tables.append(table("distance of the follower pin from vfife's (m)", *columns, rows=rows))
    return part


if __name__ == "__main__":
    print(json.dumps(time_loops(int(sys.argv[1]))))
