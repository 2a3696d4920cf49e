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
from ..results.whole import whole
from .curves import acceleration_curves, force_curves, moment_curves
from .drawing import drawing
from .files import saved
from .orbits import journals, orbits
from .style import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View


PICTURES = (".svg", ".pdf", ".png")
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


def save_one(result: View, name: str | None, path: Path, beside: Collection[str] = ()) -> None:
    """Writes one figure as its file's ending says: ``name``, else that of the file. ``beside`` are endings that are told where none fits.

    Raises VfifeError for another ending, and for a figure that the result has nothing for; OSError.
    """
    kind = path.suffix.lower()
    if kind not in PICTURES:
        known = ", ".join((*PICTURES, *beside)) if name is None else ", ".join(PICTURES)
        raise VfifeError(f'{path}: nothing is written as "{path.suffix or path.name}"; endings that say a format are {known}')
    wanted = name if name is not None else path.stem
    found = figures(result, names=[wanted])
    if wanted not in found:
        raise VfifeError(f"{path}: this result has nothing for the figure {shown(wanted)}; there are {', '.join(figures(result))}")
    with matplotlib.rc_context({**STYLE, "svg.fonttype": "path"}), whole(path) as part:
        found[wanted].savefig(part, format=kind[1:])


__all__ = ["acceleration_curves", "at_start", "drawing", "figures", "force_curves", "moment_curves", "orbits", "save", "save_one"]
