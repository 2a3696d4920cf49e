"""Pictures for the gallery: figures are objects without pyplot here, so those that a block of a script leaves in its names are taken."""

from matplotlib import rc_context
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from vfife.plots.style import STYLE

SEEN = "__figures_seen__"


def taken(block, block_vars, gallery_conf) -> str:
    """Saves every new figure among the names, or in a dictionary there; returns what shows them on the page."""
    names = block_vars["example_globals"]
    seen = names.setdefault(SEEN, [])
    found = [one for value in list(names.values()) for one in (value.values() if isinstance(value, dict) else [value]) if isinstance(one, Figure)]
    paths = []
    with rc_context(STYLE):
        for figure in found:
            if not any(figure is old for old in seen):
                seen.append(figure)  # kept, so that its place in memory is not another's
                path = next(block_vars["image_path_iterator"])
                figure.savefig(path, dpi=90)
                paths.append(path)
    return figure_rst(paths, gallery_conf["src_dir"])


def _get_sg_image_scraper():
    return taken
