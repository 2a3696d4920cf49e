"""Errors of step and mesh: a smooth run repeated with half and a quarter of its step, a static analysis
repeated with other numbers of elements.

Companions suffice for runs with contact, whose error is that of onsets. A smooth run converges with the
second order in the step; its error follows from two repetitions by Richardson's extrapolation, if their
differences decrease as they should.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..compiler.trace.straight_line import estimated_lines
from ..errors import VfifeError
from ..model.bodies import MOST_ELEMENTS, Body, Frame, Link
from ..model.mechanism import Mechanism
from ..numerics.scalar import log
from .companion_lanes import single_runner
from .interrupts import ChunkSize, Interrupts
from .record import Record, places, recorded_rows
from .scales import scales
from .statics import equilibrium
from .status import Progress, Status

Array = NDArray[np.float64]

# Largest number of lines times steps of a run that is repeated by default: half a second, three with both
# repetitions.
MOST_LINES = 5e9
FINER = (2, 4)  # steps of the repetitions in one step of the run
CHUNK = 64  # outputs between two checks for signals
# Rows at the time t_n; velocities are at half steps, which differ between the runs.
SAMPLED = ("particle_x", "particle_y", "particle_theta", "particle_ax", "particle_ay", "particle_aw")
EXACT = 1e-13  # relative rounding error of positions
EPS = float(np.finfo(float).eps)
OVER_NOISE = 30.0
TINY = 1e-100
PARTS = 8  # of the run, in each of which the differences are compared
# Differences between h and h/2 below this share of the size of the motion are too small to matter.
DECISIVE = 1e-3
# Largest ratio of successive differences that counts as convergence: at least the first order.
FALLING = 0.5
# Runs with h/2 and h/4 that differ by more than this share of the size do not show the same motion.
DIFFERENT_MOTION = 0.1


@dataclass
class Refined:
    """Runs with ``half`` and a ``quarter`` of the step: records of their last outputs.

    ``ratio``: ratio of the second difference of positions and accelerations to the first, over all outputs;
    1/4 for convergence of second order, None if there is only rounding. ``motion``: the same without the
    accelerations of elastic nodes. ``converges``: whether the differences decrease with the step in the part
    of the run that was kept.
    """

    half: Record
    quarter: Record
    ratio: float | None
    motion: float | None
    converges: bool

    @property
    def order(self) -> float | None:
        """Order of convergence of the motion; None if there is only rounding."""
        return -log(self.motion) / log(2.0) if self.motion else None


def worth_refining(assembly: Assembly) -> bool:
    """Return whether a run is short enough to be repeated by default."""
    return estimated_lines(assembly.topology) * float(assembly.choice.steps) <= MOST_LINES


def refine(record: Record, first: int = 0) -> Refined:
    """Repeat a smooth run with half and with a quarter of its step; keep the outputs from the step ``first``
    of the run on.
    """
    recorded = recorded_rows(record.assembly)
    finer = [divided(record.assembly, parts) for parts in FINER]
    runners = [single_runner(assembly, "generated", recorded, watch=False) for assembly in finer]
    begin = [runner.advance(1, 1)[:, :, 0] for runner in runners]
    windows = [[rows] if first <= 0 else [] for rows in begin]
    compared, outputs = Differences(record, recorded), len(record.steps) - 1
    with Interrupts() as halt:
        paces = [ChunkSize(halt.look) for _ in runners]
        for done in range(0, outputs, CHUNK):
            count = min(CHUNK, outputs - done)
            pair = [
                pace.advance(runner, assembly.choice.outputs_every, count)[:, :, 0]
                for pace, runner, assembly in zip(paces, runners, finer, strict=True)
            ]  # fmt: skip
            inside = np.asarray(record.steps[done + 1 : done + 1 + count]) >= first
            for window, rows in zip(windows, pair, strict=True):
                window.append(rows[inside])
            compared.take(done, *pair)
    half, quarter = (
        _record(record, assembly, parts, recorded, np.concatenate(window))
        for assembly, parts, window in zip(finer, FINER, windows, strict=True)
    )
    since = (len(record.steps) - len(half.steps)) * PARTS // len(record.steps)
    motion = compared.ratio(len(SAMPLED))
    return Refined(half, quarter, compared.ratio(), motion, compared.converges(since))


def _record(record: Record, finer: Assembly, parts: int, recorded: NDArray[np.uint32], rows: Array) -> Record:
    """Return the last outputs of a repetition as a record with its own steps."""
    steps = parts * np.asarray(record.steps[len(record.steps) - len(rows) :])
    return Record(finer, steps, rows, recorded, loop="generated", status=record.status)


def with_step(assembly: Assembly, step: float) -> Assembly:
    """Return the same start with another step (s), on which nothing else in it depends."""
    state = assembly.state.copy()
    state[assembly.layout["step"]] = step
    return dataclasses.replace(assembly, state=state)


def divided(assembly: Assembly, parts: int) -> Assembly:
    """Return the same start with the step divided by ``parts``, and outputs at the same times."""
    choice = assembly.choice
    choice = dataclasses.replace(choice, step=choice.step / parts, outputs_every=parts * choice.outputs_every)
    return dataclasses.replace(with_step(assembly, choice.step), choice=choice)


class Differences:
    """Sums of squares of the differences between the run and its repetitions at the outputs of each of
    ``PARTS`` parts of the run.
    """

    def __init__(self, record: Record, recorded: NDArray[np.uint32]) -> None:
        sampled = np.concatenate([record.assembly.layout.rows_of(name) for name in SAMPLED]).astype(np.uint32)
        self.columns, self.own = (
            places(recorded, sampled),
            record.rows[:, places(record.row_numbers, sampled)],
        )
        self.squares, self.counts = np.zeros((PARTS, 2, len(sampled))), np.zeros(PARTS)
        self.assembly = record.assembly
        self.step = record.assembly.choice.step
        self.nodes = np.zeros(len(sampled) // len(SAMPLED), dtype=bool)  # particles of elastic bodies
        for body in self.assembly.bodies.values():
            if body.elements:
                self.nodes[list(body.particles)] = True

    def take(self, done: int, half: Array, quarter: Array) -> None:
        """Add the outputs of both repetitions after the first ``done``, shape (outputs, rows) each."""
        fine, finest, coarse = (
            half[:, self.columns],
            quarter[:, self.columns],
            self.own[done + 1 : done + 1 + len(half)],
        )
        part = (done + 1 + np.arange(len(half))) * PARTS // len(self.own)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in np.unique(part):
                inside = part == k
                first, second = (coarse - fine)[inside], (fine - finest)[inside]
                self.squares[k] += (first * first).sum(axis=0), (second * second).sum(axis=0)
                self.counts[k] += inside.sum()

    def scaled(self) -> tuple[Array, Array, Array]:
        """Return the mean squares of both differences in each part for each kind of quantity, over the
        squared size of the kind, and the relative noise of each kind: those of ``SAMPLED``, then the
        accelerations of elastic nodes.
        """
        numbers = self.own.reshape(len(self.own), len(SAMPLED), -1)
        largest = np.abs(numbers).max(axis=(0, 2), initial=0.0)
        size, turn, push = max(*largest[:2], TINY), max(largest[2], 1.0), max(*largest[3:5], TINY)
        spin = max(largest[5], push / size)
        rounding = (
            EPS * FINER[-1] * FINER[-1] / (self.step * self.step)
        )  # of a second difference of numbers near one
        scale = np.array([size, size, turn, push, push, spin, 1.0, 1.0, 1.0])
        noise = np.array([EXACT * size, EXACT * size, EXACT * turn, *[rounding * size] * 2, rounding * turn])
        noise = np.append(noise, noise[3:])
        squares = self.squares.reshape(PARTS, 2, len(SAMPLED), -1)
        sums = squares[..., ~self.nodes].sum(axis=3) if self.nodes.any() else squares.sum(axis=3)
        waves = np.zeros((PARTS, 2, 3))
        if self.nodes.any():
            moved = (numbers[:, :3].max(axis=0) - numbers[:, :3].min(axis=0)).max(axis=1)
            way = max(*moved[:2], TINY)
            scale[:3] = way, way, max(moved[2], way / size)
            sums[:, :, :3] = squares[:, :, :3].sum(axis=3)
            nodal = self._nodal_scales(numbers)
            waves = (squares[:, :, 3:, self.nodes] / (nodal * nodal)).sum(axis=3)
            noise[len(SAMPLED) :] /= nodal.min(axis=1)
        noise /= scale
        shares = np.concatenate([sums, waves], axis=2) / (scale * scale)
        shares /= np.maximum(self.counts, 1.0)[:, None, None]
        return shares[:, 0], shares[:, 1], noise

    def _nodal_scales(self, numbers: Array) -> Array:
        """Return the scales of the accelerations of elastic nodes, shape (kinds, nodes): those that the
        forces of the whole mechanism would give each.

        No step near the stable limit resolves waves in the shortest elements, and each step has others. The
        nodes that they move are light, so their accelerations weigh as much as their forces.
        """
        assembly, scale = self.assembly, scales(self.assembly)
        mass, inertia = (
            assembly.state[assembly.layout[f"particle_inverse_{name}"]][self.nodes]
            for name in ("mass", "inertia")
        )
        forces = np.abs(numbers[:, 3:5, self.nodes]) / np.where(mass > 0.0, mass, np.inf)
        force = max(scale.force, float(forces.sum(axis=2).max(initial=0.0)), TINY)
        # Nodes that are held do not accelerate.
        push = np.where(mass > 0.0, force * mass, np.inf)
        return np.stack([push, push, np.where(inertia > 0.0, force * scale.length * inertia, np.inf)])

    def ratio(self, kinds: int | None = None) -> float | None:
        """Return the ratio of both differences, from those of all or the first ``kinds`` of quantities whose
        differences exceed rounding; None if none does.
        """
        coarse, fine, noise = (numbers[..., :kinds] for numbers in self.scaled())
        share = self.counts[:, None] / max(self.counts.sum(), 1.0)
        coarse, fine = (coarse * share).sum(axis=0), (fine * share).sum(axis=0)
        telling = (np.sqrt(fine) > OVER_NOISE * noise) & (coarse > 0.0)
        return sqrt(float(fine[telling].sum() / coarse[telling].sum())) if telling.any() else None

    def converges(self, since: int) -> bool:
        """Return whether the differences decrease with the step in all parts from number ``since`` on, where
        they are large enough to matter. Waves through elastic nodes need only be small.
        """
        coarse, fine, noise = self.scaled()
        motion = np.arange(len(noise)) < len(SAMPLED)
        for k in range(since, PARTS):
            telling = np.sqrt(fine[k]) > OVER_NOISE * noise
            second = sqrt(float(fine[k][telling].sum()))
            first, falling = (sqrt(float(squares[k][telling & motion].sum())) for squares in (coarse, fine))
            if not second <= DIFFERENT_MOTION or (first > DECISIVE and falling > FALLING * first):
                return False
        return True


HALF, DOUBLE, FOURFOLD = 0.5, 2.0, 4.0  # ratios of the numbers of elements
WORDS = {HALF: "half", DOUBLE: "twice", FOURFOLD: "four times"}
# Estimate of the iterations of an equilibrium: a constant, and a factor of the square of the elements along a
# body times the number of bodies.
STATIC_ITERATIONS = (1000.0, 40.0)
OVERHEAD = 10.0  # elements that take as long as all else in an iteration
# Largest number of iterations times elements of an analysis that is repeated by default: two or three
# seconds, ten with the repetition.
MOST_WORK = 5e7


def refinable(mechanism: Mechanism) -> bool:
    """Return whether there are elements, all of which can be halved. A link of two particles is one element
    by definition.
    """
    elastic = [body for body in mechanism.bodies.values() if counts(body)]
    return bool(elastic) and all(
        body.model != "two-particle" and DOUBLE * sum(counts(body)) <= MOST_ELEMENTS for body in elastic
    )


def meshed(mechanism: Mechanism, share: float) -> Mechanism | None:
    """Return the mechanism with ``share`` times the elements in each elastic body; None if that is no whole
    number.
    """
    bodies: dict[str, Body] = {}
    for name, body in mechanism.bodies.items():
        finer = with_elements(body, share)
        if finer is None:
            return None
        bodies[name] = finer
    return dataclasses.replace(mechanism, bodies=bodies)


def with_elements(body: Body, share: float) -> Body | None:
    """Return a body with ``share`` times the elements; None if that is no whole number."""
    if any(not (share * count).is_integer() for count in counts(body)):
        return None
    if isinstance(body, Frame):
        members = tuple(
            dataclasses.replace(member, elements=int(share * member.elements)) for member in body.members
        )
        return dataclasses.replace(body, members=members)
    if isinstance(body, Link) and body.element_count:
        return dataclasses.replace(body, elements=int(share * body.elements))
    return body


def counts(body: Body) -> list[int]:
    """Return the numbers of elements of each member of a frame, or of an elastic link."""
    if isinstance(body, Frame):
        return [member.elements for member in body.members]
    return [body.elements] if isinstance(body, Link) and body.element_count else []


def iterations(assembly: Assembly) -> float:
    """Return an estimate of the iterations of an equilibrium; for slender frames they grow with the square of
    the elements in line.
    """
    constant, factor = STATIC_ITERATIONS
    bodies = assembly.bodies.values()
    longest = max((len(body.elements) for body in bodies), default=1)
    return min(
        constant + factor * longest * longest * len(bodies), float(assembly.mechanism.settings.iterations)
    )


def worth_other_meshes(assembly: Assembly) -> bool:
    """Return whether an analysis is short enough to be repeated by default."""
    return (
        assembly.choice.outputs * iterations(assembly) * (len(assembly.topology.frame_nodes) + OVERHEAD)
        <= MOST_WORK
    )


def other_meshes(record: Record, progress: Callable[[Progress], None] | None = None) -> dict[float, Record]:
    """Return the equilibria of a static analysis on other meshes, by their ratio of elements: twice as many,
    and half as many.

    If an odd number cannot be halved, four times as many take its place, if that is short. Meshes on which
    not all equilibria were found are left out.
    """
    records: dict[float, Record] = {}
    for share in (DOUBLE, HALF):
        records |= _on_mesh(record, share, progress)
    return (
        records
        if HALF in records or DOUBLE not in records
        else records | _on_mesh(record, FOURFOLD, progress)
    )


def _on_mesh(
    record: Record, share: float, progress: Callable[[Progress], None] | None
) -> dict[float, Record]:
    """Return the equilibria on one mesh by its ratio; empty if there is no such mesh."""
    mechanism = meshed(record.assembly.mechanism, share) if record.status == Status.COMPLETE else None
    if mechanism is None:
        return {}
    try:
        assembly = assemble(mechanism)
    except (VfifeError, ValueError):
        return {}
    if share == FOURFOLD and not worth_other_meshes(assembly):
        return {}

    def tell(state: Progress) -> None:
        if progress is not None:
            progress(dataclasses.replace(state, text=f"{WORDS[share]} the elements, {state.text}"))

    equilibria = equilibrium(assembly, loop=record.loop, progress=tell, examine=False)
    return {share: equilibria} if equilibria.status == Status.COMPLETE else {}
