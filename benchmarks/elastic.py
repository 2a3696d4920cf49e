"""Element-steps per second and core with elastic links, beside PyElastica and OpenSees.

Two models: a free straight bar that flies and turns (nothing but elements), and the four-bar of
peers/common.py with ideal joints, 8 elements in the coupler and 14 in the follower, as the scripts of the
others have it. A step of the four-bar also does its joints and its driver; its elements alone are counted.
"""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from environments import Missing, run
from limit import COMPILER, ask, compiled
from measure import Options, Part, interleaved, seconds, table

from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.bodies import Section
from vfife.compiler.runtime.native import widest
from vfife.compiler.runtime.runner import Runner

TARGET = {"data-driven": 20e6, "generated": 80e6}
FOUR_BAR = 242e6  # element-steps/s of the four-bar in four lanes that code compiled by numba reached
SECTION = Section.square(1e-3)


def bar(elements: int) -> Mechanism:
    """A free bar of 10 mm elements, thrown and spun."""
    mechanism = Mechanism("bar")
    mechanism.link(
        "bar",
        length=0.01 * elements,
        model="elastic",
        elements=elements,
        section=SECTION,
        position=(0.0, 0.0),
        velocity=(1.0, 2.0, 3.0),
    )
    return mechanism


def four_bar(elements: int) -> Mechanism:
    """The four-bar with a rigid crank, ``elements`` in the coupler and as long ones in the follower."""
    mechanism = Mechanism("four-bar, elastic")
    mechanism.point("A", 0.0, 0.0)
    mechanism.point("D", 0.15, 0.0)
    mechanism.link("crank", length=0.4, mass=3.12)
    for name, length, degrees in (("coupler", 0.26, 150.0), ("follower", 0.46, 30.0)):
        count = max(2, round(elements * length / 0.26))
        angle = math.radians(degrees)
        mechanism.link(name, length=length, model="elastic", elements=count, section=SECTION, angle=angle)
    mechanism.revolute("A", "ground.A", "crank.start")
    mechanism.revolute("B", "crank.end", "coupler.start")
    mechanism.revolute("C", "coupler.end", "follower.end")
    mechanism.revolute("D", "ground.D", "follower.start")
    mechanism.drive("crank", speed=50 * math.pi)
    return mechanism


def speed(mechanism: Mechanism, loop: str, lanes: int, wanted: float) -> tuple[int, Callable[[], float]]:
    """Elements of a model, and a timed run of about ``wanted`` element-steps; it gives seconds per
    element-step.
    """
    assembly = assemble(mechanism, "auto", duration=1e-2)
    elements = len(assembly.topology.frame_nodes)
    steps = max(200, round(wanted / elements / lanes))
    states = np.repeat(assembly.state[: assembly.layout.rows, None], lanes, axis=1)
    tables = np.repeat(assembly.tables[None, :], lanes, axis=0)
    kept = np.array(assembly.layout.of("state"), dtype=np.uint32)

    def timed() -> float:
        runner = Runner(assembly.topology, states.copy(), tables, loop, kept)
        took = seconds(lambda: runner.advance(steps, 1))
        if not np.isfinite(runner.states).all():
            raise RuntimeError(f"{mechanism.name}, {loop}: the run diverged")
        return took / steps / lanes / elements

    Runner(assembly.topology, states.copy(), tables, loop, kept).advance(3, 1)  # compile
    return elements, timed


@contextmanager
def written_by_hand(steps: int) -> Iterator[dict[str, Callable[[], float]]]:
    """A timed run of the C program of the part ``limit``, as given, in four lanes: seconds per step and
    simulation. Nothing without a compiler.
    """
    if shutil.which(COMPILER) is None:
        yield {}
        return
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(Path(folder), "limit", 4)
        yield {"c_4_lanes": lambda: 1e-9 * ask(program, steps)["ns"]}


def others(options: Options, part: Part) -> dict[str, float]:
    """Element-steps per second of the scripts of others, case a, 22 elements."""
    found = {}
    length = "0.004" if options.quick else "0.0115"
    chosen: dict[str, tuple[str, ...]] = {
        "openseespy": ("openseespy_peer.py", "--tend", length),
        "pyelastica": ("pyelastica_peer.py", "--tend", length, "--twin", "0"),
    }
    for name, (script, *arguments) in chosen.items():
        try:
            result = run(
                name, script, "--case", "a", "--dt", "1e-6", "--nel", "8", "--repeat", "7", *arguments
            )
        except Missing as error:
            part.notes.append(f"elastic: {error}")
            continue
        found[f"{name} {result['version']}, {result['route']}"] = 22 * result["steps_per_s"]
    return found


def measure(options: Options) -> Part:
    """Speeds of both loops on both models, and of others on the four-bar."""
    part = Part()
    size = 1e6 if options.quick else 4e6
    models: dict[str, tuple[Mechanism, str, int]] = {
        "data_driven": (bar(1000), "data-driven", 1),
        "data_driven_four_bar": (four_bar(8), "data-driven", 1),
        "generated_1_lane_four_bar": (four_bar(8), "generated", 1),
        "generated_4_lanes": (bar(40), "generated", 4),
        "generated_4_lanes_four_bar": (four_bar(8), "generated", 4),
    }
    if widest() >= 8:
        models["generated_8_lanes_four_bar"] = four_bar(8), "generated", 8
    prepared = {name: speed(*model, size) for name, model in models.items()}
    with written_by_hand(200_000 if options.quick else 1_000_000) as c:
        best = interleaved(
            3 if options.quick else 9, {name: timed for name, (_, timed) in prepared.items()} | c
        )
    rows: list[tuple[Any, ...]] = []
    for name, (mechanism, loop, lanes) in models.items():
        rate = 1.0 / best[name]
        part.measured[name] = {"element_steps_per_s": rate, "elements": prepared[name][0], "lanes": lanes}
        if name in ("data_driven", "data_driven_four_bar", "generated_4_lanes"):
            part.ratios[f"elastic.{name}"] = rate / TARGET[loop]
        if name == "generated_4_lanes_four_bar":
            part.ratios[f"elastic.{name}"] = rate / FOUR_BAR
            if c:
                part.ratios["elastic.four_bar_over_c_4_lanes"] = rate * best["c_4_lanes"]
        if name == "generated_8_lanes_four_bar":
            part.ratios["elastic.generated_8_over_4_lanes_four_bar"] = (
                rate * best["generated_4_lanes_four_bar"]
            )
        shown = f"{mechanism.name}, {prepared[name][0]} elements, {loop}, lanes: {lanes}"
        rows.append((shown, rate / 1e6, 1e9 * best[name]))
    if c:
        part.measured["c_4_lanes"] = {"ns_per_step_and_simulation": 1e9 * best["c_4_lanes"]}
    else:
        part.notes.append(
            f"elastic: no ratio to the C program, no C compiler here ({COMPILER} was looked for; CC names"
            " another)"
        )
    if options.peers:
        vfife = part.measured["data_driven_four_bar"]["element_steps_per_s"]
        for name, rate in others(options, part).items():
            part.measured[name] = {"element_steps_per_s": rate, "elements": 22, "lanes": 1}
            part.ratios[f"elastic.over_{name.split()[0]}"] = vfife / rate
            rows.append((f"four-bar, 22 elements, {name}", rate / 1e6, 1e9 / rate))
    columns = ("model, loop", "million element-steps/s", "ns per element-step")
    part.tables.append(table("elastic links on one core", *columns, rows=rows))
    return part
