"""Equilibria under load factors, by dynamic relaxation.

A load factor takes the place of time. Gravity, constant loads and constant torques are multiplied by it;
loads and torques over time, and prescribed angles, travels and paths, are evaluated at time = factor. Torques
over an angle are multiplied by it, too; torques over a speed have their value at rest. The load changes from
one factor to the next in equal parts, with a short relaxation after each, so that one branch of equilibria is
followed. At the new factor the structure is relaxed until unbalanced force and kinetic energy are within the
limits of the settings.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..kinematics.drives import constraint_drivers
from ..model.mechanism import Settings
from ..numerics.dense import times
from .buckling import unstable
from .interrupts import Interrupts
from .record import Checkpoint, Record, Writer, lasting_rows, recorded_rows
from .relaxation import Loading, Relaxation, extent
from .status import Progress, Status

Array = NDArray[np.float64]

PARTS = 10  # of the way from one load factor to the next
FEWEST = 16  # iterations of one part
TURN = 1e-3  # largest turn (rad) of a driver in one iteration
TRAVEL = 1e-3  # largest travel in one iteration, over the shortest element or a hundredth of the size
LOOK_SECONDS = 0.25  # between two progress lines
TRIES = 4  # of a load factor, each with larger masses, if joints open
# Ratio of forces to loads from which links in line are taken to carry a load across, which they cannot.
BEYOND_LOADS = 100.0
# Share of a way from which a structure that moves against a negative stiffness has snapped through: 0.08 to
# 0.7 where trusses, toggles, presses (loose ones, too) and Lee's frame do, 0 on stable paths
# (tests/solvers/test_statics.py).
SNAPPED = 0.02
ESCAPE_DISTANCE = 100.0  # distance from the start, in sizes of the mechanism, beyond which nothing holds it
STATE_OF_REST = ("u", "v", "w", "ax", "ay", "aw")
MEANINGLESS = (
    "damping_power", "damping_work", "external_power", "external_work", "driven_power", "driven_work",
    "actuator_power", "actuator_work",
    "spring_damping_power",
    "spring_damping_work", "contact_damping_power", "contact_damping_work", "contact_friction_power",
    "contact_friction_work",
    "contact_onsets", "contact_grazing", "contact_deep", "contact_deepest", "contact_duration",
    "function_rate",
    "function_acceleration", "body_alpha", "body_alpha_max",
)  # fmt: skip


def equilibrium(
    assembly: Assembly,
    *,
    loop: str = "data-driven",
    progress: Callable[[Progress], None] | None = None,
    file: Writer | None = None,
    resume: Checkpoint | None = None,
    examine: bool = True,
) -> Record:
    """Compute the equilibria under the load factors of the settings; output 0 is the start under factor 0,
    output k the equilibrium under factor k.

    Iterations end when the unbalanced force is at most ``residual`` times the largest force (and moments
    accordingly), and the kinetic energy at most ``kinetic_energy`` times the largest so far. The status is
    "not converged" after more than ``iterations``, "diverged" if the mechanism runs away, and "interrupted"
    after Ctrl-C; the message names the load factor, and equilibria found before are kept. ``resume``, a
    checkpoint of its ``file``, continues an analysis to the same bits. ``examine``: the stability of each.
    """
    settings = assembly.mechanism.settings
    recorded, lasting = recorded_rows(assembly), lasting_rows(assembly.layout)
    loading = Loading(assembly)
    force = loading.force([0.0, *settings.load_factors], extent(assembly, assembly.state))
    relaxation = Relaxation(assembly, force, "interpreted" if loop == "interpreted" else "data-driven")
    record = Record(
        assembly, np.zeros(0, dtype=np.int64), np.zeros((0, len(recorded))), recorded, loop="data-driven"
    )
    relaxation.runner.advance(0, 1)  # loads the compiled loop, so that the analysis is not timed with it
    began, rows, old, earlier = time.perf_counter(), list[Array](), 0.0, 0.0
    factors = (0.0, *settings.load_factors)
    if resume is not None and file is not None:
        relaxation.restore(resume.values.reshape(-1), lasting, resume.extra["relaxation"])
        rows, old, earlier = list(file.later()()), factors[resume.step], float(resume.extra["wall"])
    halt = Interrupts()
    relaxation.pace.look = halt.look
    try:
        with halt:
            for k, factor in list(enumerate(factors))[len(rows) :]:
                for attempt in range(TRIES):
                    state = relaxation.state.copy()
                    stage = Stage(relaxation, loading, k, old, factor, progress, began)
                    fault = stage.run(settings)
                    if attempt + 1 == TRIES or not fault or relaxation.finite:
                        break
                    relaxation.go_back(state)
                if fault:
                    record.status, record.message = fault
                    break
                stage.tell(at_once=True)
                if examine:
                    relaxation.unstable.append((factor, unstable(relaxation)))
                rows.append(_at_rest(assembly, relaxation, stage)[recorded])
                if file is not None:
                    wall = earlier + time.perf_counter() - began
                    _append(file, k, rows[-1], relaxation, relaxation.state[lasting], wall)
                old = factor
    except KeyboardInterrupt:
        record.status, record.message = Status.INTERRUPTED, f"Stopped at load factor {factors[len(rows)]:g}."
    if not rows:  # the start itself, so that there is something to look at
        rows = [assembly.state[recorded]]
    record.source, record.steps = np.array(rows), np.arange(len(rows), dtype=np.int64)
    record.wall, record.reached = earlier + time.perf_counter() - began, len(rows) - 1
    record.final = relaxation.state.copy() if record.status == Status.COMPLETE else None
    record.snaps, record.unstable = tuple(relaxation.snaps), tuple(relaxation.unstable)
    if record.message and file is not None:
        file.event(len(rows) - 1, record.message)
    return record


def _append(file: Writer, number: int, row: Array, relaxation: Relaxation, state: Array, wall: float) -> None:
    """Write an equilibrium, the ``row`` of output ``number``, with the checkpoint that continues after it;
    ``state`` are its lasting rows, ``wall`` (s) is the time of computation so far.
    """
    extra = {"wall": wall, "relaxation": relaxation.checkpoint}
    file.append(np.array([number], dtype=np.int64), row[None, :], None, Checkpoint(number, state, extra))


def _at_rest(assembly: Assembly, relaxation: Relaxation, stage: Stage) -> Array:
    """Return the state of an equilibrium: after one more iteration for the extremes, without velocities and
    quantities of motion, and with the floor of impact speeds in contacts.
    """
    relaxation.advance(1)
    state, layout = relaxation.state.copy(), assembly.layout
    for name in STATE_OF_REST:
        state[layout[f"particle_{name}"]] = 0.0
    for name in MEANINGLESS:
        state[layout[name]] = 0.0
    touching = state[layout["contact_penetration"]] > 0.0
    state[layout["contact_slowness"]] = np.where(touching, 1.0 / assembly.state[layout["contact_floor"]], 0.0)
    state[layout["iterations"]], state[layout["unbalanced"]] = stage.done, stage.ratio
    return state


class Falls:
    """How far a structure moves against a negative stiffness in the chunks of a ``relaxation``, by the joints
    with clearance that touch.
    """

    def __init__(self, relaxation: Relaxation) -> None:
        self.relaxation, assembly = relaxation, relaxation.assembly
        names, joints = np.array(assembly.contact_joints), assembly.mechanism.contacts
        loose = [name for name in joints if getattr(joints[name], "clearance", None)]
        self.columns = [np.flatnonzero(names == name) for name in loose]
        self.ways = dict[tuple[bool, ...], float]()  # by whether each joint touches
        self.last: tuple[bool, ...] = (False,) * len(loose)

    def add(self, place: Array, push: Array, mass: Array, touching: NDArray[np.bool_]) -> None:
        """Add a chunk with places and accelerations, shape (looks, coordinates), the masses by coordinate,
        and which contacts touch, shape (looks, contacts).
        """
        with np.errstate(invalid="ignore", over="ignore"):
            moved, change = np.diff(place, axis=0), np.diff(push, axis=0)
            unstable = times(moved * change, mass) > 0.0
            unstable &= times(moved * moved, mass) > self.relaxation.rounding(mass)
            ways = self.relaxation.way(moved)
        closed = np.array([touching[:, columns].any(axis=1) for columns in self.columns], dtype=bool)
        closed = closed.reshape(len(self.columns), len(touching)).T
        self.last = tuple(closed[-1].tolist())
        for k in np.flatnonzero(unstable):
            joints = tuple((closed[k] & closed[k + 1]).tolist())
            self.ways[joints] = self.ways.get(joints, 0.0) + float(ways[k])

    @property
    def contact_way(self) -> float:
        """The way (:meth:`Relaxation.way`) on which all joints touch that touch in the end: where one of them
        is open, journals cross their clearances, and the structure is not what it is at rest.
        """
        return sum(
            way
            for joints, way in self.ways.items()
            if all(closed or not end for closed, end in zip(joints, self.last, strict=True))
        )


class Stage:
    """One load factor: the way from the factor before, and the relaxation at it."""

    def __init__(
        self, relaxation: Relaxation, loading: Loading, number: int, old: float, new: float,
        progress: Callable[[Progress], None] | None, began: float,
    ) -> None:  # fmt: skip
        self.relaxation, self.loading, self.number, self.old, self.new = relaxation, loading, number, old, new
        self.progress, self.began, self.told = progress, began, 0.0
        self.first = relaxation.iterations
        self.ratio = 0.0
        self.start = relaxation.state[relaxation.places].copy()
        self.falls = Falls(relaxation)
        relaxation.follow = self.falls.add

    @property
    def done(self) -> int:
        """Number of iterations so far."""
        return self.relaxation.iterations - self.first

    @property
    def snapped(self) -> bool:
        """Whether a share of the way to this load factor went against a negative stiffness, without that on
        which clearances are taken up.
        """
        way = self.relaxation.way(self.relaxation.state[self.relaxation.places] - self.start)
        return self.falls.contact_way > SNAPPED * float(way)

    def run(self, settings: Settings) -> tuple[Status, str] | None:
        """Go to the load factor and relax. Returns status and message if no equilibrium is found, else
        None.
        """
        relaxation, loading = self.relaxation, self.loading
        count = self._count()
        path = np.linspace(self.old, self.new, PARTS + 1) if self.new != self.old else np.array([self.old])
        for start, end in zip(path[:-1], path[1:], strict=True):
            self._advance(float(start), float(end), count)
            loading.go(relaxation, float(end), float(end), 0)
            fault = self._look(relaxation.relax(), settings)
            if fault:
                return fault
        loading.go(relaxation, self.new, self.new, 0)
        while True:
            pushes = relaxation.relax()
            fault = self._look(pushes, settings)
            if fault:
                return fault
            at_rest = relaxation.kinetic_share <= settings.kinetic_energy
            earlier = relaxation.balance(pushes[BEFORE_LAST]).ratio
            if max(self.ratio, earlier) <= settings.residual and at_rest:
                if self._in_line():
                    return Status.DIVERGED, self._joints_open()
                if self.snapped:
                    relaxation.snaps.append((self.old, self.new))
                return None

    def _advance(self, start: float, end: float, count: int) -> None:
        self.loading.go(self.relaxation, start, end, count)
        if self.loading.motions or self.loading.speeds:
            self.relaxation.advance(count)

    def _count(self) -> int:
        """Return the iterations of one part, so that drivers turn and travel little in each."""
        state, layout = self.relaxation.state, self.loading.layout
        shortest = float(state[layout["reference_length"]].min(initial=0.01 * self.relaxation.size))
        turn, travel = self.loading.motion(self.old, self.new)
        return max(
            FEWEST, int(np.ceil(turn / TURN / PARTS)), int(np.ceil(travel / (TRAVEL * shortest) / PARTS))
        )

    def _look(self, pushes: Array, settings: Settings) -> tuple[Status, str] | None:
        relaxation = self.relaxation
        self.ratio = relaxation.balance(pushes[-1]).ratio
        self.tell()
        moved = np.abs(relaxation.state[relaxation.places] - self.start) / np.where(
            relaxation.turning, 2.0 * np.pi, relaxation.size
        )
        if not np.isfinite(moved).all() or moved.max(initial=0.0) > ESCAPE_DISTANCE:
            return Status.DIVERGED, self._runaway()
        if self.done > settings.iterations:
            return Status.NOT_CONVERGED, self._unfinished(settings)
        return None

    def tell(self, at_once: bool = False) -> None:
        """Show progress, a few times a second, or at once with ``at_once``."""
        clock = time.perf_counter()
        if self.progress is not None and (at_once or clock - self.told > LOOK_SECONDS):
            self.told = clock
            text = f"load factor {self.new:g}: {self.done:,} iterations, unbalanced {self.ratio:.1e}"
            factors = len(self.loading.assembly.mechanism.settings.load_factors)
            self.progress(Progress(self.number, factors, clock - self.began, text))

    def _runaway(self) -> str:
        assembly = self.loading.assembly
        if not self.relaxation.finite:
            return self._joints_open()
        free = max(0, assembly.mobility.after_drives - len(constraint_drivers(assembly.mechanism)))
        loose = (
            f"It has {free} free motion{'s' * (free != 1)} that only springs, contacts or elastic bodies"
            " could hold. "
            if free
            else ""
        )
        return (
            f"At load factor {self.new:g} the mechanism runs away by more than {ESCAPE_DISTANCE:g} times"
            f" its size, or turns: nothing holds it against the loads. {loose}Add a joint, a spring or a"
            f" driver, or check"
            " the supports (vfife check)."
        )

    def _in_line(self) -> bool:
        """Return whether links that are in line at the start carry forces far beyond the loads: they yield to
        first order, and rounding decides where they come to rest.
        """
        relaxation, mobility = self.relaxation, self.loading.assembly.mobility
        return bool(
            mobility and mobility.blocked and relaxation.largest()[0] > BEYOND_LOADS * relaxation.force
        )

    def _joints_open(self) -> str:
        return (
            f"At load factor {self.new:g} joints come apart: links lie almost on a line, where only"
            " extremely large forces along them could carry a load across. Give them more rise, or let them"
            " stretch (elastic links)."
        )

    def _unfinished(self, settings: Settings) -> str:
        return (
            f"No equilibrium at load factor {self.new:g} within {settings.iterations:,} iterations: the"
            f" unbalanced force is {self.ratio:.2e} of the largest force, {settings.residual:.2e} is"
            f" required, and the kinetic energy is {self.relaxation.kinetic_share:.1e} of its largest"
            " value. Allow more iterations or a larger residual, choose closer load factors, or, where the"
            " load has passed a limit, prescribe the travel of a pin instead of the load."
        )


BEFORE_LAST = -2  # of the looks of a chunk: an equilibrium must hold at two of them
