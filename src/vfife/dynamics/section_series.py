"""Preparation common to all maps: step and series from short runs, limits of the model, the locked map file,
and the count of its work.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import product, takewhile
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, StepError, VfifeError, suggestion
from ..job.cost import LANES, TANGENTS, WORTH, Forecast, cores, run_cost, timed_step
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter, numbers
from ..results.view import View, standing
from ..schema import Measure
from ..simulation.result import Result
from ..simulation.simulate import carry_out, prepare
from ..solvers.arguments import RunArguments
from ..solvers.lyapunov import steps_of_turn
from ..solvers.record import Record
from ..solvers.status import Status
from ..solvers.tangents import Neighbours
from ..solvers.transient import choose_loop
from ..solvers.turn_runner import TurnRunner, carried_on
from ..store.lock import Lock
from ..store.mapfile import MapFile
from ..store.store import Store

Array = NDArray[np.float64]
# Turns of the run that finds a step. In ten a run sees that its turns do not repeat: then it halves its step
# less often.
SEARCH_TURNS = 10.0
# Turns and outputs of each by which series are compared.
PROBE_TURNS, PROBE_OUTPUTS = 2, 36
# A series varies if its range exceeds this share of the largest value of its kind. Sums in another order
# change the last ten bits at most.
VARIATION = 1e-6
MOTIONS = (
    ("angular_velocity",),
    ("x", "y"),
)  # of a body, by kinds that have one unit; places tell wells apart, speeds at rest do not


def run_step(model: Mechanism) -> float:
    """Find the step of a run of ten turns, as ``vfife run`` finds it.

    Returns the step (s). Raises ModelError for a model that is not stepped as a straight line,
    KeyboardInterrupt if the run is interrupted.
    """
    prepared = prepare(model, RunArguments(turns=SEARCH_TURNS))
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

    These are the penetration and the largest force at the first contact of which both vary. If there is none,
    it is the angular velocity of the last body, or, if that is constant, the place or speed of a body with
    the largest range as a share of the largest of its kind. A body that a driver turns counts only if nothing
    else varies.
    """
    bodies, known = list(assembly.bodies), set(standing(assembly).series)
    places = zip(assembly.contacts, assembly.contact_joints, strict=True)
    journals = [
        pair
        for one, joint in places
        if known.issuperset(pair := (f"{one}.penetration", f"{joint}.force_max"))
    ]
    kinds = [
        [name for body in bodies for what in kind if (name := f"{body}.{what}") in known] for kind in MOTIONS
    ]
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
    """Range of each series over the first turns, as a share of the largest absolute value of its kind; 0 for
    series that are not finite.
    """
    kinds = [list(kind) for kind in kinds]
    names = [name for kind in kinds for name in kind]
    motion, every = TurnRunner([assembly]), max(1, steps_of_turn(assembly) // PROBE_OUTPUTS)
    motion.runner.advance(1, 1)
    rows = motion.record(every, PROBE_TURNS * PROBE_OUTPUTS)[:, :, 0]
    values = dict(zip(names, looked(assembly, motion.kept, rows, names, every).T, strict=True))
    found = {}
    for kind in kinds:
        size = max((float(np.abs(values[name]).max()) for name in kind), default=0.0)
        for name in kind:
            share = float(np.ptp(values[name])) / size if size > 0.0 else 0.0
            found[name] = share if np.isfinite(share) else 0.0
    return found


def looked(
    assembly: Assembly, kept: NDArray[np.uint32], rows: Array, series: Sequence[str], steps: int
) -> Array:
    """What series are once a turn, of rows recorded then, shape (turns, kept): shape (turns, series)."""
    found = np.zeros((len(rows), len(series)))
    if not len(rows):
        return found
    result = Result(Record(assembly, np.arange(1, len(rows) + 1, dtype=np.int64) * steps, rows, kept))
    for j, name in enumerate(series):
        found[:, j] = result.series.column(name).values
    return found


Own = TypeVar("Own", bound=Store)
DROPPED = 2 / 3  # of the turns, that are not looked at unless said
NEAR = 1e-6  # of a number, by which the difference begins that is watched
LIKELY = (
    ".clearance",
    ".coefficient",
    ".restitution",
    ".damping",
    ".stiffness",
    ".mass",
    ".inertia",
)  # numbers that move no pin, the first first
MOST_COUNTS = 16
COUNTS: OrderedDict[tuple[tuple[str, ...], float | None, bool], int] = (
    OrderedDict()
)  # steps in a turn, as they were found


def stepped(model: Mechanism, steps: int) -> Assembly:
    """A model assembled with so many steps in a turn."""
    return assemble(model, (turn_of(model) or 0.0) / steps, turns=1, outputs=1, force_step=True)


def models_along(mechanism: Mechanism, ranges: Sequence[tuple[str, float, float]]) -> list[Mechanism]:
    """The model in the middle of ``ranges`` (path, from, to) and at every corner of them; itself where none
    of them is of the model.
    """
    text, own = dump(mechanism), [one for one in ranges if not one[0].startswith("start.")]
    paths = [path for path, _, _ in own]
    places = [
        *product(*((low, high) for _, low, high in own)),
        tuple(0.5 * (low + high) for _, low, high in own),
    ]
    return [loads(text, set=list(zip(paths, place, strict=True))) for place in places] if own else [mechanism]


def refuse_idle(mechanism: Mechanism, turns: int, dropped: int) -> None:
    """Raises ModelError where there are no turns, or none is left to look at."""
    faults = []
    if turn_of(mechanism) is None:
        faults.append(
            Fault(
                "driver",
                "no crank turns at constant speed, so there is no turn to look at once",
                "",
                "",
                "drive a body",
            )
        )
    if not 0 <= dropped < turns:
        faults.append(
            Fault(
                "dropped", "no turn is left to look at", str(dropped), f"0 to {turns - 1}", "drop fewer turns"
            )
        )
    if faults:
        raise ModelError(faults, mechanism.name)


def left_out(dropped: int | None, turns: int, share: float = DROPPED) -> int:
    """Turns that are not looked at, of so many: a share of them unless said, so that one is left."""
    return turns - max(1, round((1.0 - share) * turns)) if dropped is None else dropped


def step_count(models: Sequence[Mechanism], step: float | None, search: bool = False) -> int:
    """Steps in a turn, enough for all models: those of ``step`` (s), else of the automatic step; with a
    ``search`` of the step that a run finds.

    Raises ModelError for a step that is too large for one of them. What was found for models of the same text
    is known: a command asks for its forecast first.
    """
    key = tuple(dump(model) for model in models), step, search
    if (found := COUNTS.get(key)) is not None:
        return found
    counts = []
    for model in models:
        if step is not None:
            refuse_large(model, step)
        size = (
            step
            if step is not None
            else (
                run_step(model)
                if search
                else prepare(model, RunArguments(turns=1.0, companions=0)).assembly.choice.step
            )
        )
        counts.append(math.ceil((turn_of(model) or 0.0) / size * (1.0 - 1e-9)))
    COUNTS[key] = max(counts)
    if len(COUNTS) > MOST_COUNTS:
        COUNTS.popitem(last=False)
    return max(counts)


def refuse_large(model: Mechanism, step: float) -> None:
    """Raises ModelError for a step that the model is not stable with."""
    try:
        assemble(model, step, turns=1.0, outputs=1)
    except StepError as error:
        limit = str(error).partition(": ")[2].partition(";")[0]
        raise ModelError(
            [Fault("step", "this is not taken", f"{step:g} s", limit, "give another")], model.name
        ) from None


def chosen_series(first: Assembly, series: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Series that are looked at, those that are asked for or the usual ones, and their units. Raises
    ModelError for a name that there is not.
    """
    chosen, start = tuple(series) or default_series(first), standing(first)
    refuse_unknown(
        "series",
        chosen,
        list(start.series),
        "the mechanism has none of this name",
        "name one that it has",
        first.mechanism.name,
    )
    return chosen, tuple(unit_of(start, name) for name in chosen)


def refuse_unknown(
    where: str, names: Sequence[str], known: Sequence[str], what: str, otherwise: str, model: str
) -> None:
    """Raises ModelError with all names that are not known, each with the one that is meant, or what to do
    ``otherwise``.
    """
    wrong = [
        Fault(where, what, name, "", suggestion(name, known, otherwise))
        for name in names
        if name not in known
    ]
    if wrong:
        raise ModelError(wrong, model)


def unit_at(mechanism: Mechanism, path: str) -> str:
    """Unit of the number at a path. Raises ValueError where there is none."""
    try:
        number = Parameter(mechanism, path)
    except Fault as fault:
        raise ValueError(f"{path}: {fault.what}; {fault.remedy}") from None
    if not isinstance(number.field, Measure):
        at = path.split(".")
        alike = lambda name: sum(  # noqa: E731
            1 for _ in takewhile(lambda both: both[0] == both[1], zip(name.split("."), at, strict=False))
        )
        known = sorted(numbers(mechanism), key=alike, reverse=True)
        raise ValueError(f"{path}: this is no number of the model; {suggestion(path, known, 'name one')}")
    return number.unit


def unit_of(start: View, series: str) -> str:
    """Unit of a series."""
    return start.series.column(series).unit


def seed(mechanism: Mechanism, first: Assembly, steps: int) -> Neighbours:
    """Two models to both sides in a number that moves no pin: the difference between motions that is watched
    begins as one of it.
    """
    known = {path: value for path, value in numbers(mechanism).items() if value}
    rank = {
        path: next((k for k, end in enumerate(LIKELY) if path.endswith(end)), len(LIKELY)) for path in known
    }
    for path in sorted(rank, key=rank.__getitem__):
        value = known[path]
        with suppress(VfifeError):
            both = [
                stepped(Parameter(mechanism, path).set(value * (1.0 + sign * NEAR)), steps)
                for sign in (1.0, -1.0)
            ]
            moves = np.abs(both[0].state - both[1].state)[first.layout.of("parameter")].any()
            if moves and all(carried_on(first, one) is None for one in both):
                return Neighbours(both[0], both[1], 2.0 * NEAR * value)
    raise ModelError(
        [Fault("model", "none of its numbers can be changed a little, so no motion nearby is known")],
        mechanism.name,
    )


def law_words(mechanism: Mechanism) -> str:
    """Contact and friction laws of a model, joint by joint where they differ."""
    by: dict[str, list[str]] = {}
    for name, joint in mechanism.contacts.items():
        by.setdefault(f"contact {joint.contact.name}, friction {joint.friction.name}", []).append(name)
    return (
        "; ".join(words if len(by) == 1 else f"{', '.join(names)}: {words}" for words, names in by.items())
        or "no contacts"
    )


def kept_in(
    file: str | Path | None, said: Mapping[str, Any], what: str = "this map"
) -> AbstractContextManager[MapFile | None]:
    """The file of a map: see :func:`kept_as`."""
    return kept_as(MapFile, file, said, what)


@contextmanager
def kept_as(
    kind: type[Own], file: str | Path | None, said: Mapping[str, Any], what: str
) -> Iterator[Own | None]:
    """A file of a ``kind``, locked: a new one, or one that asks the same; None where nothing is to be kept.

    Raises VfifeError for one that asks something else, HeldError where another process writes ``what`` is in
    it.
    """
    if file is None:
        yield None
        return
    path = Path(file)
    with Lock(path.absolute().parent, f"{path.name}.lock", what):
        said = {key: value if isinstance(value, str) else _listed(value) for key, value in said.items()}
        with kind.resume(path, said) as found:
            yield found


def _listed(asked: Any) -> dict[str, Any]:
    """What is asked as JSON has it."""

    def plain(value: Any) -> Any:
        return [plain(one) for one in value] if isinstance(value, tuple) else value

    return {key: plain(value) for key, value in vars(asked).items()}


def tupled(said: Mapping[str, Any]) -> dict[str, Any]:
    """What is asked as JSON has it, with tuples for lists."""

    def nested(value: Any) -> Any:
        return tuple(map(nested, value)) if isinstance(value, list) else value

    return {key: nested(value) for key, value in said.items()}


# --------------------------------------------------------------------------------------------------------------- forecast


STRUCK = 1.8  # a step that is searched for onsets of contact, by one that is not
COMPANION_STEPS = 2.8  # steps of both companions of a case, by its own
COMPRESSED = 0.8  # bytes of a map file, by those of its numbers
START, TURNED_START = (
    0.02,
    0.06,
)  # s to assemble a start and to classify its motion; where the crank is turned to it first
ALIGNING = 10  # turns in which a small difference turns into its direction of growth


@dataclass(frozen=True)
class MapWork:
    """What a map computes: ``cases`` of so many ``turns``, the first of them ``dropped``, of ``steps`` each,
    in so many ``lanes`` at once.

    ``numbers`` of a turn are kept; ``companions`` cases are repeated with other steps; ``growth``: a small
    difference is followed; ``struck``: onsets of contact are searched for; ``start``: time (s) to assemble
    one.
    """

    noun: str
    cases: int
    turns: int
    dropped: int
    steps: float
    lanes: int
    numbers: float
    companions: int = 0
    growth: bool = True
    struck: bool = False
    start: float = START
    first_look: tuple[int, int] = (0, 0)  # cases and turns that suffice for one

    def turns_of_one(self) -> float:
        """Turns of a single lane that take as long as a case, all cores being at work."""
        if self.lanes not in TANGENTS:  # a stream of runs, as in a study
            return self.turns * LANES[8] / (cores() * self.lanes)
        plain, derived = LANES[self.lanes], TANGENTS[self.lanes]
        before = max(0, self.dropped - ALIGNING) if self.growth else self.turns
        first, second = plain * before, derived * (self.turns - before)
        if (
            self.lanes == 2
        ):  # a second thread follows the differences of two cases at once, while the motion goes on
            second = 0.5 * TANGENTS[4] * (self.turns - before)
            return max(plain * self.turns, second) if cores() > 1 else plain * self.turns + second
        if self.lanes == 1:
            return first + max(second, STRUCK * (self.turns - self.dropped) * self.struck)
        return (first + second) / (self.lanes * cores())

    def brief(self) -> MapWork:
        """The first look at the same: fewer cases of fewer turns."""
        cases, turns = self.first_look
        return replace(
            self, cases=min(self.cases, cases), turns=turns, dropped=self.dropped * turns // self.turns
        )

    def forecast(self, assembly: Assembly, file: str | Path | None) -> Forecast:
        """The forecast of the cases that the file does not have; the time of a step is measured where there
        is much to do.
        """
        cost, left = run_cost(assembly), max(self.cases - known_cases(file), 0)
        seconds = self._seconds(step := 1e-9 * cost.ns_per_step, left)
        if seconds > WORTH and cost.loop == "generated":
            seconds = self._seconds(step := timed_step(assembly), left)
        size = COMPRESSED * 8 * (self.turns - self.dropped) * self.numbers
        size += 8 * assembly.layout.rows * self.lanes * (self.lanes < 3)  # the state to go on from
        look = self.brief()
        first = look._seconds(step, look.cases) if left == self.cases and look.turns else math.inf
        threads = min(cores(), 2) if self.lanes < 3 else cores()
        return Forecast(
            self.noun,
            left,
            self.steps * self.turns,
            seconds,
            disk=size * left,
            threads=threads,
            first_look=first,
        )

    def _seconds(self, step: float, left: int) -> float:
        each = step * self.steps * self.turns_of_one() + self.start * (self.lanes > 2) / cores()
        return each * (left + COMPANION_STEPS * min(self.companions, left))


def known_cases(file: str | Path | None) -> int:
    """Cases that a map file has."""
    if file is None or not Path(file).exists():
        return 0
    try:
        with MapFile.open(Path(file)) as known:
            return len(known.keys("legs"))
    except VfifeError:  # reported when the map goes on with it
        return 0
