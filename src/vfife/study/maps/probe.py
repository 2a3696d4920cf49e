"""Short runs before a map: the step that a run of the model finds, and series that vary in its motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...assembly.assembled import Assembly
from ...errors import Fault, ModelError
from ...model.mechanism import Mechanism
from ...result import Result
from ...results.channels import entities
from ...results.view import standing
from ...simulation import carry_out, prepare
from ...solvers.arguments import Asked
from ...solvers.nearby import plain_runner, steps_of_turn
from ...solvers.record import Record
from ...solvers.status import Status
from ...solvers.transient import choose_loop

Array = NDArray[np.float64]
# Turns of the run that finds a step. In ten a run sees that its turns do not repeat: then it halves its step less often.
SEARCH_TURNS = 10.0
# Turns and outputs of each by which series are compared.
PROBE_TURNS, PROBE_OUTPUTS = 2, 36
# A series varies if its range exceeds this share of the largest value of its kind. Sums in another order change the last ten bits at most.
VARIATION = 1e-6
MOTIONS = (("angular_velocity",), ("x", "y"))  # of a body, by kinds that have one unit; places tell wells apart, speeds at rest do not


def run_step(model: Mechanism) -> float:
    """Find the step of a run of ten turns, as ``vfife run`` finds it.

    Returns the step (s). Raises ModelError for a model that is not stepped as a straight line, KeyboardInterrupt if the run is interrupted.
    """
    prepared = prepare(model, Asked(turns=SEARCH_TURNS))
    refuse_large_frame(prepared.assembly)
    record = carry_out(prepared).record
    if record.status == Status.INTERRUPTED:
        raise KeyboardInterrupt
    return record.assembly.choice.step


def refuse_large_frame(assembly: Assembly) -> None:
    """Raises ModelError for what is too large to be stepped as a straight line."""
    if choose_loop(assembly, "auto") != "generated":
        fault = Fault("body", "a frame of so many elements is not swept", "", "", "use fewer elements")
        raise ModelError([fault], assembly.mechanism.name)


def default_series(assembly: Assembly) -> tuple[str, ...]:
    """Choose series that vary in the first turns of a motion.

    These are the penetration and the largest force at the first contact of which both vary. If there is none, it is the angular velocity of the
    last body, or, if that is constant, the place or speed of a body with the largest range as a share of the largest of its kind. A body that a
    driver turns counts only if nothing else varies.
    """
    bodies, known = list(assembly.bodies), set(standing(assembly).series)
    places = zip(assembly.contacts, assembly.contact_joints, strict=True)
    journals = [pair for one, joint in places if known.issuperset(pair := (f"{one}.penetration", f"{joint}.force_max"))]
    kinds = [[name for body in bodies for what in kind if (name := f"{body}.{what}") in known] for kind in MOTIONS]
    found = variations(assembly, [*((name,) for pair in journals for name in pair), *kinds])
    for pair in journals:
        if all(found[name] > VARIATION for name in pair):
            return pair
    last = f"{bodies[-1]}.angular_velocity"
    if found.get(last, 0.0) > VARIATION:
        return (last,)
    driven = set(assembly.mechanism.drivers)
    moving = [name for kind in kinds for name in kind if found[name] > VARIATION]
    free = [name for name in moving if name.rpartition(".")[0] not in driven]
    return (max(free or moving, key=found.__getitem__, default=last),)


def variations(assembly: Assembly, kinds: Iterable[Sequence[str]]) -> dict[str, float]:
    """Range of each series over the first turns, as a share of the largest absolute value of its kind; 0 for series that are not finite."""
    kinds = [list(kind) for kind in kinds]
    names = [name for kind in kinds for name in kind]
    runner, every = plain_runner([assembly]), max(1, steps_of_turn(assembly) // PROBE_OUTPUTS)
    runner.advance(1, 1)
    rows = runner.advance(every, PROBE_TURNS * PROBE_OUTPUTS)[:, :, 0]
    values = dict(zip(names, looked(assembly, runner.kept, rows, names, every).T, strict=True))
    found = {}
    for kind in kinds:
        size = max((float(np.abs(values[name]).max()) for name in kind), default=0.0)
        for name in kind:
            share = float(np.ptp(values[name])) / size if size > 0.0 else 0.0
            found[name] = share if np.isfinite(share) else 0.0
    return found


def looked(assembly: Assembly, kept: NDArray[np.uint32], rows: Array, series: Sequence[str], steps: int) -> Array:
    """What series are once a turn, of rows recorded then, shape (turns, kept): shape (turns, series)."""
    found = np.zeros((len(rows), len(series)))
    if not len(rows):
        return found
    result = Result(Record(assembly, np.arange(1, len(rows) + 1, dtype=np.int64) * steps, rows, kept))
    for j, name in enumerate(series):
        variable, entity, label = result.series.place(name)
        values = result.channels[variable].values
        place = entities(result.record)[entity].index(str(label)) if entity is not None else 0
        found[:, j] = values[:, place] if entity is not None else values
    return found
