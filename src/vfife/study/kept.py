"""What is in a map file: a diagram, a section or basins."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from ..errors import RunFileError
from ..results.mapfile import MapFile
from . import basins, diagram, sections
from .basins import Basins
from .diagram import Bifurcation
from .sections import PoincareSection

Kept: TypeAlias = Basins | Bifurcation | PoincareSection
READERS: dict[str, Callable[[MapFile], Kept]] = {
    basins.WHAT: basins.read_basins, diagram.WHAT: diagram.read_diagram, sections.WHAT: sections.read_section,
}  # fmt: skip


def load_map(path: str | Path) -> Kept:
    """The diagram, section or basins in a map file, as far as it is known. Raises RunFileError for any other file."""
    with MapFile.open(Path(path)) as file:
        what = str(file.asked.get("what"))
        if what not in READERS:
            raise RunFileError(f"{path}: this map file was written by another version of vfife; make the map again")
        return READERS[what](file)
