"""What a load factor acts on, in the place of time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..assembly.assembled import Assembly
from ..kernels.polynomial import polynomial
from ..kernels.topology import FREE, SPEED, TIME
from ..kinematics.forces import Datum, actions
from ..numerics.elementwise import hypot

if TYPE_CHECKING:
    from .relaxation import Relaxation


class Loading:
    """What the load factor acts on: tables of functions, weights and drivers of an assembly, written into a relaxation's S and T."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly, self.layout, t = assembly, assembly.layout, assembly.topology
        scaled = [action.steady for action in actions(assembly.mechanism, Datum()) for _ in action.ends]
        self.loads = dict(zip(t.load_function, scaled, strict=True))
        self.arguments = t.function_argument or ((TIME, 0, 0),) * len(t.function_start)
        self.speeds = [k for k, f in enumerate(t.driven_function) if f < 0]
        angles = [f for f, (_, turn) in zip(t.joint_function, t.held, strict=True) if turn != FREE]
        self.turns = {f for f in (*t.driven_function, *angles) if f >= 0}
        self.motions = sorted({f for f in (*t.driven_function, *t.joint_function) if f >= 0})

    def value(self, function: int, factor: float) -> float:
        """Value of a function of time under a load factor."""
        start = self.assembly.topology.function_start[function]
        if self.loads.get(function, False):
            return factor * float(polynomial(self.assembly.tables, start, 0.0)[0])
        return float(polynomial(self.assembly.tables, start, factor)[0])

    def force(self, factors: Sequence[float], size: float) -> float:
        """Sum of all loads at the largest factor (N), moments as forces on a lever of ``size`` (m)."""
        state, t = self.assembly.state, self.assembly.topology
        total = sum(float(np.abs(state[self.layout[f"particle_load_{axis}"]]).sum()) for axis in "xy") * max(abs(f) for f in factors)
        for k, function in enumerate(t.load_function):
            fx, fy, moment = (float(state[self.layout.row(f"load_{axis}", k)]) for axis in ("fx", "fy", "m"))
            total += (float(hypot(fx, fy)) + abs(moment) / size) * max(abs(self.value(function, f)) for f in factors)
        return total

    def motion(self, old: float, new: float) -> tuple[float, float]:
        """Largest turn (rad) and travel (m) of the drivers between two load factors."""
        speed = self.assembly.state[self.layout["driven_speed"]]
        turns = [abs(float(speed[k]) * (new - old)) for k in self.speeds]
        moved = {f: abs(self.value(f, new) - self.value(f, old)) for f in self.motions}
        turns += [size for f, size in moved.items() if f in self.turns]
        return max(turns, default=0.0), max((size for f, size in moved.items() if f not in self.turns), default=0.0)

    def go(self, relaxation: Relaxation, old: float, new: float, count: int) -> None:
        """Writes what leads from one factor to another in ``count`` iterations, motions evenly; at once where ``count`` is 0."""
        start, state = self.assembly.state, relaxation.state
        now = float(relaxation.runner.done)
        for name in ("particle_load_x", "particle_load_y", "particle_load_m", "driven_weight_x", "driven_weight_y"):
            state[self.layout[name]] = new * start[self.layout[name]]
        for k in self.speeds:
            angle, speed = (float(start[self.layout.row(f"driven_{name}", k)]) for name in ("angle", "speed"))
            rate = speed * (new - old) / count if count else 0.0
            state[self.layout.row("driven_speed", k)] = rate
            state[self.layout.row("driven_angle", k)] = angle + speed * (old if count else new) - rate * now
        for function in range(len(self.arguments)):
            self._table(relaxation, function, old, new, count, now)

    def _table(self, relaxation: Relaxation, function: int, old: float, new: float, count: int, now: float) -> None:
        tables, t = relaxation.runner.functions, self.assembly.topology
        at, argument = t.function_start[function], self.arguments[function][0]
        if argument in (TIME, SPEED):
            before, after = self.value(function, old), self.value(function, new)
            linear = count > 0 and function in self.motions
            line = (before if linear else after, (after - before) / count if linear else 0.0)
            tables[at : at + 10] = 1.0, now, *line, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            return
        pieces = int(self.assembly.tables[at])
        first = at + (1 + pieces if pieces > 0 else 3 - pieces)
        last = first + 7 * abs(pieces)
        tables[first:last] = new * self.assembly.tables[first:last]
