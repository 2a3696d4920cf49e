"""A law of the user's own against the built-in one that it is a copy of: the ratio of the time of a step, in
one run.

    python benchmarks/own_law.py

Both take the same model (case c: a four-bar with three clearance joints) through the generated loop, in
turns, so that a machine that is busy is busy for both. The numbers of the steps are the same to the bit; the
ratio should lie within 10 % of 1.
"""

from __future__ import annotations

import math
import statistics
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

import vfife
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.runner import Runner
from vfife.solvers.record import recorded_rows

MODEL = Path(__file__).resolve().parents[1] / "examples" / "four_bar_case_c.toml"
STEPS, ROUNDS = 200_000, 15


@dataclass(frozen=True)
class Copy(vfife.laws.ContactLaw):
    """F = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'0)."""

    name: ClassVar[str] = "a-copy"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "damping_factor")
    restitution: float = vfife.laws.quantity("1", "restitution coefficient", 0.9)
    stiffness: float = vfife.laws.quantity("N/m^1.5", "stiffness", 6.6e10)

    def parameters(self, pair):
        return self.stiffness, 0.75 * (1.0 - self.restitution**2)

    @staticmethod
    def force(penetration, slowness, p):
        stiffness, damping_factor = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, elastic * damping_factor * slowness


def runner(own: bool, lanes: int) -> Runner:
    """The model, ready for its steps."""
    mechanism = vfife.load_model(MODEL)
    for name, joint in mechanism.clearances.items():
        law = joint.contact
        assert isinstance(law, vfife.laws.LankaraniNikravesh)
        values = {field: value for field, value in vars(joint).items() if field != "contact"}
        mechanism.joints[name] = vfife.joints.ClearanceRevolute(
            **values, contact=Copy(law.restitution, law.stiffness) if own else law
        )
    model = assemble(mechanism, 1e-7, turns=100.0, force_step=True)
    state = np.repeat(model.state[:, None], lanes, axis=1)
    return Runner(
        model.topology,
        state,
        np.repeat(model.tables[None, :], lanes, axis=0),
        "generated",
        recorded_rows(model),
    )


def main() -> None:
    """Prints the ratio for one lane and for four."""
    for lanes in (1, 4):
        both = [runner(own, lanes) for own in (False, True)]
        ratios, best = [], [math.inf, math.inf]
        for _ in range(ROUNDS):
            spent = []
            for k, one in enumerate(both):
                began = time.perf_counter()
                one.advance(STEPS // lanes, 1)
                spent.append(time.perf_counter() - began)
                best[k] = min(best[k], spent[k])
            ratios.append(spent[1] / spent[0])
        assert (both[0].states == both[1].states).all(), "the same steps, to the bit"
        ns = ", ".join(f"{1e9 * least / STEPS:.1f} ns" for least in best)
        print(
            f"{lanes} lane{'s' * (lanes > 1)}: own/built-in {statistics.median(ratios):.3f} (best"
            f" {best[1] / best[0]:.3f}; {ns} a step)"
        )


if __name__ == "__main__":
    main()
