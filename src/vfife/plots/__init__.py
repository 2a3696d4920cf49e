"""Figures of a result: the one place that imports matplotlib. Figures are objects, without pyplot and without a
window.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib

from ..assembly.assemble import assemble
from ..errors import VfifeError, shown, suggestion
from ..model.mechanism import Mechanism
from ..model.validate import validate
from ..results.view import standing
from .curves import acceleration_curves, force_curves, moment_curves
from .drawing import drawing
from .files import saved
from .orbits import journals, orbits
from .style import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View


FIGURES: dict[str, Callable[[View, View | None], Figure | None]] = {
    "mechanism": lambda result, reference: drawing(result),
    "orbits": lambda result, reference: orbits(result) if journals(result) else None,
    "forces": force_curves,
    "moments": moment_curves,
    "accelerations": lambda result, reference: None if result.record.static else acceleration_curves(result, reference),
}


def figures(result: View, reference: View | None = None, names: Collection[str] = ()) -> dict[str, Figure]:
    """Figures by name: ``mechanism``, ``orbits`` (with clearance joints), ``forces``, ``moments`` (of gears and
    drivers), ``accelerations``; all that the result has, or those of ``names`` among them.

    The reference, whose curves lie below those of the result, is the result's own unless another one is given. Raises
    :class:`~vfife.errors.VfifeError` for a name that is no figure's.
    """
    for name in names:
        if name not in FIGURES:
            raise VfifeError(f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one that there is')}")
    reference = reference if reference is not None else result.reference
    with matplotlib.rc_context(STYLE):
        found = {name: figure(result, reference) for name, figure in FIGURES.items() if not names or name in names}
    return {name: figure for name, figure in found.items() if figure is not None}


def at_start(mechanism: Mechanism) -> Figure:
    """A mechanism drawn where it starts. Raises ModelError for one with faults, AssemblyError for one that cannot be assembled."""
    validate(mechanism)
    with matplotlib.rc_context(STYLE):
        return drawing(standing(assemble(mechanism)))


def save(figures: dict[str, Figure], folder: str | Path) -> list[Path]:
    """Writes each figure as PNG into a folder, made if need be; returns the files."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with matplotlib.rc_context(STYLE):
        for name, figure in figures.items():
            paths.append(saved(figure, folder / f"{name}.png"))
    return paths


__all__ = ["acceleration_curves", "at_start", "drawing", "figures", "force_curves", "moment_curves", "orbits", "save"]
