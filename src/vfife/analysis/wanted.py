"""Which measures are wanted, by name, and what it takes to know them: a row for each turn, or all of its outputs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from ..solvers.record import Record
from .losses import losses
from .measures import OVER_TURN, PEAKS, Measure, compared, last_turn, over_run, taken
from .wear import worn_volumes

Beside = Callable[[Sequence[Record]], dict[str, float]]
ENDINGS: dict[str, tuple[str, ...]] = {
    "largest_loads": (".force.max", ".moment.max"),
    "deepest_penetrations": (".penetration.max",),
    "largest_accelerations": (".angular_acceleration.max", ".torque.max"),
    "driving": (".torque.mean", ".torque.ripple", ".power.mean"),
    "losses": (".friction_energy.total", ".impact_energy.total", ".friction_power.mean", ".impact_power.mean"),
    "largest_sliding": (".sliding_velocity.max", ".sliding_distance.total"),
    "largest_pressures": (".contact_pressure.max", ".contact_half_width.max", ".pressure_velocity.max", ".pressure_velocity.mean"),
    "largest_strokes": (".position.low", ".position.high", ".velocity.max", ".acceleration.max"),
    "largest_shaking": (".shaking_force.max", ".shaking_moment.max"),
    "largest_stresses": (".tension.max", ".compression.max", ".stress.place"),
    "largest_deflections": (".deflection.max",),
    "efficiency": ("mechanism.efficiency",),
    "worn_volumes": (".bearing_wear.total", ".journal_wear.total"),
    "worn_depths": (".bearing_wear_depth.max", ".journal_wear_depth.max"),
}  # of names, by the measure that gives them
INFLUENCE = (".force.lip", ".angular_acceleration.lip")
COUNTED = (
    ".impacts", ".grazing", ".deep_landings", ".landing_depth.max", ".approach_speed.max",
    ".share.free_flight", ".share.impact", ".share.continuous_contact",
)  # fmt: skip
BY_TURN: tuple[Measure, ...] = (*PEAKS, losses, worn_volumes)  # what the largest of extremes and the last of all else in a turn tell


def of_whole_runs(names: Sequence[str]) -> list[str]:
    """Those names that measures of a whole run have, whichever of its turns are looked at."""
    return [name for name in names if name.endswith(COUNTED) and "(" not in name]


class WantedMeasures:
    """Measures by ``names``, all without any; ``beside`` gives more of turns that are recorded output by output."""

    def __init__(self, names: Sequence[str] = (), beside: Beside | None = None) -> None:
        self.names, self.beside = tuple(names), beside
        self.peaks = not names or any(name.endswith(INFLUENCE) for name in names)
        self.counts = not names or any(name.endswith(COUNTED) for name in names)
        self.every = tuple(
            measure
            for measure in OVER_TURN
            if not names or (self.peaks and measure in PEAKS) or any(name.endswith(ENDINGS[measure.__name__]) for name in names)
        )

    @property
    def by_turn(self) -> bool:
        """Whether one row for each turn tells them all."""
        return self.beside is None and set(self.every) <= set(BY_TURN)

    def over(self, turns: Sequence[Record], reference: Mapping[str, float] | None) -> dict[str, float]:
        """Means over turns, each a record that begins with the output before it; counts up to the end of the last one."""
        turnly = []
        for turn in turns:
            found = taken(self.every, turn, last_turn(turn))
            turnly.append(found | (compared(turn, found, reference) if self.peaks else {}))
        mean: dict[str, float] = {}
        for name in turnly[-1]:
            values = [turn[name] for turn in turnly if name in turn]
            mean[name] = values[0] if len(values) == 1 else math.fsum(values) / len(values)
        mean |= over_run(turns[-1]) if self.counts else {}
        mean |= self.beside(turns) if self.beside is not None else {}
        return {name: mean[name] for name in self.names if name in mean} if self.names else mean
