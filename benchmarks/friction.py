"""What a step costs with each friction law, over one with Ambrosio's, in the generated loop.

Two four-bars with three clearance joints and one law in all of them: the paper's links (particles of their
own in every joint, so the three laws are worked out side by side) and case c (rigid links, so a joint waits
for the one before).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from measure import EXAMPLES, Options, Part, interleaved, seconds, table

import vfife
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner
from vfife.laws import FrictionLaw

MODELS = {"links_of_their_own": "four_bar.toml", "shared_bodies": "four_bar_case_c.toml"}
BASE = "ambrosio"


def timed(file: str, law: type[FrictionLaw], lanes: int, steps: int) -> Callable[[], float]:
    """A run of the generated loop, already compiled; it gives seconds per step."""
    mechanism = vfife.load_model(EXAMPLES / file)
    for name, joint in mechanism.clearances.items():
        mechanism.joints[name] = dataclasses.replace(joint, friction=law())
    assembly = assemble(mechanism, 1e-6, turns=1, force_step=True)
    states = np.repeat(assembly.state[: assembly.layout.rows, None], lanes, axis=1)
    tables = np.repeat(assembly.tables[None, :], lanes, axis=0)
    kept = np.array(assembly.layout.of("state"), dtype=np.uint32)

    def run() -> float:
        runner = Runner(assembly.topology, states.copy(), tables, "generated", kept)
        took = seconds(lambda: runner.advance(steps, 1))
        if not np.isfinite(runner.states).all():
            raise RuntimeError(f"{file}, {law.name}: the run diverged")
        return took / steps

    Runner(assembly.topology, states.copy(), tables, "generated", kept).advance(3, 1)
    return run


def measure(options: Options) -> Part:
    """ns per step with every friction law, interleaved; ratios to Ambrosio's."""
    part = Part()
    laws = sorted(FrictionLaw.registry.values(), key=lambda law: (law.name != BASE, law.name))
    steps = 20_000 if options.quick else 100_000
    lanes = (1, 4)
    for model, file in MODELS.items():
        runs = {f"{law.name}, {count}": timed(file, law, count, steps) for law in laws for count in lanes}
        best = interleaved(3 if options.quick else 9, runs)
        part.measured[model] = {name: 1e9 * took for name, took in best.items()}
        rows = []
        for law in laws:
            ratios = [best[f"{law.name}, {count}"] / best[f"{BASE}, {count}"] for count in lanes]
            if law.name != BASE:
                part.ratios |= {
                    f"friction.{model}_{law.name}_{count}": ratio
                    for count, ratio in zip(lanes, ratios, strict=True)
                }
            rows.append(
                (law.name, 1e9 * best[f"{law.name}, 1"], ratios[0], 1e9 * best[f"{law.name}, 4"], ratios[1])
            )
        part.tables.append(
            table(
                f"{model}: ns per step, over {BASE}", "law", "1 lane", "ratio", "4 lanes", "ratio", rows=rows
            )
        )
    return part
