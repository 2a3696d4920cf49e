"""What every part of the benchmark shares: a part's result, the machine, and times that others disturb
little.
"""

from __future__ import annotations

import hashlib
import math
import os
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.table import Table

from vfife import load_model
from vfife.assembly.assemble import assemble
from vfife.compiler.backends.modules import module
from vfife.compiler.trace.source import data_driven

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
EXAMPLES = ROOT / "examples"


@dataclass(frozen=True)
class Options:
    """How much is measured: ``quick`` shortens runs, ``peers`` says whether the programs of
    others run too.
    """

    quick: bool = False
    peers: bool = True


@dataclass
class Part:
    """What a part found: ratios under telling keys, the numbers behind them, tables to print and remarks."""

    ratios: dict[str, float] = field(default_factory=dict)
    measured: dict[str, Any] = field(default_factory=dict)
    tables: list[Table] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def interleaved(rounds: int, runs: Mapping[str, Callable[[], float]]) -> dict[str, float]:
    """The best of several rounds that call every run once: what slows the machine for a while slows all
    alike.
    """
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(rounds):
        for name, run in runs.items():
            best[name] = min(best[name], run())
    return best


def seconds(action: Callable[[], Any]) -> float:
    """Wall time of one call."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def machine() -> dict[str, Any]:
    """The machine a number was measured on."""
    cpu = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "os": platform.platform(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def versions(*names: str) -> dict[str, str]:
    """Versions of installed packages."""
    found = {}
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def step_text() -> str:
    """Hash of the text of the step, as it is compiled for case c in either loop: numbers taken with another
    text are of another program.
    """
    topology = assemble(
        load_model(EXAMPLES / "four_bar_case_c.toml"), 1e-6, turns=1, force_step=True
    ).topology
    texts = module(topology, 1), data_driven(topology.contact_laws, topology.friction_laws)
    return hashlib.sha256("".join(texts).encode()).hexdigest()[:16]


def plain(value: Any) -> Any:
    """The same with None for numbers that are not finite, which JSON does not know."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def table(title: str, *columns: str, rows: list[tuple[Any, ...]]) -> Table:
    """A table whose first column is text and whose others are numbers."""
    result = Table(title=title, title_justify="left", title_style="bold")
    for k, column in enumerate(columns):
        result.add_column(column, justify="right" if k else "left")
    for row in rows:
        result.add_row(
            *(cell if isinstance(cell, str) else "" if cell is None else f"{cell:.4g}" for cell in row)
        )
    return result
