"""The tables of docs/benchmarks.md from latest.json; where the step's text has changed since the measurement,
the page says so.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

LATEST = Path(__file__).resolve().parent / "latest.json"
CASES = {"a": "a: ideal joints", "b": "b: one clearance joint", "c": "c: three clearance joints"}
LIMIT = {
    "limit": "C program as given",
    "located": "C program with vfife's step",
    "ledger": "and with the works and extremes that vfife keeps",
    "exact": "and with every operation as it is written: no fused products, no other order of sums",
    "generated": "vfife, generated loop",
}
ELASTIC = {
    "data_driven": "vfife, data-driven loop, bar of 1000 elements",
    "data_driven_four_bar": "vfife, data-driven loop, four-bar of 22 elements",
    "generated_1_lane_four_bar": "vfife, generated loop, the same",
    "generated_4_lanes_four_bar": "vfife, generated loop, four lanes, the same",
    "generated_8_lanes_four_bar": "vfife, generated loop, eight lanes, the same",
    "generated_4_lanes": "vfife, generated loop, four lanes, bar of 40 elements",
}
COMPILED = {
    "case_c": "four-bar, case c",
    "four_bar_22": "four-bar of 22 elements",
    "bar_40": "bar of 40 elements",
    "frame_200": "frame of 200 elements",
}


def grid(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    head = list(head)
    lines = [head, ["---"] * len(head), *map(list, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def number(value: float | None) -> str:
    """Two or three digits, as they count."""
    return "diverged" if value is None else f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def told(report: dict[str, Any], now: str) -> str:
    """Where and when, and whether the numbers are those of the step as it is."""
    machine = report["machine"]
    text = (
        f"Measured on {report['date'][:10]} on one core of an {machine['cpu']}, Python {machine['python']}."
    )
    if report.get("step") == now:
        return f"{text} The text of the step is the one that was measured."
    return (
        f"{text} **The text of the step has changed since**: these numbers are of an earlier one until `make"
        " bench` is run again."
    )


def limit(found: dict[str, Any]) -> str:
    """Beside the program written by hand."""
    times = found["ns_per_step_and_simulation"]
    widths = [lanes for lanes in (1, 4, 8) if f"ledger_{lanes}" in times]
    names = {"generated": {lanes: f"generated_{lanes}_lane{'s' * (lanes > 1)}" for lanes in widths}}
    there = {name: said for name, said in LIMIT.items() if name in names or f"{name}_{widths[0]}" in times}
    rows = [
        [said, *(f"{number(times[names.get(name, {}).get(n, f'{name}_{n}')])} ns" for n in widths)]
        for name, said in there.items()
    ]
    rows.append(["vfife, data-driven loop", f"{number(times['data_driven'])} ns", *[""] * (len(widths) - 1)])
    return grid(["", *(f"{n} lane{'s' * (n > 1)}" for n in widths)], rows)


def peers(found: dict[str, Any]) -> str:
    """Wall milliseconds per crank revolution."""
    cases = {name: found[f"case_{name}"] for name in CASES if f"case_{name}" in found}
    rows = [["vfife, generated loop", *(number(case["vfife"]["generated"]["ms"]) for case in cases.values())]]
    for name, said in (
        ("mujoco", "MuJoCo"),
        ("exudyn", "Exudyn"),
        ("scipy", "SciPy, events, compiled right-hand side"),
    ):
        if any("ms" in case.get(name, {}) for case in cases.values()):
            rows.append(
                [
                    said,
                    *(
                        number(case[name]["ms"]) if "ms" in case.get(name, {}) else "none"
                        for case in cases.values()
                    ),
                ]
            )
    return grid(["", *(CASES[name] for name in cases)], rows)


def elastic(found: dict[str, Any]) -> str:
    """Millions of element-steps per second."""
    rows = [
        [said, number(1e-6 * found[name]["element_steps_per_s"])]
        for name, said in ELASTIC.items()
        if name in found
    ]
    for name, value in found.items():
        if name not in ELASTIC and isinstance(value, dict) and "element_steps_per_s" in value:
            rows.append(
                [
                    f"{name.partition(',')[0]}, four-bar of 22 elements",
                    number(1e-6 * value["element_steps_per_s"]),
                ]
            )
    return grid(["", ""], rows)


def compilation(found: dict[str, Any]) -> str:
    """Seconds until a step is there when nothing is kept."""
    rows = []
    for name, said in COMPILED.items():
        one, four = found[f"{name}, 1"], found[f"{name}, 4"]
        rows.append(
            [said, f"{one['lines']:.0f}", f"{number(one['seconds'])} s", f"{number(four['seconds'])} s"]
        )
    return grid(["", "lines", "1 lane", "4 lanes"], rows)


def ratios(report: dict[str, Any]) -> str:
    """All ratios, with what they shall be."""
    rows = [
        [f"`{key}`", number(value), report["targets"].get(key, "")] for key, value in report["ratios"].items()
    ]
    return grid(["ratio", "value", "shall be"], rows)


def tables(now: str, report: dict[str, Any] | None = None) -> dict[str, str]:
    """What stands in the page for each of its marks; ``now`` is the hash of the step's text as it is."""
    report = json.loads(LATEST.read_text()) if report is None else report
    measured = report["measured"]
    made = {"@TOLD@": told(report, now), "@RATIOS@": ratios(report)}
    for make in (limit, peers, elastic, compilation):
        name = make.__name__
        made[f"@{name.upper()}@"] = (
            make(measured[name])
            if len(measured.get(name, {})) > 1
            else "Not measured yet; `make bench` does."
        )
    return made
