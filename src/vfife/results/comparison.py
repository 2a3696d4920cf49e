"""Comparison of runs of one mechanism under several laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..files import DataTable, named_rows
from .run_data import RunData


@dataclass
class Comparison(DataTable):
    """Results of a mechanism under several laws. ``rows`` has one map for each run, ``results`` the runs,
    both in the order of the laws.

    A row has ``contact`` and ``friction`` (names), ``status``, ``force`` (N, largest of the joints with
    changed laws), ``lip_force`` and ``lip_acceleration`` (%, largest; None without a reference),
    ``penetration`` (m), ``impacts``, ``contact_share`` (of the time, mean over joints), ``energy_lost`` (J,
    in damping and friction of the joints), ``energy_error``, ``wall_s``, ``part`` (of the run, over which
    extremes are taken), and ``joints``: the numbers of each joint.
    """

    mechanism: str
    joints: tuple[str, ...]
    rows: list[dict[str, Any]] = field(default_factory=list)
    results: list[RunData] = field(default_factory=list)
    reference: RunData | None = None
    planned: int = 0

    def __repr__(self) -> str:
        return (
            f"<Comparison of {len(self.rows)} runs of {self.mechanism!r}; see .rows, .results,"
            " .to_dataframe()>"
        )

    def flat(self) -> list[dict[str, Any]]:
        """Return the rows by run and joint, for tables."""
        of_run = ("status", "part", "lip_acceleration", "energy_lost", "energy_error", "wall_s")
        return [
            {
                "contact": row["contact"],
                "friction": row["friction"],
                "joint": name,
                **numbers,
                **{key: row[key] for key in of_run},
            }
            for row in self.rows
            for name, numbers in row["joints"].items()
        ]

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield heads, then :meth:`flat` as rows."""
        return named_rows(self.flat())
