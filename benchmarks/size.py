"""Cost per element and step, time of assembly and memory from 10 to 100,000 elements: a straight bar, then a
lattice frame, data-driven loop.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable

import numpy as np
from measure import Options, Part, table

from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.bodies import Section
from vfife.compiler.runtime.runner import Runner
from vfife.model.bodies import MOST_ELEMENTS, Member

SIZES = (10, 100, 1000, 10_000, 100_000)
STEPS = 2e6  # element-steps of a timed run
NOTHING = np.zeros(1, dtype=np.uint32)


def bar(elements: int) -> Mechanism:
    """A bar on a pin, falling."""
    mechanism = Mechanism("bar", gravity=(0.0, -9.81))
    mechanism.point("A", 0.0, 0.0)
    mechanism.link(
        "bar", length=0.01 * elements, model="elastic", elements=elements, section=Section.square(1e-4)
    )
    mechanism.revolute("A", "ground.A", "bar.start")
    return mechanism


def lattice(elements: int) -> Mechanism:
    """A square of square meshes, hung at a corner."""
    side = max(1, round((elements / 2.0) ** 0.5))
    while 2 * side * (side + 1) > MOST_ELEMENTS:
        side -= 1
    nodes = {f"{i}-{j}": (0.01 * i, 0.01 * j) for i in range(side + 1) for j in range(side + 1)}
    members = []
    for i in range(side + 1):
        members += [Member(f"{i}-{j}", f"{i}-{j + 1}") for j in range(side)]
        members += [Member(f"{i}-{j}", f"{i + 1}-{j}") for j in range(side + 1) if i < side]
    mechanism = Mechanism("lattice", gravity=(0.0, -9.81))
    mechanism.point("A", 0.0, 0.0)
    mechanism.frame("frame", nodes=nodes, members=tuple(members), section=Section.square(1e-5))
    mechanism.revolute("A", "ground.A", "frame.0-0")
    return mechanism


def peak() -> float:
    """Largest memory of this process so far (bytes)."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(options: Options) -> Part:
    """Ratios of the dearest size to the cheapest, seconds of assembly and bytes per element at
    the largest.
    """
    part = Part()
    rows = []
    sizes = SIZES[:4] if options.quick else SIZES
    for make in (bar, lattice):
        costs = {}
        for size in sizes:
            cost, seconds, elements, memory = one(make, size, options)
            costs[elements] = cost
            rows.append(
                (make.__name__, f"{elements:,}", f"{1e9 * cost:.1f}", f"{seconds:.2f}", f"{memory:.0f}")
            )
        part.ratios[f"size.{make.__name__}"] = max(costs.values()) / min(costs.values())
        part.ratios[f"size.assembly_{make.__name__}"] = seconds / 5.0
        part.ratios[f"size.memory_{make.__name__}"] = memory / 2000.0
        part.measured[make.__name__] = {str(size): cost for size, cost in costs.items()}
    part.tables.append(
        table(
            "size", "model", "elements", "ns per element-step", "assembly (s)", "bytes per element", rows=rows
        )
    )
    return part


def one(make: Callable[[int], Mechanism], size: int, options: Options) -> tuple[float, float, int, float]:
    """Best time per element-step, seconds of assembly, elements, and what memory has grown by per element."""
    before = peak()
    mechanism = make(size)
    began = time.perf_counter()
    assembly = assemble(mechanism, duration=1.0, outputs=1)
    seconds = time.perf_counter() - began
    elements = len(assembly.topology.frame_nodes)
    runner = Runner(
        assembly.topology, assembly.state[:, None].copy(), assembly.tables[None, :], "data-driven", NOTHING
    )
    runner.advance(1, 1)
    steps = max(10, round(STEPS / elements))
    best = min(timed(runner, steps) for _ in range(3 if options.quick else 9))
    return best / steps / elements, seconds, elements, (peak() - before) / elements


def timed(runner: Runner, steps: int) -> float:
    """Seconds of so many steps."""
    began = time.perf_counter()
    runner.advance(steps, 1)
    return time.perf_counter() - began
