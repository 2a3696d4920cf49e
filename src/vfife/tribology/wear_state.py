"""Surfaces that wear: their list, the profiles that the contact geometry uses, rates of depth from a record,
and the result of a wear simulation.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import Fault, ModelError, former_names
from ..files import DataTable, share_done
from ..laws.materials import coefficient
from ..measures.wear import PLACES, SIDES, areas, rubbing, work_around
from ..model.mechanism import Mechanism
from ..model.surfaces import body_of, surface_words, surfaces
from ..model.wear import COEFFICIENT, Wear, depth_at
from ..modelfile import loads
from ..numerics.dense import times
from ..numerics.elementwise import sincos, tan
from ..report.html import NotebookDocument
from ..solvers.record import Record
from ..store.studyfile import WearPoint

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
DIFFERENT = 0.8  # of a life by smoothed profiles: a shorter one by the deepest places counts
# Angles (rad) of the places around a surface, each in the middle of its sector.
ANGLES: Array = -math.pi + 2.0 * math.pi / PLACES * (np.arange(PLACES, dtype=float) + 0.5)


@dataclass(frozen=True)
class Surface:
    """One ``side`` of a joint, ``bearing`` or ``journal``, that wears: its coefficient k (1/Pa), its
    ``profile`` at the start (m: mean, then cosine and sine of each harmonic), the joint's ``clearance``
    (m), and the ``body`` that has the surface.
    """

    joint: str
    side: str
    k: float
    profile: tuple[float, ...]
    clearance: float
    body: str = ""

    @property
    def name(self) -> str:
        """Name of the surface for readers: joint, body and side."""
        return f"{self.joint}: {surface_words(self.body, self.side)}"


@dataclass(frozen=True)
class WearSpec:
    """Arguments of :func:`~vfife.wear`, the text of the ``model``, and the ``steps`` in a turn."""

    model: str
    turns: float
    block: int = 4
    settle: int = 4
    tolerance: float = 0.01
    harmonics: int = 8
    clearance: float | None = None
    force: float | None = None
    steps: int = 0


class WearLife(NamedTuple):
    """Turns until a joint reaches a clearance: by its ``smoothed`` profiles, by the ``deepest`` places as
    they wore, and with the volumes that its surfaces lose spread evenly around them, ``uniform``.
    ``determined``: the journal fits into the grooves and smoothing hardly matters, so that the smoothed
    profiles give the life; otherwise the model determines no more than the range from ``shortest`` to
    ``longest``.
    """

    smoothed: float
    deepest: float
    uniform: float
    determined: bool

    @property
    def shortest(self) -> float:
        """The shortest life that the model permits."""
        return self.smoothed if self.determined else min(self[:3])

    @property
    def longest(self) -> float:
        """The longest life that the model permits."""
        return self.smoothed if self.determined else max(self[:3])


@former_names(asked="spec", ended="life_end", beside="step_difference", play="clearance")
@dataclass(frozen=True, repr=False)
class Worn(NotebookDocument, DataTable):
    """The result of a wear simulation of the mechanism ``name``, as far as it is computed; ``spec`` are its
    arguments.

    ``turns`` at each point, shape (points,). ``depth`` (m) of each surface at ``angles`` (rad, in the frame
    of its body), including the profile at the start, shape (points, surfaces, places); ``rate`` (m per turn)
    has the same shape. ``clearance`` (m) of each joint in ``joints``, plus the deepest places of its
    surfaces as ``spec.harmonics`` smooth them, which is what the contact follows, and ``force`` (N), the
    largest in the block that was simulated there, shape (points, joints).

    ``errors`` (m) are those of the jumps that led to the points. ``spread`` (1) is the relative standard
    error of the mean rate of a block. ``sharp`` (1): above 1 a journal would rest on the edges of the groove
    that it wore, which the model does not describe. ``step_difference``: relative differences of the last
    rates with half the step, of the volume of all surfaces and of the deepest place; empty if not computed.
    ``life_end``: turns, joint and limit (``by``) of a life that ended, or empty.
    """

    name: str
    spec: WearSpec
    surfaces: tuple[Surface, ...]
    joints: tuple[str, ...]
    turns: Array
    depth: Array
    rate: Array
    clearance: Array
    force: Array
    errors: Array
    spread: Array
    sharp: Array
    simulated: float
    life_end: dict[str, Any]
    step_difference: tuple[float, ...] = ()

    @property
    def angles(self) -> Array:
        """Angles (rad) of the places around a surface, from the x axis of its body."""
        return ANGLES

    @property
    def complete(self) -> bool:
        """Whether all turns are simulated or a life has ended."""
        return bool(self.life_end) or bool(self.turns[-1] >= self.spec.turns)

    @property
    def progress(self) -> str:
        """How much is computed, as in "2,000 of 1,000,000 turns"; empty for a complete simulation."""
        return "" if self.complete else share_done(float(self.turns[-1]), self.spec.turns, "turns")

    def volume(self, joint: str, side: str) -> Array:
        """Return the volume (m^3) that a side of a joint has lost since the start, shape (points,)."""
        place, (mechanism, _) = self.place(joint, side), self._model()
        contact = mechanism.contacts[joint]
        radius = abs(contact.touchings(0.0)[0].arms[SIDES.index(side)])
        return np.asarray(
            (self.depth[:, place] - self.depth[0, place]).mean(axis=1)
            * 2.0
            * math.pi
            * radius
            * contact.axial_length,
            dtype=float,
        )

    def unsmoothed_clearance(self, joint: str) -> Array:
        """Return the clearance (m) of a joint plus the depths of the deepest places of its surfaces as they
        wore, not smoothed, shape (points,).
        """
        places = [k for k, surface in enumerate(self.surfaces) if surface.joint == joint]
        clearance = next(surface.clearance for surface in self.surfaces if surface.joint == joint)
        return np.asarray(clearance + self.depth[:, places].max(axis=2).sum(axis=1), dtype=float)

    def uniform_clearance(self, joint: str) -> Array:
        """Return the clearance (m) of a joint if the volumes that its surfaces lost were spread evenly around
        them, shape (points,): no wear of these volumes widens it less.
        """
        places = [k for k, surface in enumerate(self.surfaces) if surface.joint == joint]
        losses = (self.depth[:, places] - self.depth[0, places]).mean(axis=2).sum(axis=1)
        return np.asarray(self.unsmoothed_clearance(joint)[0] + losses, dtype=float)

    def turns_to(self, joint: str, clearance: float, *, smoothed: bool = True) -> float:
        """Return the turns after which a joint has a ``clearance`` (m): between the points that are computed,
        beyond them at the rate of the last jump; infinite for a joint that does not wear then. Not
        ``smoothed``: :meth:`unsmoothed_clearance` is meant.
        """
        column = self.clearance[:, self.joints.index(joint)] if smoothed else self.unsmoothed_clearance(joint)
        return turns_at(self.turns, column, clearance)

    def life(self, joint: str, clearance: float) -> WearLife:
        """Return the turns until a joint has a ``clearance`` (m), by its grooves smoothed, as they wore, and
        spread evenly.
        """
        smoothed, deepest = (self.turns_to(joint, clearance, smoothed=smooth) for smooth in (True, False))
        uniform = turns_at(self.turns, self.uniform_clearance(joint), clearance)
        fits = self.sharpness(joint, turns=smoothed) <= 1.0 and deepest >= DIFFERENT * smoothed
        return WearLife(smoothed, deepest, uniform, fits)

    def sharpness(self, joint: str, harmonics: int | None = None, turns: float = 0.0) -> float:
        """Return the largest relative curvature of the grooves of a joint over all points, as ``harmonics``
        smooth them, those of the simulation by default: above 1 the journal is wider than its groove. If
        ``turns`` lie beyond the last point, the grooves that the last jump would deepen to there count too.
        """
        places = [k for k, surface in enumerate(self.surfaces) if surface.joint == joint]
        losses = list(self.depth[:, places] - self.depth[0, places])
        if self.turns[-1] < turns < math.inf and len(losses) > 1:
            jumps = (turns - self.turns[-1]) / (self.turns[-1] - self.turns[-2])
            losses.append(losses[-1] + jumps * (losses[-1] - losses[-2]))
        pair, count = [self.surfaces[k] for k in places], harmonics or self.spec.harmonics
        return max(sharpness(pair, depth, count) for depth in losses)

    def place(self, joint: str, side: str) -> int:
        """Return the index of a side of a joint among the surfaces.

        Raises ValueError, with the surfaces that wear, for any other.
        """
        names = [(surface.joint, surface.side) for surface in self.surfaces]
        if (joint, side) not in names:
            raise ValueError(
                f"no surface {joint} {side} wears; there are {', '.join(' '.join(pair) for pair in names)}"
            )
        return names.index((joint, side))

    def mechanism(self, point: int = -1) -> Mechanism:
        """Return the mechanism as it is worn at a point, with the profiles that the contact geometry uses."""
        mechanism, surfaces = self._model()
        depth, harmonics = self.depth[point] - start_depth(surfaces), self.spec.harmonics
        mechanism_with_wear = shaped(mechanism, surfaces, max(harmonics, 1))
        for surface, series in zip(surfaces, profiles(surfaces, depth, harmonics), strict=True):
            # The mean, then cosine and sine of each harmonic; the first sine is zero.
            mean, _, *numbers = np.column_stack(series).ravel().tolist()
            replaced(mechanism_with_wear, surface, (mean, *numbers))
        return mechanism_with_wear

    def _model(self) -> tuple[Mechanism, list[Surface]]:
        mechanism = loads(self.spec.model)
        return mechanism, surfaces_of(mechanism)

    def plot(self) -> Figure:
        """Return a figure of the depths around each surface in polar axes, and of clearance and forces over
        turns.
        """
        from ..plots.wear import wear_over_turns

        return wear_over_turns(self)

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a heading and a row for every point, surface and place: turns, joint, side, angle (rad),
        depth (m), body.
        """
        yield ["turns", "joint", "side", "angle", "depth", "body"]
        for turns, depths in zip(self.turns.tolist(), self.depth, strict=True):
            for surface, depth in zip(self.surfaces, depths, strict=True):
                yield from (
                    [turns, surface.joint, surface.side, *pair, surface.body]
                    for pair in zip(ANGLES.tolist(), depth.tolist(), strict=True)
                )

    def spreadsheet(self) -> Iterator[Sequence[object]]:
        """Yield the table with units in its heads."""
        _, *rows = self.table()
        yield ["turns", "joint", "side", "angle [rad]", "depth [m]", "body"]
        yield from rows


