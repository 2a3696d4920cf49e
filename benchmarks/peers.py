"""Wall time of a crank revolution beside the programs of others: the four-bar with rigid links at equal
accuracy.

Cases a, b and c of peers/common.py: ideal joints, one clearance joint, three. Everybody runs at the largest
step of the grid that, with every smaller one, keeps both maxima within 1 % (a, b) or 2 % (c) of the
reference. Compilation and the building of the model are left out for everybody.
"""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np
from candidates import CANDIDATES, FINE, GRID, REFERENCE, STRICT, TOLERANCE, Candidate
from environments import Missing, run
from measure import EXAMPLES, Options, Part, table

import vfife
from vfife.assembly.assemble import assemble
from vfife.solvers.transient import run as advance

TURN = 0.04
MODELS = {"a": "four_bar_ideal.toml", "b": "four_bar_case_b.toml", "c": "four_bar_case_c.toml"}
LOOPS = ("generated", "data-driven")
DIVERGED = {"ms": inf, "err_alpha": inf, "err_force": inf, "refused_by_default": 1.0}


class Case:
    """vfife's run of a case: two revolutions, maxima of the second."""

    def __init__(self, case: str) -> None:
        self.case, self.mechanism = case, vfife.load_model(EXAMPLES / MODELS[case])
        self.assemblies: dict[float, Any] = {}
        for loop in LOOPS:  # compile
            self.run(GRID[case][0], loop)

    def run(self, step: float, loop: str) -> dict[str, float]:
        """Wall time of a revolution (ms) and the errors of both maxima."""
        if step not in self.assemblies:
            self.assemblies[step] = assemble(self.mechanism, step, turns=2, outputs=20, force_step=True)
        assembly = self.assemblies[step]
        record = advance(assembly, loop=loop)  # type: ignore[arg-type]
        if record.status != "complete":  # no second revolution, hence no maximum of it
            return dict(DIVERGED)
        late = record.steps * assembly.choice.step > TURN * (1 + 1e-9)
        alpha = record.block("body_alpha_max")[late, assembly.bodies["follower"].row].max()
        joint = "contact" if "C" in assembly.contacts else "joint"
        column = (assembly.contacts if joint == "contact" else assembly.ideals).index("C")
        force = np.sqrt(record.block(f"{joint}_force_squared_max")[late, column].max())
        wanted = REFERENCE[self.case]
        return {
            "ms": 1e3 * record.wall / (assembly.choice.steps * assembly.choice.step / TURN),
            "err_alpha": float(alpha / wanted[0] - 1),
            "err_force": float(force / wanted[1] - 1),
            "refused_by_default": float(step > 0.9 * assembly.choice.stable),
        }

    def best(self, step: float, loop: str, times: int) -> dict[str, float]:
        """The quickest of several runs."""
        return min((self.run(step, loop) for _ in range(times)), key=lambda found: found["ms"])

    def largest_good_step(self, grid: tuple[float, ...]) -> tuple[float, list[dict[str, float]]]:
        """Largest step of a grid from which on every smaller one is right; the errors of all."""
        scan = [{"step": step, **self.run(step, "generated")} for step in grid]
        good = grid[-1]
        for row in reversed(scan):
            error = max(abs(row["err_alpha"]), abs(row["err_force"]))
            if not error <= TOLERANCE[self.case] or row["refused_by_default"]:
                break
            good = row["step"]
        return good, scan


def peer(candidate: Candidate, case: str, repeat: int) -> dict[str, Any]:
    """What a peer's script measured, or why it did not."""
    try:
        found = run(
            candidate.name, candidate.script, "--case", case, "--repeat", str(repeat), *candidate.command
        )
    except Missing as error:
        return {"missing": str(error)}
    if not all(
        isinstance(found.get(name), float) and isfinite(found[name])
        for name in ("err_alpha", "err_force", "wall_per_rev_s")
    ):
        return {
            "missing": (
                f"{candidate.name} diverged at a step of {candidate.step:g}, so it has no maximum and no"
                " ratio is taken"
            )
        }
    return {"step": candidate.step, "ms": 1e3 * found["wall_per_rev_s"], **found}


