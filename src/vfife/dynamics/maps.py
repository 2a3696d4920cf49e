"""What all maps share: results, keyword options, the file from which an interrupted map continues, the choice
of series, and the forecast of work.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import product, takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, VfifeError, former_names, suggestion
from ..files import DataTable, share_done
from ..job.cost import LANES, TANGENTS, WORTH, Forecast, cores, run_cost, timed_step
from ..job.job import job_of
from ..laws.stored import standing_in
from ..model.functions import crank_faults
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.parameter import Parameter, numbers
from ..options import Watch
from ..report.html import NotebookDocument
from ..results.provenance import own_laws
from ..schema import Integer, Measure
from ..simulation.turn_steps import step_count, with_steps
from ..solvers.arguments import LARGEST_COUNT, Arguments
from ..solvers.tangents import Neighbours
from ..solvers.turn_runner import discontinuity
from ..store.studyfile import MapFile, locked_file, stored_cases

Array = NDArray[np.float64]
OWN_LAWS = "own_laws"  # entry of the meta of a map file
# Remedy for a model without a crank whose base or load is periodic.
YOKE = (
    "drive a body; for a harmonic slider or point, drive a crank that moves it as a Scotch yoke, and for a"
    " harmonic load, a rotor that counts its periods (docs: Periodic or chaotic)"
)
Range = tuple[str, float, float]  # path of a number, its lowest and its highest value (SI)


# ---------------------------------------------------------------------------------------------------- results


class MapSpec:
    """Base class of the specifications of maps: frozen dataclasses whose first field, ``model``, is the text
    of the model.
    """

    @classmethod
    def of(cls, stored: Mapping[str, Any]) -> Self:
        """Return the specification stored in a map file, with tuples for the lists of JSON."""

        def nested(value: Any) -> Any:
            return tuple(map(nested, value)) if isinstance(value, list) else value

        return cls(**{key: nested(value) for key, value in stored.items()})


@former_names(asked="spec", told="step_report", alike="agreement")
@dataclass(frozen=True, repr=False)
class Map(NotebookDocument, DataTable):
    """A map, as far as it is computed: the model's ``name`` and the specification ``spec``."""

    file_kind: ClassVar[str]  # in map files
    noun: ClassVar[str] = "values"  # what is computed one after the other
    own_laws = ()  # entries of the user's laws in a map file that was read
    name: str
    spec: Any
    if TYPE_CHECKING:  # a field or a property

        @property
        def done(self) -> int:
            """Number of values, turns or starts that are computed."""

    @property
    def planned(self) -> int:
        """Number of values, turns or starts of a complete map."""
        return len(self.spec.values)

    @property
    def progress(self) -> str:
        """How much is computed, as in "12 of 100 values"; empty for a complete map."""
        return share_done(self.done, self.planned, self.noun)

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with laws of the user that are not loaded as they are recorded in the map file."""
        with standing_in(self.own_laws):
            return loads(self.spec.model)

    @property
    def laws(self) -> str:
        """Contact and friction laws of the model as text, joint by joint where they differ."""
        joints: dict[str, list[str]] = {}
        mechanism = self.mechanism
        for name, joint in mechanism.contacts.items():
            has_none = getattr(joint.friction, "coefficient", None) == 0.0
            friction = "no friction" if has_none else f"friction {joint.friction.name}"
            joints.setdefault(f"contact {joint.contact.name}, {friction}", []).append(name)
        parts = [
            words if len(joints) == 1 else f"{', '.join(names)}: {words}" for words, names in joints.items()
        ]
        stops = [name for name, spring in mechanism.springs.items() if spring.axes == "stop"]
        if stops:
            parts.append(f"contact at the stop{'s' * (len(stops) > 1)} {', '.join(stops)}")
        return "; ".join(parts) or "no contacts"


def finite(value: Any) -> float | str:
    """Return an exponent for a table: empty where it is not known, or below any number."""
    return float(value) if math.isfinite(value) else ""


# ---------------------------------------------------------------------------------------------------- running


class RunOptions(Watch, total=False):
    """Keywords of all maps."""

    turns: int
    series: Sequence[str]  # by their names in ``result.series``
    step: float | str | None  # s
    file: str | Path | None  # keeps what is computed; the same call continues it


class MapOptions(RunOptions, total=False):
    """Keywords of maps that record a motion once a turn."""

    dropped: int | None  # first turns, which are not recorded
    phase: float  # 1: position of the record in a turn


MAP_DEFAULTS: dict[str, Any] = {"series": (), "phase": 0.0, "confirm": False}


@dataclass
class MapRun:
    """The computation of a map by the public function ``caller``, with the function's keywords.

    ``turns`` are simulated for each case; ``step`` (s) is the largest step; ``file`` stores what is computed.
    """

    caller: str
    turns: int
    series: Sequence[str] = ()
    step: Any = None
    file: str | Path | None = None
    progress: Any = None
    confirm: bool = False

    def __post_init__(self) -> None:
        report, arguments = self.progress, Arguments(self.caller)
        arguments.count("turns", self.turns, optional=False)
        self.step: float | None = arguments.quantity("step", self.step, "s")
        arguments.callable("progress", report)
        arguments.file("file", self.file)
        self.series = arguments.names("series", self.series)
        self.read(arguments)
        arguments.check()
        self.job = job_of(
            self.caller, self.file, self.confirm, report, lambda state: report(state.done, state.steps)
        )

    def read(self, arguments: Arguments) -> None:
        """Read the keywords of a kind of map."""

    def begin(self, work: MapWork, assembly: Assembly) -> None:
        """Start the job with the forecast of its work; ask for confirmation if it is long. Raises ModelError
        where the folder of the file is missing, which the job of a command makes.
        """
        self.job.begin(work.forecast(assembly, self.file))
        arguments = Arguments(self.caller)
        arguments.folder("file", self.file)
        arguments.check()

    @contextmanager
    def rows(self, kind: type[Map], name: str, spec: MapSpec, content: str = "this map") -> Iterator[MapRows]:
        """Open the rows of a map while it is computed; ``content`` names the map in messages.

        Ctrl-C ends the computation without an error, even if no row is complete.
        """
        with (
            self.job,
            locked_file(
                MapFile, self.file, {"what": kind.file_kind, "name": name, "asked": vars(spec)}, content
            ) as file,
        ):
            rows = MapRows(file)
            rows.keep_laws(loads(spec.model))  # type: ignore[attr-defined]
            try:
                yield rows
            except KeyboardInterrupt:
                self.job.interrupted()


@dataclass
class TurnRun(MapRun):
    """The computation of a map that records motions once a turn, at a ``phase`` (1) of it.

    The first ``dropped`` turns are not recorded; unless given, their number is the share ``dropped_share``
    (1) of all.
    """

    dropped: Any = None
    phase: float = 0.0
    dropped_share: float = 2 / 3

    def read(self, arguments: Arguments) -> None:
        """Read the dropped turns, None for the share, and the phase."""
        self.dropped = arguments.read("dropped", Integer(0, LARGEST_COUNT), self.dropped)
        self.phase = arguments.read("phase", Measure("1", low=0.0, high=1.0), self.phase) or 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.dropped is None:
            self.dropped = self.turns - max(1, round((1.0 - self.dropped_share) * self.turns))

    def step_count(self, models: Sequence[Mechanism]) -> int:
        """Return the number of steps in a turn, the same for all models.

        Raises ModelError if the mechanism has no turns or all turns are dropped.
        """
        faults = crank_faults(models[0], "there is no turn to look at once", YOKE)
        if not 0 <= self.dropped < self.turns:
            limit = f"0 to {self.turns - 1}"
            faults.append(Fault("dropped", "no turn remains", str(self.dropped), limit, "drop fewer turns"))
        if faults:
            raise ModelError(faults, models[0].name)
        return step_count(models, self.step, search=True)

    def work(self, noun: str, cases: int, steps: int, lanes: int, **options: Any) -> MapWork:
        """Return the work of this computation: ``cases``, called ``noun`` in messages, with ``steps`` in a
        turn and ``lanes`` side by side; ``options`` are further fields of :class:`MapWork`.
        """
        options = {"numbers": len(self.series or (1, 1)) + 1, **options}
        return MapWork(noun, cases, self.turns, self.dropped, steps, lanes, **options)


@dataclass
class MapRows:
    """Rows of a map: those in its file, if there is one, and those added since, by number in ``done``."""

    file: MapFile | None
    done: dict[int, Any] = field(default_factory=dict)

    def legs(self, gaps: bool) -> dict[int, tuple[Array, Array]]:
        """Return points and growth of the rows in the file by number; ``gaps`` includes rows after a missing
        one.
        """
        return {} if self.file is None else self.file.legs(gaps)

    def array(self, key: str) -> Array | None:
        """Return an array in the file, or None."""
        return None if self.file is None else self.file.array(key)

    def keep_laws(self, mechanism: Mechanism) -> None:
        """Write the user's own laws into the file, if there is one: it can then be read without them. Raises
        VfifeError if its values were computed with others.
        """
        if self.file is None or not (laws := own_laws(mechanism)):
            return
        stored = self.file.get("meta", OWN_LAWS, "json")
        if stored is None:
            self.file.put({OWN_LAWS: laws})
        elif [law["text"] for law in stored] != [law["text"] for law in laws]:
            names = ", ".join(law["name"] for law in laws)
            raise VfifeError(
                f"{self.file.path}: this map was computed with another text of the law {names}; name another"
                " file, or load the former text"
            )

    def write(self, table: str, key: str | int, *values: Any) -> None:
        """Write a row into the file, if there is one."""
        if self.file is not None:
            self.file.write_row(table, key, *values)


# ----------------------------------------------------------------------------------------------------- models


def models_along(mechanism: Mechanism, ranges: Sequence[Range]) -> list[Mechanism]:
    """Return the models at every corner and in the middle of ``ranges``; the model itself if all ranges are
    of numbers of its start.

    The step of a map has to suffice for all of its cases, and a step is found by runs: corners and middle
    are the cases that are tried.
    """
    text, of_model = (
        dump(mechanism),
        [interval for interval in ranges if not interval[0].startswith("start.")],
    )
    if not of_model:
        return [mechanism]
    paths = [path for path, _, _ in of_model]
    places = [
        *product(*((low, high) for _, low, high in of_model)),
        tuple(0.5 * (low + high) for _, low, high in of_model),
    ]
    return [loads(text, set=list(zip(paths, place, strict=True))) for place in places]


def unit_at(mechanism: Mechanism, path: str) -> str:
    """Return the unit of the parameter at a path. Raises ValueError for a path that leads to no number."""
    try:
        number = Parameter(mechanism, path)
    except Fault as fault:
        # A map needs one number: neither a list of paths nor a text of the model is suggested.
        general = fault.remedy.startswith(("did you mean", "list the paths"))
        remedy = suggestion(path, numbers(mechanism), "name one") if general else fault.remedy
        raise ValueError(f"{path}: {fault.what}; {remedy}") from None
    if (misfit := number.misfit) is not None:
        raise ValueError(f"{path}: {misfit.what}; {misfit.remedy}")
    if not isinstance(number.field, Measure):
        keys = path.split(".")

        def shared_keys(name: str) -> int:
            pairs = zip(name.split("."), keys, strict=False)
            return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))

        paths = number.elements or sorted(numbers(mechanism), key=shared_keys, reverse=True)
        raise ValueError(f"{path}: this is not a number of the model; {suggestion(path, paths, 'name one')}")
    return number.unit


# Neighbouring motions differ at first by the effect of a parameter that is changed by this share of itself.
NEIGHBOUR_SHARE = 1e-6
# Endings of paths of parameters that move no pin, in the order in which they are tried.
LIKELY = (".clearance", ".coefficient", ".restitution", ".damping", ".stiffness", ".mass", ".inertia")


def neighbours_of(mechanism: Mechanism, first: Assembly, steps: int) -> Neighbours:
    """Return two models that differ slightly in one parameter; the growth of the difference between their
    motions is the Lyapunov exponent.

    The parameter must move no pin, because the same positions have to be a start of both models. Raises
    ModelError if the model has no such parameter.
    """
    values = {path: value for path, value in numbers(mechanism).items() if value}
    rank = {
        path: next((k for k, end in enumerate(LIKELY) if path.endswith(end)), len(LIKELY)) for path in values
    }
    for path in sorted(rank, key=rank.__getitem__):
        value = values[path]
        with suppress(VfifeError):
            number = Parameter(mechanism, path)
            up, down = (
                with_steps(number.set(value * (1.0 + sign * NEIGHBOUR_SHARE)), steps) for sign in (1.0, -1.0)
            )
            # The change must reach the state's parameters: a number of an output, for example, does not.
            moves = np.abs(up.state - down.state)[first.layout.of("parameter")].any()
            if moves and discontinuity(first, up) is None and discontinuity(first, down) is None:
                return Neighbours(up, down, 2.0 * NEIGHBOUR_SHARE * value)
    message = "no number of it can be changed slightly, so there is no neighbouring motion to compare with"
    raise ModelError([Fault("model", message)], mechanism.name)


# --------------------------------------------------------------------------------------------------- forecast

# Ratio of the time of a step with recorded contact onsets to that of a step without.
IMPACTS = 1.8
# Ratio of the steps of both companions of a case to its own: 0.8 + 2.0.
COMPANION_STEPS = 2.8
# Ratio of the bytes of a map file to those of its numbers.
COMPRESSED = 0.8
# Time (s) to assemble a start and to classify its motion; the second if the crank is turned to the start.
START, TURNED_START = 0.02, 0.06
# Turns in which a small difference aligns with the direction of its largest growth.
ALIGNING = 10


@dataclass(frozen=True)
class MapWork:
    """The amount of work of a map: ``cases`` of ``turns`` turns of ``steps`` steps, the first ``dropped``
    turns not recorded, in ``lanes`` side by side.

    ``noun`` names a case in messages. ``numbers`` are stored per turn. ``companions`` cases are repeated with
    other steps, ``companion_steps`` times those of a case. ``growth``: a small difference is followed.
    ``impacts``: contact onsets are recorded. ``start``: time (s) to assemble a case. ``first_look``: cases
    and turns of a quick trial. ``note`` ends the sentence of the forecast.
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
    impacts: bool = False
    start: float = START
    first_look: tuple[int, int] = (0, 0)
    companion_steps: float = COMPANION_STEPS
    note: str = ""

    def turns_of_one(self) -> float:
        """Return the number of turns of a single lane that take as long as a case, with all cores working."""
        if self.lanes not in TANGENTS:  # a stream of runs, as in a study
            return self.turns * LANES[8] / (cores() * self.lanes)
        plain, derived = LANES[self.lanes], TANGENTS[self.lanes]
        plain_turns = max(0, self.dropped - ALIGNING) if self.growth else self.turns
        first, second = plain * plain_turns, derived * (self.turns - plain_turns)
        if self.lanes == 2:  # a second thread follows the differences, while the motion goes on
            return max(plain * self.turns, second) if cores() > 1 else plain * self.turns + second
        if self.lanes == 1:
            return first + max(second, IMPACTS * (self.turns - self.dropped) * self.impacts)
        return (first + second) / (self.lanes * cores())

    def brief(self) -> MapWork:
        """Return the work of a quick trial of the same map: fewer cases of fewer turns."""
        cases, turns = self.first_look
        return replace(
            self, cases=min(self.cases, cases), turns=turns, dropped=self.dropped * turns // self.turns
        )

    def forecast(self, assembly: Assembly, file: str | Path | None) -> Forecast:
        """Return the forecast for the cases that are not in ``file``; measure the time of a step if the
        tabled cost promises long work.
        """
        cost, left = run_cost(assembly), max(self.cases - stored_cases(file), 0)
        seconds = self._seconds(step := 1e-9 * cost.ns_per_step, left)
        if seconds > WORTH and cost.loop == "generated":
            seconds = self._seconds(step := timed_step(assembly), left)
        size = COMPRESSED * 8 * (self.turns - self.dropped) * self.numbers
        # A sweep in two chains stores the state from which its next value continues.
        size += 8 * assembly.layout.rows * self.lanes * (self.lanes < 3)
        brief = self.brief()
        first = brief._seconds(step, brief.cases) if left == self.cases and brief.turns else math.inf
        threads = min(cores(), 2) if self.lanes < 3 else cores()
        return Forecast(
            self.noun,
            left,
            self.steps * self.turns,
            seconds,
            disk=size * left,
            threads=threads,
            first_look=first,
            note=self.note,
        )

    def _seconds(self, step: float, left: int) -> float:
        seconds_per_case = step * self.steps * self.turns_of_one() + self.start * (self.lanes > 2) / cores()
        return seconds_per_case * (left + self.companion_steps * min(self.companions, left))
