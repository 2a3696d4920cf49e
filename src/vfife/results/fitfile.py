"""A file of a fit: its specification, every point that was evaluated, and what was found in the end."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunFileError
from .fitted import Fit, Laid, Value
from .schemas import FIT, Schema
from .store import Store, warn_of_damage

Array = NDArray[np.float64]
Evaluation = tuple[str, dict[str, Any], Array | None]  # key of what was evaluated, what is known of it, numbers
CURVES = ("places", "measured", "model")


class FitFile(Store):
    """A fit file. Points are known by the hash of what was evaluated, so a fit that goes on, one with further points and one that was not
    interrupted are the same.
    """

    schema: ClassVar[Schema] = FIT

    def add_points(self, points: Sequence[Evaluation]) -> None:
        """Write points that were evaluated at once, all or none of them."""
        with self.transaction():
            for point in points:
                self.insert("looks", *point)

    def point(self, key: str) -> tuple[dict[str, Any], Array | None] | None:
        """A point that was evaluated; None for one that is missing or damaged."""
        row = self.row("looks", key)
        return None if row is None else (row["told"], row["data"])

    def conclude(self, found: Fit, method: Mapping[str, Any]) -> None:
        """Write what was found and by which method, in the place of what was found before."""
        numbers = np.stack([getattr(one, part) for one in found.curves for part in CURVES], axis=1)
        self.write_row("found", "fit", {"how": method, "fit": plain(found)}, numbers)

    def fit(self, method: Mapping[str, Any] | None = None) -> Fit | None:
        """What was found, if by this method; None where it was not, or that is damaged."""
        row = self.row("found", "fit")
        said = {} if row is None else row["told"]
        if row is None or (method is not None and said["how"] != json.loads(json.dumps(method))):
            return None
        return whole(said["fit"], row["data"])


def plain(found: Fit) -> dict[str, Any]:
    """A fit as JSON has it, but the numbers of its curves."""
    said: dict[str, Any] = {one.name: getattr(found, one.name) for one in dataclasses.fields(found)}
    names = [one.name for one in dataclasses.fields(Laid) if one.name not in CURVES]
    return said | {
        "values": [dataclasses.asdict(one) for one in found.values],
        "correlation": found.correlation.tolist(),
        "directions": [[size, way.tolist()] for size, way in found.directions],
        "curves": [{name: getattr(one, name) for name in names} for one in found.curves],
    }


def whole(said: Mapping[str, Any], numbers: Array) -> Fit:
    """A fit from its parts; ``numbers`` has the columns of ``CURVES`` for each curve."""
    columns = iter(numbers.T)
    parts: dict[str, Any] = {
        "values": [Value(**{**one, "paths": tuple(one["paths"]), "bounds": tuple(one["bounds"])}) for one in said["values"]],
        "curves": [Laid(**one, **{part: next(columns) for part in CURVES}) for one in said["curves"]],
        "correlation": np.array(said["correlation"]),
        "directions": [(size, np.array(way)) for size, way in said["directions"]],
        "starts": [(cost, tuple(place)) for cost, place in said["starts"]],
    }
    return Fit(**{**said, **parts})


def load_fit(path: str | Path) -> Fit:
    """The fit in a fit file. Raises RunFileError for any other file, and for a fit that was interrupted before its end."""
    with FitFile.open(path) as file:
        found = file.fit()
        if found is None:
            kept = f"{len(file.keys('looks')):,} points are kept in it"
            if file.damage:
                raise RunFileError(file.damaged("; ".join(file.damage)))
            raise RunFileError(f"{file.path}: this fit has not come to its end, and {kept}; give the command that began it again")
    warn_of_damage(Path(path), "fit", file.damage, "Give the command that made it again: it computes what is gone.")
    return found
