"""What is known of a mechanism before a run, for scripts and notebooks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..assembly.assembled import Assembly
from ..model.mechanism import Mechanism
from . import described


@dataclass(frozen=True)
class Checked:
    """A mechanism without faults: ``free`` degrees of freedom with ideal joints, ``after_drives`` with the drivers at work, what is ``redundant``.

    ``step`` (s) is the one that a run begins with, ``set_by`` what sets it; ``notes`` are sentences on what to be careful with.
    """

    name: str
    bodies: int
    joints: int
    free: int
    after_drives: int
    redundant: tuple[str, ...]
    step: float
    set_by: str
    notes: tuple[str, ...]

    def __str__(self) -> str:
        counts = f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}, {self.joints} joint{'s' * (self.joints != 1)}"
        lines = [
            f"{self.name}: no faults; {counts}.",
            f"Degrees of freedom with ideal joints: {self.free}; {self.after_drives} with the drivers at work.",
        ]
        if self.redundant:
            lines.append(f"Redundant constraints, at {', '.join(self.redundant)}: rigid links do not determine how these joints share their load.")
        if self.step > 0.0:
            lines.append(f"Step {self.step:.4g} s, set by {self.set_by}.")
        return "\n".join([*lines, *self.notes])

    __repr__ = __str__


def told(assembly: Assembly) -> Checked:
    """What is known of a mechanism that is assembled."""
    mechanism, freedom = assembly.mechanism, described.freedom(assembly)
    return Checked(
        name=mechanism.name, bodies=len(mechanism.bodies), joints=len(mechanism.joints), free=freedom["free"],
        after_drives=freedom["after_drives"], redundant=tuple(freedom["redundant_joints"]) if freedom["redundant"] else (),
        step=assembly.choice.step, set_by=assembly.choice.culprit, notes=tuple(assembly.notes),
    )  # fmt: skip


def parts(mechanism: Mechanism) -> list[tuple[str, list[tuple[str, ...]]]]:
    """Tables of what a mechanism is made of: a title, then rows, the first of them the heads."""
    nouns: dict[str, Any] = {**mechanism.gears, **mechanism.springs}
    drivers = [(name, described.driver(one), one.body or one.slider or one.point) for name, one in mechanism.drivers.items()]
    loads = [(name, one.words, one.place) for name, one in mechanism.loads.items()]
    tables: list[tuple[str, list[tuple[str, ...]]]] = [
        ("Bodies", [("body", "model", "pins"), *((n, b.model, ", ".join(b.points)) for n, b in mechanism.bodies.items())]),
        ("Joints", [("joint", "what", "bearing", "journal"), *((n, j.words, j.bearing, j.journal) for n, j in mechanism.joints.items())]),
        ("Gears and springs", [("name", "what", "between"), *((n, one.words, f"{one.first} and {one.second}") for n, one in nouns.items())]),
        ("Drivers", [("driver", "what", "of"), *drivers]),
        ("Loads", [("load", "what", "at"), *loads]),
    ]
    return [(title, rows) for title, rows in tables if len(rows) > 1]