def turns_at(turns: Array, column: Array, value: float) -> float:
    """Return the turns at which a ``column`` of numbers at ``turns`` has a value: between them, or beyond the
    last at the rate of the last jump; infinite for a column that does not grow then.
    """
    if column[-1] >= value:
        index = int(np.argmax(column >= value))
        if not index:
            return 0.0
        share = (value - column[index - 1]) / (column[index] - column[index - 1])
        return float(turns[index - 1] + share * (turns[index] - turns[index - 1]))
    if len(column) < 2 or not column[-1] > column[-2]:
        return math.inf
    rate = (column[-1] - column[-2]) / (turns[-1] - turns[-2])
    return float(turns[-1] + (value - column[-1]) / rate)


def surfaces_of(mechanism: Mechanism) -> list[Surface]:
    """Return the sides of journals and bearings that have a coefficient of wear."""
    surface_list = []
    for name, joint in mechanism.contacts.items():
        if joint.wear is None or not joint.keeps_profile:
            continue
        pair = surfaces(mechanism, joint)
        for side in SIDES:
            k = coefficient(getattr(joint.wear, side), getattr(pair, side))
            if k:
                profile, clearance = getattr(joint.wear, f"{side}_profile"), joint.touchings(0.0)[0].size
                surface_list.append(Surface(name, side, k, profile, clearance, body_of(joint, side)))
    return surface_list


