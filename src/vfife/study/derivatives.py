"""Which number matters: the derivative of every measure by every number of a model, from one run whose steps carry their derivatives along."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from statistics import median
from typing import Any, TypeAlias

from ..analysis.measures import OVER_TURN, Measure, last_turn, over_turn
from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, VfifeError, suggestion
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import dump, loads
from ..modelfile.numbers import numbers
from ..result import Result
from ..results.derivatives import Derivative, Sensitivity
from ..results.studied import UNITS
from ..results.view import standing
from ..simulation import simulate
from ..solvers.arguments import Arguments
from ..solvers.companions import SENSITIVE
from ..solvers.progress import Progress
from ..solvers.record import Record
from ..solvers.tangents import Neighbours, comparable, tangents
from ..solvers.transient import choose_loop, run
from .nearby import Change, nearby
from .wanted import known_measures

NEAR = 1e-5  # of a number, on both sides, at which its neighbours are assembled
PEAKS = ("*.force.max", "*.torque.max", "*.angular_acceleration.max")
NONE: Mapping[Change, Assembly | None] = {}
NOTHING = 1e-9  # per cent by one per cent: what rounding leaves of no dependence
SHARES = 0.0, 0.25, 0.5, 0.75  # of a first step, by which runs are displaced: as many on every machine
Pairs: TypeAlias = list[tuple[Record, Record]]  # of a number, one for each displaced run


@dataclass(frozen=True)
class Way:
    """A number of the model, its value (SI) and the models to both sides."""

    path: str
    value: float
    near: Neighbours


def sensitivity(
    mechanism: Mechanism,
    of: Sequence[str] | None = ("*",),
    to: Sequence[str] = ("*",),
    *,
    turns: float | None = None,
    duration: float | str | None = None,
    step: float | str | None = None,
    companions: int | str | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Sensitivity:
    """How measures ``of`` a run depend on numbers of its model, ``to``: patterns of names and of paths, ``"*.force.max"``, ``"joint.C.*"``;
    of None: of the largest forces, torques and angular accelerations that there are.

    The run is that of :func:`~vfife.simulate` with these arguments; derivatives are of its measures over the last turn, at the steps that it
    took. Where an onset falls in its step is decided by the steps, and leaves each derivative an error of first order in them: with contact it is
    the median over four displaced runs, with their range; without ``companions``, of the run alone. A number that the model has as zero is left
    out, and so are those that nothing depends on. Derivatives of a measure that the run's companions do not agree on mean nothing, and are marked.
    Raises ModelError for patterns that fit nothing, and what simulate raises.
    """
    given = Arguments("sensitivity")
    given.mechanism(mechanism)
    given.run(turns=turns, duration=duration, step=step, outputs=None, loop="auto", force_step=False, companions=companions)
    given.tell()
    refuse_unfit(mechanism, of or ())
    text = dump(mechanism)
    chosen = matching("to", to, dict(numbers(text)))
    result = simulate(mechanism, turns=turns, duration=duration, step=step, companions=companions, progress=progress)
    assembly = result.record.assembly
    known = over_turn(result.record, last_turn(result.record))
    names = matching("of", [one for one in PEAKS if fits(one, known)] or ["*"] if of is None else of, known)
    every = tuple(one for one in OVER_TURN if names.keys() & over_turn(result.record, last_turn(result.record), (one,)).keys())
    ways, refused = neighbours(text, chosen, assembly)
    displaced = bool(assembly.contacts) and result.record.companions is not None
    found = [derivatives(way, pair, names, every) for way, pair in paired(assembly, ways, displaced)]
    told = Sensitivity(mechanism.name, names, found, refused, doubtful(result, names))
    told.derivatives = [one for one in found if any(abs(told.elasticity(name, one.path)) > NOTHING for name in one.values)]
    return told


def refuse_unfit(mechanism: Mechanism, of: Sequence[str]) -> None:
    """Raises ModelError for a mechanism whose steps have no derivatives, and for measures that no run of it can have, before there is one."""
    if mechanism.settings.analysis == "static":
        what, remedy = "a static analysis has no steps that carry derivatives along", "vary the number with vfife study instead"
        raise ModelError([Fault("run.analysis", what, "static", "dynamic", remedy)], mechanism.name)
    assembly = assemble(mechanism)
    if choose_loop(assembly, "auto") != "generated":
        elements = len(assembly.topology.frame_nodes)
        what = f"its {elements} elements are stepped by the data-driven loop, which carries no derivatives along"
        raise ModelError([Fault("body", what, "", "", "use fewer elements, or vary the number with vfife study")], mechanism.name)
    known = known_measures(standing(assembly))
    matching("of", [one for one in of if not fits(one.partition(".")[2], UNITS)], dict.fromkeys(known, 0.0))


def fits(pattern: str, known: Iterable[str]) -> bool:
    """Whether a pattern fits any name."""
    return any(fnmatchcase(one, pattern) for one in known)


def matching(name: str, patterns: Sequence[str], known: dict[str, float]) -> dict[str, float]:
    """Those that fit any pattern. Raises ModelError with each pattern that fits none."""
    faults = [
        Fault(f"{name} {pattern!r}", "fits nothing that this model has", "", "", suggestion(pattern, known, "* stands for any characters"))
        for pattern in patterns
        if not fits(pattern, known)
    ]
    if faults:
        raise ModelError(faults, "sensitivity")
    return {one: value for one, value in known.items() if any(fnmatchcase(one, pattern) for pattern in patterns)}


def neighbours(text: str, chosen: dict[str, float], assembly: Assembly) -> tuple[list[Way], dict[str, str]]:
    """The models to both sides of each number; and of those that cannot be assembled, why."""
    ways, refused = [], {path: "zero, of which there is no small part" for path, value in chosen.items() if value == 0.0}
    changes = [(path, value + sign * NEAR * abs(value)) for path, value in chosen.items() if path not in refused for sign in (1.0, -1.0)]
    made = dict(zip(changes, nearby(text, chosen, changes, assembly), strict=True))
    for path, value in chosen.items():
        if path in refused:
            continue
        try:
            ways.append(Way(path, value, beside(text, path, value, assembly, made)))
        except VfifeError as error:
            refused[path] = str(error).strip().splitlines()[-1].strip()
    return ways, refused


def beside(text: str, path: str, value: float, assembly: Assembly, made: Mapping[Change, Assembly | None] = NONE) -> Neighbours:
    """A number a little larger and a little smaller; where only one of them is a mechanism, that and the model itself.

    ``made`` are known already.
    """
    models: list[tuple[float, Assembly]] = []
    trouble: VfifeError | None = None
    for sign in (1.0, -1.0):
        change = path, value + sign * NEAR * abs(value)
        try:
            models.append((sign, made.get(change) or placed(text, *change, assembly)))
        except VfifeError as error:
            trouble = error
    if trouble is not None and not models:
        raise trouble
    if trouble is not None:
        models.append((0.0, assembly))
        models.sort(key=lambda one: -one[0])
    (above, up), (below, down) = models
    return Neighbours(up, down, (above - below) * NEAR * abs(value))


def placed(text: str, path: str, value: float, assembly: Assembly) -> Assembly:
    """The model with another number, assembled for as many steps, each the same part of a turn."""
    mechanism = loads(text, set=[(path, value)])
    choice, turn = assembly.choice, turn_of(mechanism)
    scale = turn / choice.turn if turn is not None and choice.turn is not None else 1.0
    length: dict[str, Any] = {"duration": choice.step * scale * choice.steps} if choice.turn is None else {
        "turns": choice.steps * choice.step / choice.turn
    }  # fmt: skip
    outputs = assembly.mechanism.settings.outputs
    return assemble(mechanism, choice.step * scale, outputs=outputs, force_step=True, **length)


def paired(assembly: Assembly, ways: list[Way], displaced: bool) -> Iterator[tuple[Way, Pairs]]:
    """Of each number the records to both sides: by the derivatives of steps, or by two runs where functions of time have other pieces.

    By steps also of ``displaced`` runs.
    """
    smooth = [way for way in ways if comparable(assembly, way.near)]
    yield from zip(smooth, tangents(assembly, [way.near for way in smooth], SHARES if displaced else SHARES[:1]), strict=True)
    for way in ways:
        if way not in smooth:
            yield way, [(run(way.near.up), run(way.near.down))]


def derivatives(way: Way, pairs: Pairs, names: dict[str, float], every: tuple[Measure, ...]) -> Derivative:
    """The change of measures between two records, by that of the number: the median over displaced runs, which one with another largest
    peak does not move, and from the least to the largest.
    """
    found: dict[str, list[float]] = {}
    for pair in pairs:
        up, down = (over_turn(record, last_turn(record), every) for record in pair)
        for name in names:
            if name in up and name in down:
                found.setdefault(name, []).append((up[name] - down[name]) / way.near.apart)
    middle = {name: median(values) for name, values in found.items()}
    return Derivative(way.path, way.value, middle, {name: (min(values), max(values)) for name, values in found.items()})


def doubtful(result: Result, names: dict[str, float]) -> frozenset[str]:
    """Measures whose companions lie apart by more than a run may that is not sensitive: their derivatives mean nothing."""
    found = result.measures
    return frozenset(
        name for name in names if name in found and found[name].high - found[name].low > SENSITIVE * max(abs(found[name].value), 1e-300)
    )
