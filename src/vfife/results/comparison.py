"""What runs of one mechanism under several laws came to."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..files import write_named
from ..model.above import NotebookDocument
from .view import View


@dataclass
class Comparison(NotebookDocument):
    """What the runs came to. ``rows`` holds one flat map a run, ``results`` the runs themselves, both in the
    order of the laws.

    A row has ``contact`` and ``friction`` (names), ``status``, ``force`` (N, the largest of the joints whose
    laws were changed), ``lip_force`` and ``lip_acceleration`` (%, the largest; None without a reference),
    ``penetration`` (m), ``impacts``, ``contact_share`` (of the time, mean of the joints), ``energy_lost`` (J,
    in damping and friction of the joints), ``energy_error``, ``wall_s``, ``part`` (of the run, that largest
    values are of), and ``joints``: each joint's numbers.
    """

    mechanism: str
    joints: tuple[str, ...]
    rows: list[dict[str, Any]] = field(default_factory=list)
    results: list[View] = field(default_factory=list)
    reference: View | None = None
    planned: int = 0

    def __repr__(self) -> str:
        return (
            f"<Comparison of {len(self.rows)} runs of {self.mechanism!r}; see .rows, .results, .write_csv()>"
        )

    def flat(self) -> list[dict[str, Any]]:
        """A map for every run and joint, for tables."""
        whole = ("status", "part", "lip_acceleration", "energy_lost", "energy_error", "wall_s")
        return [
            {
                "contact": row["contact"],
                "friction": row["friction"],
                "joint": name,
                **numbers,
                **{key: row[key] for key in whole},
            }
            for row in self.rows
            for name, numbers in row["joints"].items()
        ]

    def write_csv(self, path: str | Path) -> None:
        """Writes :meth:`flat` as a table of commas."""
        flat = self.flat()
        write_named(path, list(dict.fromkeys(key for row in flat for key in row)), flat)
