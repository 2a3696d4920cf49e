"""Figures of results: the only package that imports matplotlib. Figures are objects, without pyplot and
windows.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from ..errors import VfifeError, shown
from ..model.mechanism import Mechanism
from ..model.validation import validate
from ..results.run_data import RunData
from .catalogue import ALL_FIGURES, FIGURES, available, check_names, usual
from .curves import acceleration_curves, force_curves, moment_curves
from .drawing import drawing
from .labels import run_labels
from .motion import orbits
from .overlay import check_count, overlaid, overlay, overlays
from .pose import clear_pose
from .style import PICTURES, STYLE, Figures, saved
from .turn import output_at


def figures(result: RunData, reference: RunData | None = None, names: Collection[str] = ()) -> Figures:
    """Return figures by name, see :data:`~vfife.plots.catalogue.FIGURES`: the usual ones, "all" available
    ones, or ``names``.

    The reference, whose curves lie below those of the result, is by default the result's own. Raises
    :class:`~vfife.errors.VfifeError` for an unknown figure, and for one without data.
    """
    chosen_names = chosen(result, names)
    reference = reference if reference is not None else result.reference
    return Figures({name: figure(result, name, reference) for name in chosen_names})


def chosen(result: RunData, names: Collection[str]) -> list[str]:
    """Return the names of figures in the order of the table. Raises VfifeError for an unknown figure, and for
    one without data.
    """
    if not names:
        return usual(result)
    check_names(names)
    for name in names:
        if name != ALL_FIGURES and (reason := FIGURES[name].missing(result)):
            raise VfifeError(
                f"this result has nothing for the figure {shown(name)}: {reason}; there are"
                f" {', '.join(available(result))}"
            )
    return available(result) if ALL_FIGURES in names else [name for name in FIGURES if name in names]


def only_mechanism(names: Collection[str]) -> None:
    """Raise VfifeError for figures other than the mechanism, the only one that can be drawn at a moment."""
    if set(names) - {"mechanism"}:
        raise VfifeError("at: the mechanism alone is drawn at a moment; name no other figure with it")


@rc_context(STYLE)
def figure(result: RunData, name: str, reference: RunData | None = None, at: str | None = None) -> Figure:
    """Return one figure that has data; the mechanism ``at`` a moment, see
    :func:`~vfife.plots.turn.output_at`.
    """
    return FIGURES[name].draw(result, reference) if at is None else drawing(result, output_at(result, at))


@rc_context(STYLE)
def at_start(mechanism: Mechanism) -> Figure:
    """Return a drawing of a mechanism at its start, or in the first turn where the start hides a body. Raises
    ModelError, AssemblyError.
    """
    validate(mechanism)
    view, pose = clear_pose(mechanism)
    return drawing(view, pose=pose)


def save(figures: dict[str, Figure], folder: str | Path, kind: str = "png") -> list[Path]:
    """Write each figure into a folder, made if missing, as PNG, SVG or PDF; return the files."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return [saved(figure, folder / f"{name}.{kind}") for name, figure in figures.items()]


def save_one(result: RunData, name: str | None, path: Path, other_endings: Collection[str] = ()) -> None:
    """Write the figure ``name``, by default that of the file's name, in the format of the file's extension.

    Raises VfifeError for another extension, listing ``other_endings`` too, and for a figure without data;
    OSError.
    """
    kind = path.suffix.lower()
    if kind not in PICTURES:
        pictures, endings = ", ".join(PICTURES), ", ".join(other_endings)
        formats = f"figures are written as {pictures}"
        if name is None and endings:
            formats = f"data are written as {endings}, {formats}"
        raise VfifeError(f'{path}: "{path.suffix or path.name}" is no format of an export; {formats}')
    figure_name = name if name is not None else path.stem
    try:
        drawn = figures(result, names=[figure_name])
    except VfifeError as error:
        raise VfifeError(f"{path}: {error}") from None
    saved(drawn[figure_name], path)


__all__ = [
    "acceleration_curves",
    "at_start",
    "check_count",
    "drawing",
    "figures",
    "force_curves",
    "moment_curves",
    "orbits",
    "overlaid",
    "overlay",
    "overlays",
    "run_labels",
    "save",
    "save_one",
]
