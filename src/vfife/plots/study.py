"""Figures of a study: heat maps, curves with bands, parallel coordinates, Pareto fronts."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib import rc_context

from ..errors import VfifeError, shown, suggestion
from .notebook import sharp
from .studycurves import curves, fronts, heat_maps, parallel
from .style import STYLE, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.studied import Study

FIGURES: dict[str, Callable[[Study, list[str]], Figure | None]] = {"maps": heat_maps, "curves": curves, "parallel": parallel, "fronts": fronts}
TITLES = {
    "maps": "Measures over two parameters", "curves": "Measures over a parameter", "parallel": "Members, a line each",
    "fronts": "Measures against each other",
}  # fmt: skip
KINDS = (".png", ".svg", ".pdf")


@rc_context(STYLE)
def figures(study: Study, names: Collection[str] = (), measures: Collection[str] = (), larger: Collection[str] = ()) -> dict[str, Figure]:
    """Figures by name: ``maps``, ``curves``, ``parallel``, ``fronts``; all that the study has something for, or those of ``names``.

    ``measures``: those that are drawn, in this order, all unless some are named; ``larger``: those that are better the larger they are, which a
    front goes by. Raises VfifeError for a name that nothing has.
    """
    for name in names:
        if name not in FIGURES:
            raise VfifeError(f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one that there is')}")
    for name in (*measures, *larger):
        study.values(name)
    draws: dict[str, Callable[[Study, list[str]], Figure | None]] = {**FIGURES, "fronts": partial(fronts, larger=larger)}
    chosen = list(measures) or list(study.measures)
    found = {name: draw(study, chosen) for name, draw in draws.items() if not names or name in names}
    return {name: figure for name, figure in found.items() if figure is not None}


def pictures(study: Study) -> dict[str, str]:
    """All figures of a study as elements of a page, by what they show."""
    return {TITLES[name]: sharp(figure, TITLES[name]) for name, figure in figures(study).items()}


def drawn(
    study: Study,
    folder: Path,
    names: Collection[str] = (),
    measures: Collection[str] = (),
    ending: str = ".png",
    larger: Collection[str] = (),
) -> list[Path]:
    """Writes figures into a folder; returns the files. Raises VfifeError where there is nothing to draw yet."""
    if ending not in KINDS:
        raise VfifeError(f"no figure is written as {shown(ending)}; there are {', '.join(KINDS)}")
    found = figures(study, names, measures, larger)
    if not found:
        raise VfifeError(
            f"{study.path or 'this study'}: there is nothing to draw: {len(study.done):,} of {len(study.members):,} members have ended"
        )
    return [saved(figure, folder / f"{name}{ending}") for name, figure in found.items()]
