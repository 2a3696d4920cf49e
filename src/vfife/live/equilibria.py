"""Pages of static analyses: their equilibria in the place of steps, along the load path."""

from __future__ import annotations

import numpy as np

from ..analysis.forces import normals
from ..errors import VfifeError
from ..result import Result
from .given import Json, given, packed
from .together import Together


def told_of(result: Result) -> Json:
    """What the page of a static result is given: all rows of its equilibria, with the directions in which contacts press.

    Raises VfifeError where there is none but the start.
    """
    record = result.record
    if len(record.steps) < 2:
        raise VfifeError(f"no equilibrium but the start was found, so there is no load path to show. {record.message}".rstrip())
    pressed = normals(record)
    rows = np.hstack([record.rows, pressed[..., 0], pressed[..., 1]])
    notes = [] if record.status == "complete" else [f"the analysis ended {record.status} at load factor {result.time[-1]:g}"]
    return given(Together(record.assembly, None)) | {
        "outputs": len(rows) - 1, "factors": result.time.tolist(), "path": packed(rows), "slides": [], "groups": [], "notes": notes, "texts": True,
    }  # fmt: skip
