"""What a run will cost: time from a table of costs per entity, bytes of its record. Estimates, and called so."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..assembly.assembled import Assembly

# Time (ns) of a step, and what each clearance joint, ideal joint and element adds to it; measured on a common 3 GHz core.
NANOSECONDS = {
    "data-driven": {"step": 20.0, "clearance": 50.0, "ideal": 115.0, "element": 18.0},
    "generated": {"step": 10.0, "clearance": 38.0, "ideal": 40.0, "element": 5.0},
}
DATA_DRIVEN_COMPILATION = 10.0  # s, once for all models with the same forms of laws; kept on disk
STRAIGHT_LINE_COMPILATION = 0.2, 2.2e-4  # s, and for each line of the step, once for all models of the same topology


def estimate(assembly: Assembly) -> dict[str, Any]:
    """Loop, time of a step (ns), time of all steps and of a first compilation (s), bytes of the record."""
    from ..codegen.straight_line import about
    from ..solvers.record import recorded_rows
    from ..solvers.transient import choose_loop

    topology, choice = assembly.topology, assembly.choice
    counts = {
        "step": 1,
        "clearance": len(topology.contact_bearing),
        "ideal": len(topology.joint_bearing),
        "element": len(topology.frame_nodes),
    }
    loop = choose_loop(assembly, "auto")
    ns = sum(NANOSECONDS[loop][name] * count for name, count in counts.items())
    begin, each = STRAIGHT_LINE_COMPILATION
    return {
        "loop": loop,
        "ns_per_step": ns,
        "seconds": 1e-9 * ns * choice.steps,
        "compile_seconds": begin + each * about(topology) if loop == "generated" else DATA_DRIVEN_COMPILATION,
        "bytes": 8 * len(recorded_rows(assembly)) * (choice.outputs + 1),
    }
