"""Nonlinear dynamics: bifurcation diagrams, Poincaré sections, basins of attraction, waterfalls, spectra and
modes; :func:`load_map` reads the file of each.
"""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from ..errors import RunFileError
from ..laws.stored import standing_in
from ..measures.modes import modes
from ..options import with_faults
from ..results.spectra import envelope, spectrogram, spectrum
from ..store.connections import warn_of_damage
from ..store.studyfile import MapFile
from .basins import Basins, basins
from .bifurcation import Bifurcation, bifurcation
from .maps import OWN_LAWS
from .sections import PoincareSection, poincare_section
from .waterfall import Waterfall, waterfall

__all__ = [
    "basins",
    "bifurcation",
    "envelope",
    "load_map",
    "modes",
    "poincare_section",
    "spectrogram",
    "spectrum",
    "waterfall",
]


AnyMap: TypeAlias = Basins | Bifurcation | PoincareSection | Waterfall
KINDS: dict[str, type[AnyMap]] = {
    kind.file_kind: kind for kind in (Basins, Bifurcation, PoincareSection, Waterfall)
}


@with_faults()
def load_map(path: str | Path) -> AnyMap:
    """Return the diagram, section, basins or waterfall of a map file, as far as it is computed.

    path: the map file

    Raises RunFileError for any other file.
    """
    with MapFile.open(path) as file:
        kind = KINDS.get(str(file.spec.get("what")))
        if kind is None:
            raise RunFileError(
                f"{path}: this map file was written by another version of vfife; make the map again"
            )
        with standing_in(entries := file.get("meta", OWN_LAWS, "json") or ()):
            result = kind.read(file)
        vars(result)["own_laws"] = entries
    warn_of_damage(
        Path(path), "map", file.damage, "Repeat the command that made it: it computes the missing rows."
    )
    return result
