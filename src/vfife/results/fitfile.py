"""One SQLite file of a fit: what is asked, every point that was looked at, and what was found in the end."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from . import tables
from .askedfile import AskedFile
from .fitted import Fit, Laid, Value
from .header import FIT_APPLICATION, FIT_FORMAT
from .packing import packed, unpacked
from .tables import told
from .tally import warn_of_damage

Array = NDArray[np.float64]
Row = tuple[str, dict[str, Any], Array | None]  # key of what was looked at, what is told of it, numbers
CURVES = ("places", "measured", "model")


class FitFile(AskedFile):
    """A fit file. Points are known by the hash of what was looked at, so a fit that goes on, one that looks further and one that nobody stopped
    are the same.
    """

    kind: ClassVar[str] = "fit"
    application: ClassVar[int] = FIT_APPLICATION
    version: ClassVar[int] = FIT_FORMAT
    schema: ClassVar[list[str]] = tables.FIT_SCHEMA
    rows: ClassVar[dict[str, str]] = {"looks": "points", "found": "results"}

    @told
    def keep(self, rows: Sequence[Row]) -> None:
        """Keeps points that were looked at together, all or none of them."""
        with self._transaction():
            for key, said, numbers in rows:
                self._insert("looks", key, json.dumps(said), b"" if numbers is None else packed(numbers))

    @told
    def look(self, key: str) -> tuple[dict[str, Any], Array | None] | None:
        """A point that was looked at; None for one that is missing or damaged."""
        row = tables.sound(self._connection, "looks", key)
        return None if row is None else (json.loads(row[1]), unpacked(row[2]) if row[2] else None)

    @told
    def count(self) -> int:
        """Points that are kept, derivatives among them."""
        return len(tables.keys(self._connection, "looks"))

    @told
    def conclude(self, found: Fit, how: Mapping[str, Any]) -> None:
        """Keeps what was found, and how it was looked for, in the place of what was found before."""
        numbers = packed(np.stack([getattr(one, part) for one in found.curves for part in CURVES], axis=1))
        with self._transaction():
            self._insert("found", "fit", json.dumps({"how": how, "fit": plain(found)}), numbers)

    @told
    def found(self, how: Mapping[str, Any] | None = None) -> Fit | None:
        """What was found, if it was looked for so; None where it was not, or that is damaged."""
        row = tables.sound(self._connection, "found", "fit")
        said = {} if row is None else json.loads(row[1])
        if row is None or (how is not None and said["how"] != json.loads(json.dumps(how))):
            return None
        return whole(said["fit"], unpacked(row[2]))


def plain(found: Fit) -> dict[str, Any]:
    """A fit as JSON has it, but the numbers of its curves."""
    said: dict[str, Any] = {one.name: getattr(found, one.name) for one in dataclasses.fields(found)}
    said["values"] = [dataclasses.asdict(one) for one in found.values]
    said["correlation"] = found.correlation.tolist()
    said["directions"] = [[size, way.tolist()] for size, way in found.directions]
    names = [one.name for one in dataclasses.fields(Laid) if one.name not in CURVES]
    said["curves"] = [{name: getattr(one, name) for name in names} for one in found.curves]
    return said


def whole(said: dict[str, Any], numbers: Array) -> Fit:
    """A fit from its parts."""
    values = [Value(**{**one, "paths": tuple(one["paths"]), "bounds": tuple(one["bounds"])}) for one in said["values"]]
    curves = []
    for k, one in enumerate(said["curves"]):
        parts: dict[str, Any] = {part: numbers[:, len(CURVES) * k + place] for place, part in enumerate(CURVES)}
        curves.append(Laid(**one, **parts))
    given = said | {
        "values": values,
        "curves": curves,
        "correlation": np.array(said["correlation"]),
        "directions": [(size, np.array(way)) for size, way in said["directions"]],
        "starts": [(cost, tuple(place)) for cost, place in said["starts"]],
    }
    return Fit(**given)


def load_fit(path: str | Path) -> Fit:
    """The fit in a fit file. Raises RunFileError for any other file, and for a fit that has not come to its end."""
    with FitFile.open(Path(path)) as file:
        found = file.found()
        if found is None:
            kept = f"{file.count():,} points are kept in it"
            if file.damage:
                raise RunFileError(tables.damaged(file, "; ".join(file.damage)))
            raise RunFileError(f"{file.path}: this fit has not come to its end, and {kept}; give the command that began it again")
    warn_of_damage(Path(path), "fit", file.damage, "Give the command that made it again: it computes what is gone.")
    return found
