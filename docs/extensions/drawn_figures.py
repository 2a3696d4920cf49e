"""Pictures for pages: figures are objects without pyplot here, so those that a script leaves in its names are
taken.
"""

from __future__ import annotations

from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from vfife.plots.style import STYLE

SEEN = "__figures_seen__"


def new_figures(names: dict[str, Any]) -> list[Figure]:
    """The figures among the names of a script, or in a dictionary there, that were not taken before."""
    seen = names.setdefault(SEEN, [])  # kept, so that a figure's place in memory is not another's
    found = [
        one
        for value in list(names.values())
        for one in (value.values() if isinstance(value, dict) else [value])
        if isinstance(one, Figure)
    ]
    new: list[Figure] = []
    for figure in found:
        if not any(figure is old for old in [*seen, *new]):
            new.append(figure)
    seen += new
    return new


def taken(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Saves every new figure of a block; returns what shows them on the page."""
    paths = []
    with rc_context(STYLE):
        for figure in new_figures(block_vars["example_globals"]):
            paths.append(next(block_vars["image_path_iterator"]))
            figure.savefig(paths[-1], dpi=90)
    return figure_rst(paths, gallery_conf["src_dir"])


def _get_sg_image_scraper() -> Any:
    return taken
