"""A small study of closed form: what its cases come to is known without running anything."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vfife.studies.engine.outcome import Outcome
from vfife.studies.spec.plan import CaseSpec

BASE = Path(__file__).parents[2] / "examples" / "four_bar_case_b.toml"
ASKED = f"""
model = "{BASE.as_posix()}"
measures = ["C.force.max", "C.impacts"]
turns = 2

[vary.play]
path = "joint.C.clearance"
values = ["0.1 mm", "0.2 mm", "0.3 mm"]

[vary.speed]
path = "driver.crank.speed"
from = "100 rad/s"
to = "200 rad/s"
count = 2
"""


class Closed:
    """Stands for the engine: C.force.max = v² c, C.impacts = round(v), and it counts what it is asked for.
    Some cases fail.
    """

    def __init__(self, fails: float = math.nan, without: float = math.nan) -> None:
        self.computed: list[dict[str, Any]] = []
        self.fails, self.without = fails, without

    def __call__(
        self,
        base: Any,
        numbers: Sequence[Mapping[str, Any]],
        wanted: CaseSpec,
        *,
        workers: Any,
        lanes: Any,
        stop: threading.Event,
    ) -> Iterator[tuple[int, Outcome]]:
        for k in reversed(range(len(numbers))):  # in another order than asked
            if stop.is_set():
                return
            if "run.step" not in numbers[k]:  # one of the sample that is repeated with another step
                self.computed.append(dict(numbers[k]))
            c, v = numbers[k]["joint.C.clearance"], numbers[k].get("driver.crank.speed", 100.0)
            if c == self.fails:
                yield (
                    k,
                    Outcome(status="diverged", reason="diverged after 7 steps", step=1e-6, steps=7, turns=0),
                )
                continue
            values = {"C.force.max": v * v * c, "C.impacts": float(round(v))}
            if c == self.without:
                del values["C.impacts"]
            yield k, Outcome(values, 2, None, "complete", None, 1e-6, 2000)
