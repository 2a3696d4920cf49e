"""What a run will cost: time from a table of costs per entity, bytes of its record. Estimates, and called so."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .amounts import amount_of_bytes, span

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly

# Time (ns) of a step, and what each clearance joint, ideal joint and element adds to it; measured on a common 3 GHz core.
NANOSECONDS = {
    "data-driven": {"step": 20.0, "clearance": 50.0, "ideal": 115.0, "element": 18.0},
    "generated": {"step": 10.0, "clearance": 38.0, "ideal": 40.0, "element": 5.0},
}
DATA_DRIVEN_COMPILATION = 10.0  # s, once for all models with the same forms of laws; kept on disk
PACKED = 0.5  # of the outputs' bytes, in the run file
STRAIGHT_LINE_COMPILATION = 0.2, 2.2e-4  # s, and for each line of the step, once for all models of the same topology
STATIC_LOOKS = 3000.0  # ns that looks at an iteration add to it
BRIEF = 2.0  # s of an ideal reference that need not be forecast before it is run
MOST_TRIES = 7.0  # times the steps of the first try, where an automatic step is halved twice
REFINED = 7.0  # times the steps of a smooth run that is repeated with half and with a quarter of its step
MESHED = 5.5  # times the time of a static analysis that is repeated with twice and with half the elements; 3.5 to 6 in the examples

MEMORY = 2.5  # times the record that its readers take
LIBRARIES = 2.5e8  # bytes that are taken before anything is computed
LONG, SHARE = 3600.0, 0.5  # s, and share of memory or of the free disk, beyond which a run is asked for twice


def too_much(found: dict[str, Any], place: Path) -> str:
    """What of a forecast is so much that it may not be meant, in words; empty where nothing is."""
    from .tables import free_bytes

    free, memory = free_bytes(place), physical_memory()
    said = []
    if found["seconds"] > LONG:
        said.append(f"some {span(found['seconds'])}")
    if memory is not None and found["memory"] > SHARE * memory:
        said.append(f"some {amount_of_bytes(found['memory'])} of memory, of which there are {amount_of_bytes(memory)}")
    if free is not None and found["disk"] > SHARE * free:
        said.append(f"some {amount_of_bytes(found['disk'])} on a disk that has {amount_of_bytes(free)} left")
    return " and ".join(said)


def physical_memory() -> int | None:
    """Bytes of memory of this machine, None where nobody tells."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None


def estimate(assembly: Assembly, reference: Assembly | None = None) -> dict[str, Any]:
    """Loop, time of a step (ns), time of all steps and of a first compilation (s), bytes of the record, in memory and on the disk.

    With the ideal ``reference``, which is kept beside it, where there is one. Of an automatic step the first try is meant, of statics the
    iterations that equilibria take as a rule.
    """
    found = _alone(assembly)
    every, found["ideal_seconds"] = found["bytes"], 0.0
    if reference is not None:
        ideal = _alone(reference)
        found["ideal_seconds"] = ideal["seconds"]
        found["seconds"] += ideal["seconds"]
        every += ideal["bytes"]
    return found | {"memory": MEMORY * every + LIBRARIES, "disk": PACKED * every}


def with_repetition(found: dict[str, Any], assembly: Assembly, refined: bool) -> dict[str, Any]:
    """A forecast with the repetitions that an estimate of errors takes, where it takes any: see :func:`vfife.simulation.repeated`.

    Those of a smooth run keep the outputs that measures are of, all of them where nothing turns.
    """
    if not refined:
        return found
    if assembly.mechanism.settings.analysis == "static":
        return found | {"seconds": MESHED * found["seconds"]}
    return found | {"seconds": REFINED * found["seconds"], "memory": found["memory"] + 2.0 * found["bytes"]}


def _alone(assembly: Assembly) -> dict[str, Any]:
    from ..codegen.straight_line import about
    from ..solvers.record import recorded_rows
    from ..solvers.refinement import iterations
    from ..solvers.transient import choose_loop

    topology, choice = assembly.topology, assembly.choice
    static = assembly.mechanism.settings.analysis == "static"
    counts = {
        "step": 1,
        "clearance": len(topology.contact_bearing),
        "ideal": len(topology.joint_bearing),
        "element": len(topology.frame_nodes),
    }
    loop = "data-driven" if static else choose_loop(assembly, "auto")
    ns = sum(NANOSECONDS[loop][name] * count for name, count in counts.items())
    begin, each = STRAIGHT_LINE_COMPILATION
    steps = choice.outputs * iterations(assembly) if static else choice.steps
    ns += STATIC_LOOKS * static
    return {
        "loop": loop,
        "ns_per_step": ns,
        "seconds": 1e-9 * ns * steps,
        "compile_seconds": begin + each * about(topology) if loop == "generated" else DATA_DRIVEN_COMPILATION,
        "rows": assembly.layout.rows,
        "bytes": 8 * len(recorded_rows(assembly)) * (choice.outputs + 1),
    }
