"""Errors of a static analysis by its mesh and its residual, from the same with twice the elements."""

from __future__ import annotations

from collections.abc import Mapping

from ..solvers.fictitious_mass import extent
from ..solvers.record import Estimate, Record
from .equilibria import static_measures
from .measured import Measured

FIRST_ORDER = 2.0  # times the difference to twice the elements: an error of first order; one of second order is 4/3 of it
FLOOR = 0.1  # of the error of the value that is known worst, relative to its size: two meshes may agree by chance
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that
IDLE = 100.0  # times the unbalanced force: what carries less carries nothing
EXACT = ("load_factor", "iterations", "unbalanced.max")  # what says how the analysis went has no error
KINDS = ("displacement.max", "force.max", "moment.max", "torque.max", "penetration.max")


def mesh_estimate(record: Record, finer: Record) -> Estimate:
    """Errors of the measures of a static analysis, from those with twice the elements.

    One refinement shows no order. So the first is taken, though elements converge with the second. No error is taken to be smaller than what the
    unbalanced forces leave open.
    """
    own, other = static_measures(record), static_measures(finer)
    errors = {name: FIRST_ORDER * abs(value - other[name]) for name, value in own.items() if name in other}
    size = sizes(record, own)
    floor = FLOOR * max((errors[name] / one for name, one in size.items() if name in errors), default=0.0)
    residual, lever = record.assembly.mechanism.settings.residual, extent(record.assembly, record.assembly.state)
    load = largest_load(own, lever)
    for name, error in errors.items():
        left = residual * load * (lever if name.endswith((".moment.max", ".torque.max")) else name.endswith(".force.max"))
        errors[name] = 0.0 if name in EXACT else max(error, floor * size.get(name, abs(own[name])), left)
    return Estimate(None, errors)


def largest_load(found: Mapping[str, float], lever: float) -> float:
    """The largest force (N) of joints, moments over a ``lever`` (m) with them."""
    moments = max((value for name, value in found.items() if name.endswith((".moment.max", ".torque.max"))), default=0.0)
    return max(moments / lever, *(value for name, value in found.items() if name.endswith(".force.max")), 0.0)


def sizes(record: Record, found: Mapping[str, float]) -> dict[str, float]:
    """The size of each largest value, or a tenth of the largest of its kind where it is less; what carries nothing has none."""
    lever = extent(record.assembly, record.assembly.state)
    idle = IDLE * record.assembly.mechanism.settings.residual * largest_load(found, lever)
    limits = {"force.max": idle, "moment.max": idle * lever, "torque.max": idle * lever}
    result = {}
    for kind in KINDS:
        members = {name: value for name, value in found.items() if name == kind or name.endswith(f".{kind}")}
        floor = LEAST * max(members.values(), default=0.0)
        result.update({name: max(value, floor) for name, value in members.items() if value > limits.get(kind, 0.0)})
    return result


def spreads(record: Record, found: Mapping[str, Measured]) -> dict[str, float]:
    """Width of the range of each largest value over its size (1), by name."""
    size = sizes(record, {name: one.value for name, one in found.items()})
    return {name: found[name].width / one for name, one in size.items() if found[name].estimated}
