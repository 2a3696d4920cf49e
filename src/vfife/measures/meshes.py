"""Errors of a static analysis by its mesh and its residual, from the same with other numbers of elements."""

from __future__ import annotations

from collections.abc import Mapping

from ..solvers.record import Estimate, Record
from ..solvers.refinement import FOUR_TIMES, HALF, TWICE
from ..solvers.relaxation import extent
from .catalogue import MOMENT, static_measures
from .measured import Measured

# times the difference to twice the elements, which is three times an error of second order (Roache's grid
# convergence index)
TWO_MESHES = 4.0
THREE_MESHES = 1.25  # times the error that three meshes tell, by the same author
FASTEST, SLOWEST = (
    0.25,
    0.75,
)  # ratio of a difference to that before it, from one halving to the next: second order, and hardly any
FLOOR = (
    0.1  # of the error of the value that is known worst, relative to its size: two meshes may agree by chance
)
LEAST = 0.1  # of the largest of its kind: what is smaller is compared with that
IDLE = 100.0  # times the unbalanced force: what carries less carries nothing
EXACT = ("load_factor", "iterations", "unbalanced.max")  # what says how the analysis went has no error
MOVED = "displacement.max"
KINDS = (MOVED, "force.max", "moment.max", "torque.max", "penetration.max")


def mesh_estimate(record: Record, others: Mapping[float, Record]) -> Estimate | None:
    """Errors of the measures of a static analysis, from those on other meshes; None without the one of twice
    the elements.

    ``others``: by their share of the elements, see :func:`~vfife.solvers.refinement.other_meshes`. No error
    is taken to be smaller than what the unbalanced forces leave open, nor than FLOOR times that of the value
    that is known worst.
    """
    if TWICE not in others:
        return None
    own, found = static_measures(record), {share: static_measures(one) for share, one in others.items()}
    names = [name for name in own if name in found[TWICE] or name.endswith(MOMENT)]
    errors = {
        name: error_of(own[name], {share: _of(one, name) for share, one in found.items()}) for name in names
    }
    errors[MOVED] = max(
        errors[MOVED], TWO_MESHES * abs(own[MOVED] - found[TWICE][MOVED])
    )  # between nodes, which two meshes may miss alike
    size = sizes(record, own)
    floor = FLOOR * max((errors[name] / one for name, one in size.items() if name in errors), default=0.0)
    residual, lever = (
        record.assembly.mechanism.settings.residual,
        extent(record.assembly, record.assembly.state),
    )
    load = largest_load(own, lever)
    for name, error in errors.items():
        left = (
            residual
            * load
            * (lever if name.endswith((".moment.max", ".torque.max")) else name.endswith(".force.max"))
        )
        errors[name] = 0.0 if name in EXACT else max(error, floor * size.get(name, abs(own[name])), left)
    return Estimate(None, errors)


def _of(found: Mapping[str, float], name: str) -> float:
    """A measure on another mesh; a moment that is zero there is none of its measures."""
    return found.get(name, 0.0)


def error_of(own: float, others: Mapping[float, float]) -> float:
    """Error of a value from those with other shares of the elements, twice as many among them.

    Differences continue as a geometric series, whose ratio is that of the two, between FASTEST and SLOWEST. A
    second difference that is small by chance counts as what the first lets expect.
    """
    change = abs(own - others[TWICE])
    if HALF in others:
        first, second, known = abs(others[HALF] - own), change, 0.0
        expected = first * FASTEST / (1.0 - FASTEST)
    elif FOUR_TIMES in others:
        first, second, known = change, abs(others[TWICE] - others[FOUR_TIMES]), abs(own - others[FOUR_TIMES])
        expected = first / (1.0 - FASTEST)
    else:
        return TWO_MESHES * change
    ratio = min(max(second / first if first > 0.0 else SLOWEST, FASTEST), SLOWEST)
    left = second / (1.0 - ratio) if HALF in others else known + second * ratio / (1.0 - ratio)
    return THREE_MESHES * max(left, expected)


def largest_load(found: Mapping[str, float], lever: float) -> float:
    """The largest force (N) of joints, moments over a ``lever`` (m) with them."""
    moments = max(
        (value for name, value in found.items() if name.endswith((".moment.max", ".torque.max"))), default=0.0
    )
    return max(moments / lever, *(value for name, value in found.items() if name.endswith(".force.max")), 0.0)


def sizes(record: Record, found: Mapping[str, float]) -> dict[str, float]:
    """The size of each largest value, or a tenth of the largest of its kind where it is less; what carries
    nothing has none.
    """
    lever = extent(record.assembly, record.assembly.state)
    idle = IDLE * record.assembly.mechanism.settings.residual * largest_load(found, lever)
    limits = {"force.max": idle, "moment.max": idle * lever, "torque.max": idle * lever}
    result = {}
    for kind in KINDS:
        members = {name: value for name, value in found.items() if name == kind or name.endswith(f".{kind}")}
        floor = LEAST * max(members.values(), default=0.0)
        result.update(
            {name: max(value, floor) for name, value in members.items() if value > limits.get(kind, 0.0)}
        )
    return result


def spreads(record: Record, found: Mapping[str, Measured]) -> dict[str, float]:
    """Width of the range of each largest value over its size (1), by name."""
    size = sizes(record, {name: one.value for name, one in found.items()})
    return {name: found[name].width / one for name, one in size.items() if found[name].estimated}
