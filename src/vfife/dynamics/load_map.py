"""What is in a map file: a diagram, a section, basins or a waterfall."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from ..errors import RunFileError
from ..store.mapfile import MapFile
from ..store.store import warn_of_damage
from . import basins, bifurcation, sections, waterfall
from .basins import Basins
from .bifurcation import Bifurcation
from .sections import PoincareSection
from .waterfall import Waterfall

Kept: TypeAlias = Basins | Bifurcation | PoincareSection | Waterfall
READERS: dict[str, Callable[[MapFile], Kept]] = {
    basins.WHAT: basins.read_basins, bifurcation.WHAT: bifurcation.read_diagram, sections.WHAT: sections.read_section,
    waterfall.WHAT: waterfall.read_waterfall,
}  # fmt: skip


def load_map(path: str | Path) -> Kept:
    """The diagram, section, basins or waterfall in a map file, as far as it is known. Raises RunFileError for
    any other file.
    """
    with MapFile.open(Path(path)) as file:
        what = str(file.spec.get("what"))
        if what not in READERS:
            raise RunFileError(
                f"{path}: this map file was written by another version of vfife; make the map again"
            )
        found = READERS[what](file)
    warn_of_damage(
        Path(path), "map", file.damage, "Give the command that made it again: it computes what is gone."
    )
    return found
