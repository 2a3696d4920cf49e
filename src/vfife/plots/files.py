"""Figures as files: whole or not there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib

from ..files import replacement
from .style import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def saved_in_style(draw: Callable[[], Figure], path: Path) -> Path:
    """Draws a figure in the style of all and writes it as :func:`saved` does."""
    with matplotlib.rc_context(STYLE):
        return saved(draw(), path)


def saved(figure: Figure, path: Path) -> Path:
    """Writes a figure under another name and renames it; the ending of ``path`` chooses PNG, PDF or SVG."""
    kind, by = path.suffix.lower().removeprefix("."), f"vfife, Matplotlib {matplotlib.__version__}"
    with replacement(path) as temporary:
        figure.savefig(temporary, format=kind, metadata={"png": {"Software": by}, "pdf": {"Creator": by}, "svg": {"Creator": by}}.get(kind))
    return path
