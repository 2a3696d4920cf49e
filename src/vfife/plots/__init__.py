"""Figures of a result: the one place that imports matplotlib. Figures are objects, without pyplot and without a
window.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib

from .curves import acceleration_curves, force_curves, moment_curves
from .drawing import drawing
from .orbits import journals, orbits
from .style import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View


def figures(result: View, reference: View | None = None) -> dict[str, Figure]:
    """Figures by name: ``mechanism``, ``orbits`` (with clearance joints), ``forces``, ``moments`` (of gears and
    drivers), ``accelerations``.

    The reference, whose curves lie below those of the result, is the result's own unless another one is given.
    """
    reference = reference if reference is not None else result.reference
    with matplotlib.rc_context(STYLE):
        found = {"mechanism": drawing(result)}
        if journals(result):
            found["orbits"] = orbits(result)
        for name, figure in (
            ("forces", force_curves(result, reference)),
            ("moments", moment_curves(result, reference)),
            ("accelerations", None if result.record.static else acceleration_curves(result, reference)),
        ):
            if figure is not None:
                found[name] = figure
    return found


def save(figures: dict[str, Figure], folder: str | Path) -> list[Path]:
    """Writes each figure as PNG into a folder, made if need be; returns the files."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with matplotlib.rc_context(STYLE):
        for name, figure in figures.items():
            paths.append(folder / f"{name}.png")
            part = folder / f"{name}.png.part"
            try:
                figure.savefig(part, format="png", metadata={"Software": f"vfife, Matplotlib {matplotlib.__version__}"})
                os.replace(part, paths[-1])
            finally:
                part.unlink(missing_ok=True)
    return paths


__all__ = ["acceleration_curves", "drawing", "figures", "force_curves", "moment_curves", "orbits", "save"]
