"""Measured swings of a single and of a double pendulum, 1 kHz, from *The Experimental Multi-Arm Pendulum on a
Cart* (Kaheman, Fasel, Bramburger, Strom, Kutz, Brunton 2022, arXiv:2205.06231; github.com/dynamicslab/
MultiArm-Pendulum, MIT licence in the file beside this one).

``records.npz`` has the angles of four single pendulums (9.2 s) and 26 double ones (2.7 s) in whole µrad, as
first values and second differences. Angles are absolute and count from upright, so pi hangs down. The
authors' own records for validation are not among them.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vfife.identification.measurements import Curve, Measured

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("records.npz")
SPACING, UNIT = 1e-3, 1e-6  # s; rad


@lru_cache
def angles() -> dict[str, Array]:
    """Angles (rad) of all records by name, each of shape (samples, joints)."""
    with np.load(FILE) as data:
        return {name: UNIT * unpack(data[name]) for name in sorted(data.files)}


def unpack(packed: NDArray[np.int32]) -> Array:
    """Angles in µrad from their first row and the differences of their differences."""
    first, changes = packed[:1].astype(float), np.cumsum(packed[1:], axis=0, dtype=float)
    return np.concatenate([first, first + np.cumsum(changes, axis=0)])


def names(kind: str) -> list[str]:
    """Names of the records of a ``single`` or ``double`` pendulum."""
    return [name for name in angles() if name.startswith(kind)]


def record(name: str, bodies: tuple[str, ...], end: float | None = None, every: int = 1) -> Measured:
    """Return a record as input of a fit: the angles of ``bodies``, up to the time ``end`` (s), one of
    ``every`` samples.
    """
    values = angles()[name]
    times: Array = np.asarray(SPACING * np.arange(len(values)), dtype=np.float64)
    part = slice(0, None if end is None else round(end / SPACING) + 1, every)
    curves = tuple(Curve(f"{body}.angle", f"angle {k + 1}", values[part, k]) for k, body in enumerate(bodies))
    return Measured("time", times[part], curves, name)
