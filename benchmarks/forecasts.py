"""Forecasts beside the time that was taken, of every kind of long work:
``python benchmarks/forecasts.py [NAME...]``.

Both are in processor time on one core, so that other programs on the machine count little. A forecast should
be right within a factor of two.
"""

from __future__ import annotations

import csv
import dataclasses
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

import vfife
from vfife.job.cost import Forecast
from vfife.job.job import Job
from vfife.model.wear import Wear

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
CASE = EXAMPLES / "four_bar_case_b.toml"
PIN = EXAMPLES / "slider_crank_loose_pin.toml"


class Recorder(Job):
    """Keeps the last forecast of a job, and when the work after it began (s of processor time)."""

    def __init__(self) -> None:
        super().__init__("benchmark", None, True, lambda progress: None)
        self.forecast, self.began = Forecast("run"), 0.0

    def begin(self, forecast: Forecast) -> None:
        """A forecast; the work begins."""
        self.forecast, self.began = forecast, time.process_time()


def run(job: Job) -> None:
    vfife.simulate(vfife.load_model(CASE), turns=800, progress=job)


def run_without_companions(job: Job) -> None:
    vfife.simulate(vfife.load_model(CASE), turns=5000, companions=0, step=1e-5, progress=job)


def study_of_clearances(job: Job) -> None:
    values = [f"{0.1 + 0.001 * k:.4f} mm" for k in range(300)]
    vfife.study(vfife.load_model(CASE), {"joint.C.clearance": values}, "C.force.max", turns=10, progress=job)


def study_of_lengths(job: Job) -> None:
    values = [f"{259.0 + 0.01 * k:.4f} mm" for k in range(200)]
    vfife.study(
        vfife.load_model(CASE), {"body.coupler.length": values}, "C.force.max", turns=10, progress=job
    )


VARIED: dict[str, Any] = {
    "play": {"path": "joint.C.clearance", "from": "0.1 mm", "to": "0.5 mm"},
    "mass": {"path": "body.coupler.mass", "from": 1.0, "to": 3.0},
}


def search(job: Job) -> None:
    vfife.optimise(
        vfife.load_model(CASE),
        VARIED,
        ["C.force.max"],
        optimise={"minimise": ["C.force.max"], "members": 150},
        turns=5,
        progress=job,
    )


def allocate(job: Job) -> None:
    play = {"play": {"path": "joint.C.clearance", "fit": "H8/f7", "diameter": "20 mm"}}
    fits: dict[str, Any] = {
        "cost": {"play": {"IT6": 9, "IT7": 5, "IT8": 3, "IT9": 2}},
        "limit": {"C.force.max": "1.2 kN"},
    }
    vfife.studies.allocate(
        vfife.load_model(CASE),
        play,
        "C.force.max",
        turns=10,
        allocation={"measure": "C.force.max", "share": 0.9},
        progress=job,
        **fits,
    )


def sweep(job: Job) -> None:
    vfife.bifurcation(
        vfife.load_model(PIN), "joint.pin.clearance", 1e-4, 1e-3, count=20, turns=30, progress=job
    )


def section(job: Job) -> None:
    vfife.dynamics.poincare_section(vfife.load_model(PIN), turns=300, progress=job)


def basins(job: Job) -> None:
    vfife.dynamics.basins(
        vfife.load_model(PIN),
        ("start.pin.x", -1e-4, 1e-4),
        ("start.pin.y", -1e-4, 1e-4),
        count=(8, 8),
        turns=20,
        progress=job,
    )


def waterfall(job: Job) -> None:
    vfife.dynamics.waterfall(
        vfife.load_model(PIN), "driver.crank.speed", 50.0, 150.0, count=20, turns=12, progress=job
    )


def wear(job: Job) -> None:
    model = vfife.load_model(PIN)
    model.joints["pin"] = dataclasses.replace(model.joints["pin"], wear=Wear(bearing=1e-15, journal=2e-16))  # type: ignore[type-var]
    vfife.wear(model, 4e6, block=2, settle=2, progress=job)


def measured(folder: Path) -> tuple[vfife.Mechanism, Path]:
    """A model, and a measured curve of it: one turn."""
    model = vfife.load_model(CASE)
    vfife.simulate(model, turns=1, companions=0, step=2e-6).export(folder / "all.csv")
    lines = [line for line in (folder / "all.csv").read_text().splitlines() if not line.startswith("#")]
    heads = next(csv.reader(lines[:1]))
    keep = [k for k, head in enumerate(heads) if head.startswith(("time", "coupler.angular_acceleration"))]
    rows = [",".join(row[k] for k in keep) for row in csv.reader(lines)]
    (folder / "curve.csv").write_text("\n".join(rows) + "\n")
    return model, folder / "curve.csv"


def fit(count: int) -> Callable[[Job], None]:
    def fit(job: Job) -> None:
        bounds = {"joint.C.clearance": ("0.1 mm", "0.5 mm"), "joint.C.contact.restitution": (0.3, 0.9)}
        with tempfile.TemporaryDirectory() as folder:
            model, path = measured(Path(folder))
            vfife.fit(model, path, dict(list(bounds.items())[:count]), step="2 us", offset="0", progress=job)

    return fit


def compare(job: Job) -> None:
    vfife.compare(
        vfife.load_model(CASE), ["pereira", "liu", "lankarani-nikravesh", "flores"], turns=400, progress=job
    )


def sensitivity(job: Job) -> None:
    vfife.sensitivity(vfife.load_model(CASE), ["C.force.max"], ["*"], turns=10, progress=job)


WORK: dict[str, Callable[[Job], None]] = {
    "run": run,
    "run, companions 0": run_without_companions,
    "study of clearances": study_of_clearances,
    "study of lengths": study_of_lengths,
    "search": search,
    "allocate": allocate,
    "sweep": sweep,
    "section": section,
    "basins": basins,
    "waterfall": waterfall,
    "wear": wear,
    "fit of one number": fit(1),
    "fit of two numbers": fit(2),
    "compare": compare,
    "sensitivity": sensitivity,
}


def main() -> None:
    """Print the table."""
    os.cpu_count = lambda: 1  # processor time on one core
    table = Table("work", "forecast, s", "taken, s", "taken / forecast")
    for name in sys.argv[1:] or WORK:
        job = Recorder()
        try:
            WORK[name](job)
        except Exception as error:
            print(name, type(error), error)
            continue
        taken = time.process_time() - job.began
        table.add_row(
            name, f"{job.forecast.seconds:.2f}", f"{taken:.2f}", f"{taken / job.forecast.seconds:.2f}"
        )
        print(name, f"{job.forecast.seconds:.2f} {taken:.2f}", flush=True)
    Console().print(table)


if __name__ == "__main__":
    main()
