"""Measures vfife's speed in one run, prints ratios and writes latest.json; README.md says what each ratio
means.
"""

from __future__ import annotations

import argparse
import datetime
import importlib
import json
import sys
import time
import traceback

from measure import HERE, Options, Part, machine, plain, step_text, table, versions
from rich.console import Console

PARTS = (
    "limit", "compilation", "events", "peers", "elastic", "size", "joints", "laws", "friction", "wear",
    "study", "lanes", "startup", "frames", "card",
)  # fmt: skip
# What each ratio shall be; ratios without an entry are told for information.
TARGETS: dict[str, tuple[str, float]] = {
    "limit.ledger_generated_1_lane": ("at most", 1.0),
    "limit.ledger_generated_4_lanes": ("at most", 1.0),
    "limit.ledger_generated_8_lanes": ("at most", 1.1),
    "limit.data_driven": ("at most", 3.0),
    "compilation.case_c": ("at most", 1.0),
    "compilation.four_bar_22": ("at most", 1.0),
    "compilation.bar_40": ("at most", 1.0),
    "compilation.frame_200": ("at most", 1.0),
    "events.all_over_lean": ("at most", 1.4),
    "peers.case_a_fine_grid": ("at least", 70.0),
    "peers.case_b_fine_grid": ("at least", 60.0),
    "peers.case_c_fine_grid": ("at least", 100.0),
    "elastic.data_driven": ("at least", 1.0),
    "elastic.generated_4_lanes": ("at least", 1.0),
    "elastic.generated_4_lanes_four_bar": ("at least", 1.0),
    "elastic.four_bar_over_c_4_lanes": ("at least", 3.78),
    "elastic.generated_8_over_4_lanes_four_bar": ("at least", 1.7),
    "size.bar": ("at most", 1.5),
    "size.lattice": ("at most", 1.5),
    "size.assembly_bar": ("at most", 1.0),
    "size.assembly_lattice": ("at most", 1.0),
    "size.memory_bar": ("at most", 1.0),
    "size.memory_lattice": ("at most", 1.0),
    "joints.data_driven": ("at most", 1.0),
    "joints.generated": ("at most", 1.0),
    "laws.slowest_1_lane": ("at most", 3.0),
    "laws.slowest_4_lanes": ("at most", 3.0),
    "wear.kept_case_c_1_lane": ("at most", 1.03),
    "wear.kept_case_c_4_lanes": ("at most", 1.03),
    "wear.kept_loose_pin_1_lane": ("at most", 1.03),
    "wear.kept_loose_pin_4_lanes": ("at most", 1.03),
    "study.core_over_one_lane_4_lanes": ("at least", 3.0),
    "lanes.least_gain_of_eight_without_contact": ("at least", 1.0),
    "study.two_cores_over_one": ("at least", 1.85),
    "study.grid_20_by_10": ("at most", 1.0),
    "study.assembly": ("at most", 1.0),
    "study.assembly_length_four_bar": ("at most", 1.0),
    "study.assembly_length_compressor": ("at most", 1.0),
    "study.length_batch_four_bar": ("at most", 25.0),
    "study.length_batch_compressor": ("at most", 15.0),
    "study.length_alone_four_bar": ("at most", 180.0),
    "study.length_alone_compressor": ("at most", 100.0),
    "card.members_100000": ("at least", 300.0),
    "startup.import": ("at most", 1.0),
    "startup.help": ("at most", 1.0),
    "startup.run_warm": ("at most", 1.0),
    "startup.run_cold": ("at most", 1.0),
    "startup.memory_8x": ("at most", 1.05),
    "frames.least": ("at least", 1.0),
    "frames.new_model": ("at most", 1.0),
}


def met(key: str, value: float) -> bool | None:
    """Whether a ratio is what it shall be; None without a target."""
    if key not in TARGETS:
        return None
    word, bound = TARGETS[key]
    return value <= bound if word == "at most" else value >= bound


def arguments() -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    named = f"parts to measure, of {', '.join(PARTS)}"
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="NAME", help=named)
    parser.add_argument("--quick", action="store_true", help="shorter and less exact; for trying out")
    parser.add_argument(
        "--no-peers", action="store_true", help="without the programs of others (nothing is installed)"
    )
    return parser.parse_args()


def perform(name: str, options: Options, console: Console) -> Part:
    """Runs a part; what goes wrong in it is told and does not stop the others."""
    began = time.perf_counter()
    console.rule(name)
    try:
        part: Part = importlib.import_module(name).measure(options)
    except Exception as error:
        console.print(traceback.format_exc(), markup=False, highlight=False)
        part = Part(notes=[f"{name}: failed, {type(error).__name__}: {error}"])
    for shown in part.tables:
        console.print(shown)
    for note in part.notes:
        console.print(note, markup=False)
    part.measured["seconds"] = time.perf_counter() - began
    return part


def main() -> int:
    """Measures, prints, writes; 1 where a part failed. A ratio that is not what it shall be is told, not
    punished.
    """
    chosen, console = arguments(), Console(width=None if sys.stdout.isatty() else 140)
    options = Options(quick=chosen.quick, peers=not chosen.no_peers)
    parts = {name: perform(name, options, console) for name in PARTS if name in chosen.only}
    ratios = {key: value for part in parts.values() for key, value in part.ratios.items()}
    report = {
        "machine": machine(),
        "versions": versions("vfife", "llvmlite", "numpy", "scipy", "xarray"),
        "step": step_text(),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "quick": options.quick,
        "targets": {key: " ".join(map(str, TARGETS[key])) for key in ratios if key in TARGETS},
        "ratios": ratios,
        "measured": {name: part.measured for name, part in parts.items()},
        "notes": [note for part in parts.values() for note in part.notes],
    }
    path = HERE / "latest.json"
    path.write_text(json.dumps(plain(report), indent=2, allow_nan=False) + "\n")
    console.rule("ratios")
    word = {True: "met", False: "missed", None: ""}
    rows = [
        (key, value, report["targets"].get(key, ""), word[met(key, value)]) for key, value in ratios.items()
    ]
    console.print(table("", "ratio", "value", "shall be", "", rows=rows))
    console.print(f"written to {path}")
    failed = any(": failed," in note for note in report["notes"])
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