def replaced(mechanism: Mechanism, surface: Surface, profile: tuple[float, ...]) -> None:
    """Replace the profile of a surface in a mechanism, in place."""
    joint = mechanism.contacts[surface.joint]
    if joint.wear is not None:
        wear = dataclasses.replace(joint.wear, **{f"{surface.side}_profile": profile})  # type: ignore[arg-type]
        mechanism.joints[surface.joint] = dataclasses.replace(joint, wear=wear)


def shaped(mechanism: Mechanism, surfaces: Sequence[Surface], harmonics: int) -> Mechanism:
    """Return the mechanism with zeros for all ``harmonics`` in the profile of each surface that wears, so
    that its state has rows for them.
    """
    model = dataclasses.replace(mechanism, joints=dict(mechanism.joints))
    for surface in surfaces if harmonics else ():
        missing = 2 * harmonics - 1 - len(surface.profile)
        replaced(model, surface, (*surface.profile, *(0.0,) * missing))
    return model


def jackson(harmonics: int) -> Array:
    """Return the factors of Jackson for harmonics 0, 1 ..., shape (harmonics,).

    A truncated Fourier series of a narrow groove oscillates and would have negative depths. With these
    factors the series is a convolution with a kernel that is nowhere negative (Jackson 1912; Weisse et al.,
    Rev. Mod. Phys. 78, 275 (2006), Eq. 71).
    """
    n, k = harmonics + 1, np.arange(harmonics)
    q = math.pi / n
    s, c = sincos(k * q)
    return np.asarray(((n - k) * c + s / tan(q)) / n, dtype=float)


