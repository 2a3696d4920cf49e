"""Measures that are what rounding leaves of zero, beside the largest of their unit; they have no
derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from ...assembly.assembled import Assembly
from ...assembly.timestep import size_of
from ...measures.catalogue import INFLUENCE, unit_of
from ...measures.statics import MOMENT

ROUNDING = 1e-9  # of the largest measure of its unit: below it a measure is what rounding leaves of nothing
PURE = "1", "%"


def silent_moments(assembly: Assembly, values: Mapping[str, float]) -> dict[str, float]:
    """Return moments of ideal joints that hold a turn and are exactly zero, which a run leaves out.

    Whether such a moment is 0 or 1e-45 N m is decided by rounding, on which no answer may depend.
    """
    holders = [name for name, turn in zip(assembly.ideals, assembly.topology.joint_turn, strict=True) if turn]
    return {f"{joint}{MOMENT}": 0.0 for joint in holders if f"{joint}{MOMENT}" not in values}


def floors(assembly: Assembly, values: Mapping[str, float]) -> dict[str, float]:
    """Return scales of moments (N m) and angular accelerations (rad/s^2): those that the largest force of a
    mechanism makes on its largest arm.

    Rounding of a force leaves that much, times the precision, of moments and of turning that are zero; the
    largest measure of the same unit may be such a remainder itself.
    """
    force = max((value for name, value in values.items() if name.endswith(".force.max")), default=0.0)
    moment = force * size_of(assembly.mechanism)
    inertia = min((body.inertia for body in assembly.bodies.values() if body.inertia > 0.0), default=math.inf)
    return {"N m": moment, "rad/s^2": moment / inertia}


def rounding(
    measures: Mapping[str, float],
    changes: Mapping[str, float] = MappingProxyType({}),
    scales: Mapping[str, float] = MappingProxyType({}),
) -> frozenset[str]:
    """Return the measures that are remainders of rounding, compared with the largest of their unit.

    ``changes``: the largest change of a measure (SI) by 100 % of any number; a measure that crosses zero is
    no remainder. Measures relative to the ideal mechanism are judged by their measure; shares and counts are
    not. ``scales``: sizes by unit from elsewhere (:func:`floors`).
    """
    sizes = {name: max(abs(value), changes.get(name, 0.0)) for name, value in measures.items()}
    units, largest = {name: unit_of(name) for name in measures}, dict(scales)
    for name, size in sizes.items():
        largest[units[name]] = max(largest.get(units[name], 0.0), size)
    small = {
        name for name, unit in units.items() if unit not in PURE and sizes[name] <= ROUNDING * largest[unit]
    }
    relative = (name for name in measures if name.endswith(INFLUENCE))
    return frozenset(small.union(name for name in relative if f"{name.removesuffix('lip')}max" in small))
