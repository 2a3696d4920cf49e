"""State of a run where a turn begins and ends between two outputs, for sums and means over turns.

The torque of a crank without a flywheel may exceed its mean a thousand times. A turn that is cut at the
output nearest to its end is up to half an output too long or too short, and then its mean power is wrong by
any amount. Works are therefore interpolated at the exact ends: by the cubic that has the work and the power
of both neighbouring outputs. All other numbers, whose rates are not recorded, are interpolated linearly.

The error of this interpolation is estimated by a second one (:func:`other_state_at`), a cubic through the
works of four outputs: where both agree, outputs resolve the curve. An impact spends its energy at an instant,
which no curve through outputs can place: where one begins between the two outputs, the second interpolation
has its loss at the farther one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..solvers.record import Record, TurnEnds, places
from ..solvers.repeating import TurnGrid, outputs_per_turn

Array = NDArray[np.float64]
CONTACT_LOSSES = "contact_damping", "contact_friction"
WORKS = (
    *CONTACT_LOSSES,
    "damping",
    "external",
    "spring_damping",
    "driven",
    "actuator",
)  # blocks of work and power
FOUR = 4  # outputs through which the second interpolation goes


def ends_of_last_turn(record: Record) -> TurnEnds | None:
    """Return the ends of the turn that ends with a record; None if both are outputs, if it is shorter than a
    turn, or if its outputs around the beginning are not all there.
    """
    choice = record.assembly.choice
    if record.static or choice.turn is None or outputs_per_turn(choice) is not None or len(record.steps) < 2:
        return None
    end = float(record.steps[-1])
    begin = end - choice.turn / choice.step
    k = _left(record, begin)
    if begin < -0.5 or record.steps[k + 1] - record.steps[k] > choice.outputs_every:
        return None
    return TurnEnds(np.array([begin, end]), np.stack([state_at(record, begin), record.rows[-1]]))


def ends_of_turn(record: Record, grid: TurnGrid, turn: int, last: int, missing: int = 0) -> TurnEnds | None:
    """Return the ends of a ``turn`` of a run, counted from 1, of which ``last`` is evaluated last; None if
    turns are whole numbers of outputs. ``missing``: outputs of the run that the record lacks at its start.
    """
    if grid.has_integral_turns:
        return None
    steps = exact_steps(record, grid, turn, last, missing)
    return TurnEnds(steps, np.stack([state_at(record, float(step)) for step in steps]))


def exact_steps(record: Record, grid: TurnGrid, turn: int, last: int, missing: int = 0) -> Array:
    """Return where a ``turn`` begins and ends (steps), shape (2,).

    If the ``last`` turn ends after the last output, all turns are earlier by that part of an output, so that
    no value is extrapolated.
    """
    later = max(0.0, last * grid.exact - (missing + len(record.steps) - 1))
    return np.array([turn - 1, turn]) * grid.exact * record.assembly.choice.outputs_every - (
        later * record.assembly.choice.outputs_every
    )


def ends_of_companion(companion: Record, run: Record, ends: TurnEnds) -> TurnEnds:
    """Return the ends of a turn of a companion, of which only two outputs are stored, those nearest to the
    ``ends`` of the turn of its run.

    From an output to the exact end its numbers change as those of the run do, and its works by the difference
    of both powers, too.
    """
    columns = places(run.row_numbers, companion.row_numbers)
    ratio = companion.assembly.choice.outputs_every / run.assembly.choice.outputs_every
    rows = []
    for k, step in enumerate(ends.steps):
        output = round(float(companion.steps[k]) / ratio)
        row_of_run = run.rows[int(np.searchsorted(run.steps, output))]
        former = companion.rows[k] if output else row_of_run[columns]  # before the first step all are alike
        row = former + (ends.rows[k] - row_of_run)[columns]
        time = (float(step) - output) * run.assembly.choice.step
        half_run, half = 0.5 * run.assembly.choice.step, 0.5 * companion.assembly.choice.step
        for work, power in _columns(companion):
            change = row[power] - former[power]  # of the power, which sums contain for half a step
            row[work] += (former[power] - row_of_run[columns[power]]) * time + (half - half_run) * change
        rows.append(row)
    return TurnEnds(ends.steps * ratio, np.stack(rows))


def state_at(record: Record, step: float) -> Array:
    """Return the recorded rows at a ``step`` between two outputs, shape (rows,): linear but for works, which
    are cubic.
    """
    k = _left(record, step)
    first, second = np.array(record.rows[k]), np.array(record.rows[k + 1])
    interval = float(record.steps[k + 1] - record.steps[k])
    s = (step - float(record.steps[k])) / interval
    row = (1.0 - s) * first + s * second
    dt = record.assembly.choice.step
    for work, power in _columns(record):
        # W_n = work - dt/2 power; Hermite's cubic less its chord.
        done = (second[work] - first[work]) - 0.5 * dt * (second[power] - first[power])
        begin, end = (interval * dt * rate[power] - done for rate in (first, second))
        row[work] += s * (1.0 - s) * ((1.0 - s) * begin - s * end)
    return row


def other_state_at(record: Record, step: float) -> Array:
    """Return the rows at a ``step`` by the interpolation that shows the error of the first, shape (rows,)."""
    k = _left(record, step)
    first = min(max(k - 1, 0), max(len(record.steps) - FOUR, 0))
    nodes, rows = (values[first : first + FOUR] for values in (record.steps, record.rows))
    other_nodes = [np.delete(nodes, j).astype(float) for j in range(len(nodes))]
    weights = [
        float(np.prod((step - rest) / (float(node) - rest)))
        for node, rest in zip(nodes, other_nodes, strict=True)
    ]
    row = np.sum([weight * values for weight, values in zip(weights, rows, strict=True)], axis=0)
    return _with_impacts(record, row, k, step)


def _with_impacts(record: Record, row: Array, k: int, step: float) -> Array:
    """Return rows with the losses of an impact between the outputs ``k`` and ``k + 1`` at the one farther
    from the ``step``, and the work of drivers on its chord.
    """
    if not record.assembly.contacts or not record.keeps("contact_onsets"):
        return row
    onsets = _of(record, "contact_onsets")
    struck = np.array(record.rows[k + 1])[onsets] > np.array(record.rows[k])[onsets]
    near = step - float(record.steps[k]) < float(record.steps[k + 1]) - step
    half, farther = 0.5 * record.assembly.choice.step, np.array(record.rows[k + 1 if near else k])
    for name in CONTACT_LOSSES if struck.any() else ():
        work, power = (_of(record, f"{name}_{kind}")[struck] for kind in ("work", "power"))
        row[work] = farther[work] + half * (row[power] - farther[power])
    for name in ("driven", "actuator"):
        if not struck.any() or not record.keeps(f"{name}_work"):
            continue
        work, power = _of(record, f"{name}_work"), _of(record, f"{name}_power")
        ends = [np.array(record.rows[j]) for j in (k, k + 1)]
        s = (step - float(record.steps[k])) / float(record.steps[k + 1] - record.steps[k])
        first, second = (values[work] - half * values[power] for values in ends)
        row[work] = (1.0 - s) * first + s * second + half * row[power]
    return row


def _left(record: Record, step: float) -> int:
    """Return the number of the output before a step, of which there is a next one."""
    return int(np.clip(np.searchsorted(record.steps, step, side="right") - 1, 0, len(record.steps) - 2))


def _columns(record: Record) -> list[tuple[Any, Any]]:
    """Return the columns of each recorded work and of its power."""
    return [
        (_of(record, f"{name}_work"), _of(record, f"{name}_power"))
        for name in WORKS
        if record.keeps(f"{name}_work") and record.keeps(f"{name}_power")
    ]


def _of(record: Record, name: str) -> NDArray[np.intp]:
    """Return the columns of a block among the recorded rows."""
    return places(record.row_numbers, record.assembly.layout[name])