def fine(case: Case, repeat: int, part: Part, compare: bool) -> list[tuple[Any, ...]]:
    """The same search on a much finer grid: rows of the table, and the ratio there."""
    tolerance = TOLERANCE[case.case]
    step, scan = case.largest_good_step(FINE[case.case])
    found = case.best(step, "generated", 4 * repeat)
    wrong = [
        entry["step"]
        for entry in scan
        if not max(abs(entry["err_alpha"]), abs(entry["err_force"])) <= tolerance
    ]
    part.measured[f"case_{case.case}_fine"] = {
        "vfife_step": step,
        "vfife": found,
        "steps": len(scan),
        "wrong": wrong,
    }
    rows = [row(f"{case.case}, fine grid  vfife, generated", step, found)]
    rival = peer(STRICT[case.case], case.case, repeat) if compare else {"missing": ""}
    if compare and "missing" in rival:
        part.notes.append(f"peers: case {case.case}, fine grid: {rival['missing']}")
    if "missing" not in rival:
        part.measured[f"case_{case.case}_fine"]["mujoco"] = rival
        part.ratios[f"peers.case_{case.case}_fine_grid"] = rival["ms"] / found["ms"]
        rows.append(
            row(f"{case.case}, fine grid  {rival['peer']}, {rival['route']}", STRICT[case.case].step, rival)
        )
    return rows


def row(label: str, step: float, found: dict[str, Any]) -> tuple[Any, ...]:
    """A line of the table."""
    if not isfinite(found["ms"]):
        return label, f"{step:g}", "diverged", None, None
    return label, f"{step:g}", found["ms"], 100 * found["err_alpha"], 100 * found["err_force"]


def measure(options: Options) -> Part:
    """All cases; vfife before and after the others, the better of the two."""
    part, rows = Part(), []
    repeat = 2 if options.quick else 5
    for name in MODELS:
        case = Case(name)
        step, scan = case.largest_good_step(GRID[name])
        before = {loop: case.best(step, loop, 4 * repeat) for loop in LOOPS}
        chosen = [c for c in CANDIDATES[name] if options.peers and (c.decides or not options.quick)]
        others = {c.name: peer(c, name, repeat) for c in chosen}
        best = {
            loop: min(before[loop], case.best(step, loop, 4 * repeat), key=lambda f: f["ms"])
            for loop in LOOPS
        }
        part.measured[f"case_{name}"] = {"vfife_step": step, "vfife": best, "vfife_scan": scan, **others}
        rows += [row(f"{name}  vfife, {loop}", step, found) for loop, found in best.items()]
        rivals = []
        for candidate in chosen:
            found = others[candidate.name]
            if "missing" in found:
                part.notes.append(f"peers: case {name}: {found['missing']}")
                continue
            rows.append(row(f"{name}  {found['peer']}, {found['route']}", candidate.step, found))
            rivals += [found] if candidate.decides else []
        if rivals:
            rival = min(rivals, key=lambda found: found["ms"])
            equal = case.best(rival["step"], "generated", 2 * repeat)
            part.measured[f"case_{name}"]["vfife_at_equal_step"] = equal
            compared = {f"peers.case_{name}": best["generated"], f"peers.case_{name}_equal_step": equal}
            part.ratios |= {
                key: rival["ms"] / ours["ms"] for key, ours in compared.items() if isfinite(ours["ms"])
            }
            part.notes += [
                f"{key}: vfife diverged, so there is no ratio"
                for key, ours in compared.items()
                if not isfinite(ours["ms"])
            ]
        if name in FINE:
            rows += fine(case, repeat, part, options.peers)
    if not options.peers:
        part.notes.append("peers: the programs of others were left out (--no-peers), so there is no ratio")
    title = "wall ms per crank revolution at equal accuracy; errors (%) of the largest acceleration and force"
    part.tables.append(table(title, "case, program", "step (s)", "ms", "acceleration", "force", rows=rows))
    return part
