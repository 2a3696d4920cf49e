"""What ideal joints between rigid bodies cost beside clearance joints in the same places: chains of up to ten
bodies, open and closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from measure import Options, Part, interleaved, seconds, table

from vfife import Mechanism
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner

BODIES = (2, 3, 5, 10)
STEPS = 20_000
NOTHING = np.zeros(1, dtype=np.uint32)


def chain(bodies: int, closed: bool, clearance: bool) -> Mechanism:
    """Links in a wavy row, each hung on the one before; closed: the last one on the ground too."""
    mechanism = Mechanism("chain", gravity=(0.0, -9.81))
    at = [(0.2 * k, 0.05 * math.sin(k)) for k in range(bodies + 1)]
    mechanism.point("A", *at[0])
    mechanism.point("Z", *at[-1])
    before = "ground.A"
    for k, (first, second) in enumerate(zip(at, at[1:], strict=False)):
        angle = math.atan2(second[1] - first[1], second[0] - first[0])
        mechanism.link(f"link{k}", length=math.dist(first, second), mass=1.0, angle=angle)
        join(mechanism, f"J{k}", before, f"link{k}.start", clearance)
        before = f"link{k}.end"
    if closed:
        join(mechanism, "JZ", "ground.Z", before, clearance)
    return mechanism


def join(mechanism: Mechanism, name: str, bearing: str, journal: str, clearance: bool) -> None:
    """A joint of either kind."""
    if clearance:
        mechanism.clearance_joint(name, bearing, journal, clearance=2e-4, bearing_radius=0.01)
    else:
        mechanism.revolute(name, bearing, journal)


def measure(options: Options) -> Part:
    """Time of a step with ideal joints over that with clearance joints, the worst of all chains for each
    loop.
    """
    part, rows = Part(), []
    worst = {"data-driven": 0.0, "generated": 0.0}
    for bodies in BODIES[:2] if options.quick else BODIES:
        for closed in (False, True):
            for loop in worst:
                ideal, clear = best(bodies, closed, loop, options)
                worst[loop] = max(worst[loop], ideal / clear)
                rows.append(
                    (
                        f"{bodies}{', closed' if closed else ''}",
                        loop,
                        f"{1e9 * ideal:.0f}",
                        f"{1e9 * clear:.0f}",
                        f"{ideal / clear:.2f}",
                    )
                )
    part.ratios = {f"joints.{loop.replace('-', '_')}": ratio for loop, ratio in worst.items()}
    part.tables.append(
        table("joints", "bodies", "loop", "ideal (ns a step)", "clearance (ns a step)", "ratio", rows=rows)
    )
    return part


def best(bodies: int, closed: bool, loop: str, options: Options) -> tuple[float, float]:
    """Best seconds per step with ideal and with clearance joints, in turn."""
    runs = {kind: stepping(chain(bodies, closed, kind), loop) for kind in (False, True)}
    found = interleaved(
        3 if options.quick else 9, {str(kind): lambda run=run: seconds(run) for kind, run in runs.items()}
    )
    return found["False"] / STEPS, found["True"] / STEPS


def stepping(mechanism: Mechanism, loop: str) -> Callable[[], Any]:
    """So many steps, compiled and begun."""
    assembly = assemble(mechanism, 1e-6, duration=1.0, outputs=1)
    runner = Runner(
        assembly.topology, assembly.state[:, None].copy(), assembly.tables[None, :], loop, NOTHING
    )
    runner.advance(1, 1)
    return lambda: runner.advance(STEPS, 1)
