"""The lost Table 2: which parameters give Table 3 back, the whole set of them, and what they leave open in
the lost Table 4.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vfife.report.document import Table

from . import search
from .contents import Chart, Item, Line, Panel, Style, Verdict
from .context import described
from .influence import STEP
from .mechanisms import Parameters
from .search import GOAL, TABLE_3, TARGET, Search, as_numbers, misfit, robust, table_3

if TYPE_CHECKING:
    from .context import Context

STORED = 24  # sets that fit, as many as are stored of each structure
CANDIDATES = 24  # best points of each structure that are run again with other steps
STEPS = (1.25e-6, 1e-6, 5e-7, 2.5e-7)  # s
SHOWN = (
    ("axial_length", 1e3, "axial length (mm)"),
    ("restitution", 1.0, "restitution c_e (1)"),
    ("v0", 1.0, "v0 (m/s)"),
    ("v1", 1.0, "v1 (m/s)"),
)


def outcome(
    searches: Sequence[Search], seed: int, budget: float, seconds: float | None = None
) -> dict[str, Any]:
    """Return the results of a search as plain numbers: the best set at the worst of several steps, the sets
    that fit, and the best of each structure.

    A set with stiff bars is replaced by its limit with rigid bars, if that fits too.
    """
    from vfife.results.provenance import versions

    structures, finalists = [], []
    fits: list[dict[str, Any]] = []
    for finished in searches:
        points, numbers, misfits = finished.all_points()
        finalists += [
            limit(points[k]) for k in range(min(CANDIDATES, len(points))) if misfits[k] <= 1.5 * GOAL
        ]
        inside = int((misfits <= GOAL).sum())
        fits += table_3_matches([limit(points[k]) for k in distant_points(points[:inside], STORED)])
        structures.append({
            "structure": finished.structure.words, "points": finished.count,
            "generations": finished.generations,
            "misfit": float(misfits[0]),
            "within_goal": inside, "table_3": numbers[0].tolist(), "parameters": as_numbers(points[0]),
        })  # fmt: skip
    if not finalists:  # nothing comes near: the best of all stands for what can be reached
        finalists = [min(searches, key=lambda search: search.best).all_points()[0][0]]
    worst = robust(finalists, STEPS)
    at = int(np.argmin(worst))
    best = finalists[at]
    numbers = table_3([best])[0][0]
    return {
        "provenance": {
            "command": f"vfife paper infer --budget {budget:g} --seed {seed}", "vfife": versions()["vfife"],
            "seconds": round(budget if seconds is None else seconds),
            "points": sum(s.count for s in searches), "fits": sum(s["within_goal"] for s in structures),
            "goal": GOAL,
            "step": STEP, "steps_of_the_best": list(STEPS),
        },
        "best": {"parameters": as_numbers(best), "table_3": numbers.tolist(),
        "misfit": float(np.abs(numbers - TARGET).max()),
                 "misfit_at_the_worst_step": float(worst[at])},
        "structures": structures,
        "fits": fits,
    }  # fmt: skip


def limit(p: Parameters) -> Parameters:
    """Rigid bars instead of stiff ones, which ring after the start, so that a step moves what they do at low
    speeds.
    """
    return dataclasses.replace(p, link="rigid bars") if p.link == "stiff bars" else p


def table_3_matches(points: Sequence[Parameters]) -> list[dict[str, Any]]:
    """Return the sets among ``points`` that reproduce Table 3 within the goal, as plain numbers."""
    if not points:
        return []
    numbers, sound = table_3(points)
    misfits = misfit(numbers, sound)
    return [
        {"parameters": as_numbers(p), "table_3": row.tolist(), "misfit": float(value)}
        for p, row, value in zip(points, numbers, misfits, strict=True)
        if value <= GOAL
    ]


def distant_points(points: Sequence[Parameters], count: int) -> list[int]:
    """Choose the first point, and then repeatedly the point farthest from all chosen ones. They show the
    extent of a set that a search has sampled in clusters.
    """
    if not points:
        return []
    rows = [
        [
            math.log(p.axial_length),
            p.contact.restitution,  # type: ignore[attr-defined]
            0.5 * math.log(p.v0),
            0.5 * math.log(p.v1),
            p.crank_angle,
        ]
        for p in points
    ]
    at = np.array(rows)
    chosen = [0]
    distances = np.linalg.norm(at - at[0], axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(distances)))
        distances = np.minimum(distances, np.linalg.norm(at - at[chosen[-1]], axis=1))
    return sorted(chosen)


def infer(context: Context) -> Item:
    """Report the search for the lost parameters, repeated if the context has a budget for it, else
    as stored.
    """
    if context.budget > 0.0:
        began = time.monotonic()
        searches = search.run(context.budget, context.seed, context.tell)
        seconds = time.monotonic() - began
        context.tell("the best points with other steps")
        context.fit = outcome(searches, context.seed, context.budget, seconds)
        context.__dict__.pop("parameters", None)
    fit = context.fit
    values, sound = table_3([context.parameters])
    current_misfit = float(misfit(values, sound)[0])
    text = [
        (
            "Table 2, with the parameters of contact and friction, is lost; Table 3 has six numbers that"
            " follow from it. The search moves axial length, restitution, the two friction speeds and, by"
            " structure, start angle and bearing radius within wide limits, and judges a set by its worst"
            " deviation from the six. A set that loses contact or does not settle is out."
        ),
        (
            f"{fit['provenance']['command']}: {fit['provenance']['points']} sets tried,"
            f" {fit['provenance']['fits']} within {GOAL:g} points."
        ),
        (
            "Stiff bars, with which the search runs, ring after the start; what it finds with them is kept as"
            " its limit, rigid bars, where those fit, too. On bars a friction moment turns the pin's particle"
            " alone, on rigid bars the link: sets with moments rarely survive that."
        ),
        (
            "Six numbers do not determine the unknowns: every set in the pictures gives Table 3. None of them"
            " is known to be the paper's."
        ),
    ]
    charts, tables = [numbers_chart(fit), sets_chart(fit)], [structures_table(fit), ranges_table(fit)]
    data = {key: fit[key] for key in ("provenance", "best", "structures")} | {
        "best_again": values[0].tolist()
    }
    return Item(
        "infer",
        "The lost Table 2, inferred from Table 3",
        text,
        described(context.parameters),
        charts,
        tables,
        verdicts(fit, current_misfit),
        data,
    )


def verdicts(fit: dict[str, Any], current_misfit: float) -> list[Verdict]:
    """How well the stated model can give Table 3."""
    best = fit["best"]
    steps = ", ".join(f"{1e6 * s:g}" for s in STEPS)
    rods = [s for s in fit["structures"] if s["structure"].startswith("uniform rods")]
    rod_misfit = min((s["misfit"] for s in rods), default=math.nan)
    least_misfit = min(
        (s["misfit"] for s in fit["structures"] if "above" in s["structure"]), default=math.nan
    )
    verdicts = [
        Verdict(f"One set gives all six numbers within {GOAL:g} points", current_misfit <= GOAL,
                f"largest deviation {current_misfit:.2f}; {best['misfit_at_the_worst_step']:.2f} at the worst"
                f" of the steps {steps} µs"),
    ]  # fmt: skip
    if rods:
        verdicts.append(
            Verdict(
                "Rigid uniform rods can give them, too",
                rod_misfit <= GOAL,
                f"best of {sum(s['points'] for s in rods)} sets is {rod_misfit:.1f} points off",
            )
        )
    if math.isfinite(least_misfit):
        verdicts.append(
            Verdict(
                "Joint 2 above the line of the pivots can give them, too",
                least_misfit <= GOAL,
                f"best set is {least_misfit:.1f} points off",
            )
        )
    return verdicts


def numbers_chart(fit: dict[str, Any]) -> Chart:
    """Plot the six numbers of Table 3: of the paper, of the best set, and the range of all sets that fit."""
    panels = []
    tables = np.array([entry["table_3"] for entry in fit["fits"]]).reshape(-1, 6)
    sizes = np.array([0.1, 0.2, 0.5])
    for j, kind in enumerate(("LIP(F)", "LIP(a)")):
        columns = slice(3 * j, 3 * j + 3)
        lines = [
            Line(sizes, row[columns], "sets that fit" if k == 0 else "", "faint")
            for k, row in enumerate(tables)
        ]
        lines += [
            Line(sizes, fit["best"]["table_3"][columns], "best set", "main"),
            Line(sizes, TABLE_3[j], "paper", "paper"),
        ]
        panels.append(Panel(kind, "clearance (mm)", f"{kind} (%)", lines))
    return Chart("fit", "Table 3: the paper, the best set, and every stored set within the goal", panels, 2)


def sets_chart(fit: dict[str, Any]) -> Chart:
    """Where the sets that fit lie."""
    names: dict[str, list[dict[str, Any]]] = {}
    for entry in fit["fits"]:
        names.setdefault(structure_of(entry["parameters"]), []).append(entry["parameters"])
    styles: tuple[Style, ...] = ("main", "second", "third", "fourth", "fifth")
    panels = []
    for (x, fx, label_x), (y, fy, label_y) in ((SHOWN[0], SHOWN[1]), (SHOWN[2], SHOWN[3])):
        lines = [
            Line([fx * p[x] for p in sets], [fy * p[y] for p in sets], name, styles[k % len(styles)], True)
            for k, (name, sets) in enumerate(names.items())
        ]
        panels.append(Panel("", label_x, label_y, lines, logarithmic="xy" if x == "v0" else ""))
    return Chart("sets", "Sets that give Table 3 within the goal", panels, 2)


def structure_of(p: dict[str, Any]) -> str:
    """Name the structure of a set in words."""
    words = [p["link"], *(["friction moment"] if p["friction_moment"] != "off" else [])]
    return ", ".join(words)


def structures_table(fit: dict[str, Any]) -> Table:
    """Tabulate the best set of each structure."""
    rows = [
        [
            s["structure"],
            str(s["points"]),
            str(s["within_goal"]),
            f"{s['misfit']:.2f}",
            ", ".join(f"{v:.1f}" for v in s["table_3"]),
        ]
        for s in sorted(fit["structures"], key=lambda s: float(s["misfit"]))
    ]
    caption = f"Structures: the paper has {', '.join(f'{v:g}' for v in TARGET)}"
    return Table(
        [
            "structure",
            "sets tried",
            f"within {GOAL:g}",
            "best misfit (points)",
            "LIP(F), LIP(a) at 0.1, 0.2, 0.5 mm",
        ],
        rows,
        caption,
    )


def ranges_table(fit: dict[str, Any]) -> Table:
    """Ranges of the unknowns over the sets that fit."""
    sets = [entry["parameters"] for entry in fit["fits"]]
    rows = []
    for name, factor, label in SHOWN:
        values = [factor * p[name] for p in sets]
        best_value = factor * fit["best"]["parameters"][name]
        rows.append(
            [label, f"{best_value:.4g}", f"{min(values):.4g} to {max(values):.4g}" if values else "none"]
        )
    caption = f"Unknowns over the {len(sets)} stored sets within {GOAL:g} points"
    return Table(["unknown", "best set", "range"], rows, caption)
