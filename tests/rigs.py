"""Curves as a test rig would have measured them: of a run with other numbers and another step, with noise,
from somewhere in a turn on.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

import vfife
from vfife import Mechanism
from vfife.modelfile import dump, loads

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CHANNELS = ("D.force", "crank.torque", "follower.angular_acceleration")


def synthetic(
    path: Path,
    base: Mechanism,
    truth: Mapping[str, float],
    step: float,
    *,
    turns: tuple[float, float],
    every: int,
    noise: float = 0.02,
    seed: int = 0,
    channels: Sequence[str] = CHANNELS,
) -> Path:
    """Writes ``channels`` of a run of ``base`` at the numbers ``truth`` from one turn to another, every so
    many outputs of 1000 a turn.
    """
    true = loads(dump(base), set=list(truth.items()))
    run = vfife.simulate(
        true, turns=float(math.ceil(turns[1])), step=step, outputs=1000, companions=0, reference=False
    )
    place, source = run.crank_rotation / 360.0, np.random.default_rng(seed)
    place -= place[0]
    kept = np.flatnonzero((place >= turns[0]) & (place <= turns[1]))[::every]
    columns = [1e3 * (run.time[kept] - run.time[kept[0]])]
    for name in channels:
        values = np.asarray(run.series[name])[kept]
        columns.append(values + noise * values.std() * source.standard_normal(len(values)))
    lines = [", ".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([", ".join(["time (ms)", *channels]), *lines]) + "\n")
    return path