def transformed(depth: Array, harmonics: int) -> tuple[Array, Array]:
    """Return the smoothed Fourier coefficients (m) of depths around surfaces, shape (..., places): cosines
    and sines, shape (..., harmonics) each, at least those of the mean.
    """
    harmonics = max(harmonics, 1)
    k, g = np.arange(harmonics), jackson(harmonics)
    weights = np.where(k == 0, 1.0, 2.0) / PLACES * g
    s, c = sincos(np.outer(k, ANGLES))
    return weights * times(c, depth), weights * times(s, depth)


def smooth(depth: Array, harmonics: int) -> Array:
    """Return depths (m) at all places as the contact geometry uses them: transformed and back."""
    return around(*transformed(depth, harmonics))


def around(cosines: Array, sines: Array) -> Array:
    """Return the values of Fourier series, shape (..., harmonics), at all places, shape (..., places)."""
    s, c = sincos(np.outer(ANGLES, np.arange(cosines.shape[-1])))
    return np.asarray(times(c, cosines) + times(s, sines), dtype=float)


def largest_change(change: Array, harmonics: int) -> float:
    """Return the size (m) of a change of depths: that of the place with the largest change, smoothed as the
    contact geometry uses it.
    """
    return float(np.abs(smooth(change, harmonics)).max())


def start_depth(surfaces: Sequence[Surface]) -> Array:
    """Return the depths (m) of the profiles at the start, shape (surfaces, places)."""
    return np.stack([depth_at(surface.profile, ANGLES)[0] for surface in surfaces])


