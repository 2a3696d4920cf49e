"""Load a map file: a bifurcation diagram, basins, a Poincaré section or a waterfall."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from ..errors import RunFileError
from ..store.mapfile import MapFile
from ..store.store import warn_of_damage
from .basins import Basins
from .bifurcation import Bifurcation
from .sections import PoincareSection
from .waterfall import Waterfall

AnyMap: TypeAlias = Basins | Bifurcation | PoincareSection | Waterfall
KINDS: dict[str, type[AnyMap]] = {
    kind.kind: kind for kind in (Basins, Bifurcation, PoincareSection, Waterfall)
}


def load_map(path: str | Path) -> AnyMap:
    """Load the diagram, section, basins or waterfall in a map file, as far as it is computed.

    Raises RunFileError for any other file.
    """
    with MapFile.open(Path(path)) as file:
        kind = KINDS.get(str(file.spec.get("what")))
        if kind is None:
            raise RunFileError(
                f"{path}: this map file was written by another version of vfife; make the map again"
            )
        result = kind.read(file)
    warn_of_damage(
        Path(path), "map", file.damage, "Repeat the command that made it: it computes the missing rows."
    )
    return result