def profiles(surfaces: Sequence[Surface], depth: Array, harmonics: int) -> list[tuple[Array, Array]]:
    """Return cosines and sines (m) of each surface's profile: that at the start plus that of the ``depth``
    (m) lost since, shape (surfaces, places).
    """
    cosines, sines = transformed(depth, harmonics)
    for row, (surface, c, s) in enumerate(zip(surfaces, cosines, sines, strict=True)):
        for k in range(min(len(c), (len(surface.profile) + 1) // 2)):
            a, b = (surface.profile[0], 0.0) if k == 0 else surface.profile[2 * k - 1 : 2 * k + 1]
            c[k], s[k] = c[k] + a, s[k] + b
        cosines[row], sines[row] = c, s
    return list(zip(cosines, sines, strict=True))


def harmonics_of(
    surfaces: Sequence[Surface], depth: Array, harmonics: int, assembly: Assembly
) -> tuple[Array, Array]:
    """Return cosines and sines (m) of all profiles in the order of the assembly's rows."""
    series = {
        (surface.joint, surface.side): pair
        for surface, pair in zip(surfaces, profiles(surfaces, depth, harmonics), strict=True)
    }
    cosines, sines = (
        assembly.state[assembly.layout.rows_of(f"harmonic_{part}")].copy() for part in ("cosine", "sine")
    )
    at = 0
    for joint, counts in zip(assembly.contact_joints, assembly.topology.profiles, strict=True):
        for side, count in zip(SIDES, counts, strict=True):
            if (joint, side) in series:
                profile = slice(at, at + len(series[joint, side][0]))
                cosines[profile], sines[profile] = series[joint, side]
            at += count
    return cosines, sines


def rates(record: Record, surfaces: Sequence[Surface], turns: int) -> tuple[Array, list[float]]:
    """Return the depth (m) per turn at each place, shape (surfaces, places), and for each surface the
    relative standard error of the mean volume per turn.
    """
    depth, spread = np.zeros((len(surfaces), PLACES)), []
    for row, surface in enumerate(surfaces):
        contact = record.assembly.contact_joints.index(surface.joint)
        # Archard: depth = k times work of the normal force over sliding, per area of a place.
        part, side = rubbing(record, contact, surface.side), SIDES.index(surface.side)
        depth[row] = surface.k / areas(record, contact)[side] * work_around(part) / turns
        turn_work = part.work.reshape(turns, -1).sum(axis=1)
        mean = float(turn_work.mean())
        spread.append(
            float(turn_work.std(ddof=1) / math.sqrt(turns) / mean) if turns > 1 and mean > 0.0 else 0.0
        )
    return depth, spread


def life_end(spec: WearSpec, numbers: dict[str, Any], last: dict[str, Any] | None) -> dict[str, Any]:
    """Return turns, joint and limit (``by``) if a life ends at this point, else an empty dictionary.

    ``last`` are the numbers of the point before. The turn at which a force reaches its limit is interpolated
    between the two points; that of a clearance is exact, because the last jump ends there.
    """
    for joint, clearance, force in zip(numbers["joints"], numbers["play"], numbers["force"], strict=True):
        if spec.clearance is not None and clearance >= spec.clearance * (1.0 - 1e-9):
            return {"turns": numbers["turns"], "joint": joint, "by": "clearance"}
        if spec.force is not None and force >= spec.force:
            former_force = 0.0 if last is None else last["force"][numbers["joints"].index(joint)]
            share = 1.0 if last is None else (spec.force - former_force) / (force - former_force)
            begin = numbers["turns"] if last is None else last["turns"]
            return {"turns": begin + share * (numbers["turns"] - begin), "joint": joint, "by": "force"}
    return {}


def clearances(surfaces: Sequence[Surface], depth: Array, harmonics: int) -> list[float]:
    """Return the clearance (m) of each worn joint: the original one plus the depths of the deepest places of
    its surfaces, smoothed as the contact geometry uses them.
    """
    depths = smooth(depth, harmonics) + start_depth(surfaces)
    clearance = {surface.joint: surface.clearance for surface in surfaces}
    for surface, around_it in zip(surfaces, depths, strict=True):
        clearance[surface.joint] += float(around_it.max())
    return list(clearance.values())


def sharpness(surfaces: Sequence[Surface], depth: Array, harmonics: int) -> float:
    """Return the largest relative curvature of worn profiles, -h''/(clearance + depth), with the maxima of
    both surfaces of a joint added.

    From 1 on, the journal is wider than the groove that it wore and would touch its two edges, while the
    contact geometry knows one place of contact only.
    """
    curvature: dict[str, float] = {}
    for surface, (cosines, sines) in zip(surfaces, profiles(surfaces, depth, harmonics), strict=True):
        k = np.arange(len(cosines))
        second = around(k * k * cosines, k * k * sines)
        curvature[surface.joint] = curvature.get(surface.joint, 0.0) + float(second.max())
    clearance = dict(zip(curvature, clearances(surfaces, depth, harmonics), strict=True))
    return max(curvature[joint] / clearance[joint] for joint in curvature)


def wear_result(
    name: str, spec: WearSpec, points: Sequence[WearPoint], step_difference: Sequence[float] = ()
) -> Worn:
    """Return the result that consists of ``points``."""
    surfaces = surfaces_of(loads(spec.model))
    numbers = [point.numbers for point in points]
    column = {
        key: np.array([row[key] for row in numbers])
        for key in ("turns", "play", "force", "error", "spread", "sharp")
    }
    return Worn(
        name, spec, tuple(surfaces), tuple(numbers[0]["joints"]), column["turns"],
        start_depth(surfaces) + np.stack([point.depth for point in points]),
        np.stack([point.rate for point in points]), column["play"], column["force"], column["error"],
        column["spread"], column["sharp"],
        numbers[-1]["simulated"], numbers[-1]["ended"], tuple(step_difference),
    )  # fmt: skip


def with_wear(mechanism: Mechanism, coefficient: float | str | None, caller: str) -> Mechanism:
    """Return the mechanism with a ``coefficient`` of wear (1/Pa, or a pair of materials) for the joints that
    can wear and have no table; unchanged for None. Raises ModelError in the name of the ``caller``.
    """
    if coefficient is None:
        return mechanism
    try:
        value = COEFFICIENT.take(coefficient, written=isinstance(coefficient, str))
    except Fault as fault:
        raise ModelError([fault.at("wear")], caller) from None
    model = dataclasses.replace(mechanism, joints=dict(mechanism.joints))
    for name, joint in mechanism.contacts.items():
        if joint.keeps_profile and joint.wear is None:
            model.joints[name] = dataclasses.replace(joint, wear=Wear(bearing=value, journal=value))
    return model
