"""Surfaces of joints with clearance: losses, sliding, pressure, load over the angle of a surface, and single
impacts.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..files import DataTable
from ..laws import Pair
from ..model.surfaces import surfaces
from ..numerics.elementwise import atan2, sincos
from ..solvers.record import Record
from .forces import places, slip
from .motion import crank_rotation, times, within_turn
from .normal_forces import largest_normal_forces, share_bounds
from .stops import output_interval, stop_contacts, stop_sentence
from .turns import Window, named, of_turn, of_window

Array = NDArray[np.float64]
SIDES = ("bearing", "journal")
HERTZIAN = "contact_pressure.max", "contact_half_width.max"
LOSS_BLOCKS = {"friction": "contact_friction", "impact": "contact_damping"}  # of lost work and power


def spent_energy(record: Record, kind: str) -> Array:
    """Return the energy (J) that each contact has lost to ``friction`` or ``impact`` since the start, shape
    (outputs, contacts).

    The step sums up span * power up to t_(n+1/2); at t_n that is the sum less dt/2 power. Over all contacts
    it is the ledger's loss.
    """
    half, name = 0.5 * record.assembly.choice.step, LOSS_BLOCKS[kind]
    return np.asarray(record.block(f"{name}_work") - half * record.block(f"{name}_power"), dtype=float)


def mean_power(record: Record, kind: str) -> Array:
    """Return the power (W) lost in each contact, averaged since the previous output so that nothing is
    missed, shape (outputs, contacts).
    """
    return mean_rate(spent_energy(record, kind), times(record))


def mean_rate(work: Array, time: Array) -> Array:
    """Return the mean rate of a sum over the interval that ends with each output, shape (outputs, contacts);
    0 at the first.
    """
    rate = np.zeros_like(work)
    np.divide(np.diff(work, axis=0), np.diff(time)[:, None], out=rate[1:])
    return rate


def per_joint(record: Record, values: Array) -> dict[str, Array]:
    """Sum ``values`` (contacts along the last axis) over the contacts of each joint; a block in a guide has
    four.
    """
    sums: dict[str, Array] = {}
    for k, name in enumerate(record.assembly.contact_joints):
        sums[name] = sums.get(name, 0.0) + values[..., k]
    return sums


def losses(record: Record, window: Window) -> dict[str, float]:
    """Return the energies lost over the window and their mean powers: the difference of :func:`spent_energy`
    at its ends, over its length.

    ``<joint>.friction_energy.total``, ``.impact_energy.total`` (J), ``.friction_power.mean``,
    ``.impact_power.mean`` (W).
    """
    part, values = of_turn(record, window), dict[str, float]()
    time = times(part)
    length = float(time[-1] - time[0])
    for kind in LOSS_BLOCKS:
        work = spent_energy(part, kind)
        for name, energy in per_joint(record, work[-1] - work[0]).items():
            values[f"{name}.{kind}_energy.total"] = float(energy)
            if length > 0.0:
                values[f"{name}.{kind}_power.mean"] = float(energy) / length
    return values


def sliding_speed(record: Record, reaches: tuple[Array, Array] | None = None) -> Array:
    """Return the velocity (m/s) of the journal's surface relative to the bearing's at the place of contact,
    along t = n turned anticlockwise, shape (outputs, contacts).

    n is that of the normal force (:func:`~vfife.measures.forces.normals`). Friction F_T along t takes the
    power -F_T v. The velocity is 0 where the surfaces are apart without a film between them. ``reaches`` are
    the :func:`~vfife.measures.forces.places`, if they are known.
    """
    if not record.assembly.contacts:
        return np.zeros((len(record.steps), 0))
    touches = _film(record) | (record.block("contact_penetration") > 0.0)
    return np.where(touches, slip(record, reaches), 0.0)


def _film(record: Record) -> NDArray[np.bool_]:
    """Return which contacts have a film between their surfaces, shape (contacts,)."""
    contacts = record.assembly.mechanism.contacts
    names = record.assembly.contact_joints
    return np.array([contacts[name].contact.film for name in names], dtype=bool)


def contact_time(record: Record) -> Array:
    """Return the time (s) in contact within the interval up to each output, summed over its steps, shape
    (outputs, contacts).
    """
    return np.diff(record.block("contact_duration"), axis=0, prepend=0.0)


def largest_sliding(record: Record, window: Window) -> dict[str, float]:
    """Return ``<contact>.sliding_velocity.max`` (m/s), max|v| at the outputs, and
    ``<joint>.sliding_distance.total`` (m).

    The distance is the sum over the intervals between outputs of the time in contact times |v|: the mean of
    |v| at both outputs where the contact touches at both, |v| at the one where it touches at one.
    """
    # The time in contact within an interval is exact. The sum of |v| over all steps would need another row of
    # the state for each contact.
    part, inside = of_window(record, window)
    speed, turn = np.abs(sliding_speed(part)), of_turn(record, window, part)
    speeds = speed if turn is part else np.abs(sliding_speed(turn))
    touches = np.asarray(_film(turn) | (turn.block("contact_penetration") > 0.0), dtype=float)
    ends = touches[1:] + touches[:-1]
    mean = (speeds[1:] + speeds[:-1]) / np.maximum(ends, 1.0)
    way = (mean * np.diff(turn.block("contact_duration"), axis=0)).sum(axis=0)
    values = named(record.assembly.contacts, {"sliding_velocity.max": speed[inside].max(axis=0)})
    return values | {
        f"{name}.sliding_distance.total": float(value) for name, value in per_joint(record, way).items()
    }


# Half-width over journal radius beyond which half-spaces no longer represent the surfaces (Johnson 1985,
# Section 5.3).
CONFORMAL = 0.3


def line_pressure(pair: Pair, force: Array) -> tuple[Array, Array]:
    """Return the largest pressure (Pa) and half-width (m) of two cylinders pressed together over their axial
    length by a force (N) of any shape.

    a = sqrt(4 F R/(pi L E*)) and p_0 = 2 F/(pi a L), R = R_B R_J/(R_B -+ R_J), minus for a journal in its
    bearing: Hertz' line contact; Johnson, Contact Mechanics (1985), Eq. 4.43 and 4.45. No contact is wider
    than its journal: a is R_J at the most, where p_0 becomes 4 F/(pi d L), that of a snug pin whose pressure
    goes with the cosine. From a = 0.3 R_J (``CONFORMAL``) on Hertz' half-spaces are a coarse picture, and p_0
    is too low.
    """
    per_length, radius = np.maximum(force, 0.0) / pair.axial_length, pair.relative_radius
    pressure = np.sqrt(per_length * pair.composite_modulus / (math.pi * radius))
    half = np.sqrt(4.0 * per_length * radius / (math.pi * pair.composite_modulus))
    journal = pair.journal_radius
    return np.maximum(pressure, 2.0 * per_length / (math.pi * journal)), np.minimum(half, journal)


def mean_pressure(pair: Pair, force: Array) -> Array:
    """Load on a bearing (Pa): F/(2 R_J L), over the projected area of the journal; beside another round or on
    a line F/(2 a L), over the contact.

    The first is the p of the p v of plain bearings (ISO 4379, makers' tables).
    """
    half = np.maximum(line_pressure(pair, force)[1], 1e-300) if pair.external else pair.journal_radius
    return np.asarray(np.maximum(force, 0.0) / (2.0 * half * pair.axial_length), dtype=float)


def pairs(record: Record) -> list[Pair]:
    """Return the surfaces of each contact; a corner of a block in a guide is a round on a line."""
    mechanism = record.assembly.mechanism
    return [surfaces(mechanism, mechanism.contacts[name]) for name in record.assembly.contact_joints]


class Pressures(NamedTuple):
    """Largest ``pressure`` (Pa), ``half_width`` (m) and load on the ``bearing`` (Pa), shape (outputs,
    contacts) each.
    """

    pressure: Array
    half_width: Array
    bearing: Array


def pressures(record: Record) -> Pressures:
    """Return the pressures of each contact at the outputs."""
    force = record.block("contact_normal_force")
    values = np.zeros((3, *force.shape))
    for k, pair in enumerate(pairs(record)):
        values[0, :, k], values[1, :, k] = line_pressure(pair, force[:, k])
        values[2, :, k] = mean_pressure(pair, force[:, k])
    return Pressures(*values)


def largest_pressures(record: Record, window: Window) -> dict[str, float]:
    """Return the largest Hertz pressure and half-width of each contact, and the p v of its bearing
    (:func:`line_pressure`).

    ``<contact>.contact_pressure.max`` (Pa) and ``.contact_half_width.max`` (m) are of the largest normal
    force between outputs (:mod:`~vfife.measures.normal_forces`).
    ``.pressure_velocity.max`` and ``.mean`` (W/m^2) are of |F/(2 R_J L) v| at the outputs, the mean over
    time, in which the surfaces apart count as zero.
    """
    names = record.assembly.contacts
    force = largest_normal_forces(record, window)
    extremes = np.array(
        [line_pressure(pair, load) for pair, load in zip(pairs(record), force, strict=True)]
    ).reshape(-1, 2)
    values = named(names, dict(zip(HERTZIAN, extremes.T, strict=True)))
    if not names or not record.keeps("particle_u"):
        return values
    part, inside = of_window(record, window)
    product = pressures(part).bearing * np.abs(sliding_speed(part))
    quantities = {"pressure_velocity.max": product[inside].max(axis=0)}
    turn = of_turn(record, window, part)
    time = times(turn)
    if len(time) > 1:
        product = product if turn is part else pressures(turn).bearing * np.abs(sliding_speed(turn))
        means = [
            float(np.trapezoid(power, time) / (time[-1] - time[0]))
            for power in np.ascontiguousarray(product.T)
        ]
        quantities["pressure_velocity.mean"] = np.array(means)
    return values | named(names, quantities)


def pressure_bounds(record: Record, window: Window | slice) -> dict[str, tuple[float, float]]:
    """Return the bounds of the largest pressures and half-widths, by measure, as multiples of their values,
    where the friction in the largest forces is estimated; none where outputs meet those.
    """
    names, result = record.assembly.contacts, dict[str, tuple[float, float]]()
    bounds = share_bounds(record, window) if names else {}
    forces = largest_normal_forces(record, window) if bounds else ()
    for name, pair, force in zip(names, pairs(record), forces, strict=False):
        if name in bounds:
            loads = force * np.array([bounds[name][0], 1.0, bounds[name][1]])
            for kind, (low, value, high) in zip(HERTZIAN, line_pressure(pair, loads), strict=True):
                result[f"{name}.{kind}"] = float(low / value), float(high / value)
    return result


def contact_angle(record: Record, side: str = "bearing", reaches: tuple[Array, Array] | None = None) -> Array:
    """Return the angle (rad, from -pi to pi) of the place of contact seen from the pin of a ``side``, in the
    frame of that side's body, (outputs, contacts).

    It counts from the x axis of the body, of a link from start to end; of the ground it is the global one.
    Apart, the place nearest to contact. ``reaches`` are the :func:`~vfife.measures.forces.places`, if they
    are known.
    """
    assembly = record.assembly
    if not assembly.contacts:
        return np.zeros((len(record.steps), 0))
    place = (places(record) if reaches is None else reaches)[SIDES.index(side)]
    turned = record.block("particle_theta")[:, list(getattr(assembly.topology, f"contact_{side}"))]
    x, y = place[..., 0], place[..., 1]
    s, c = sincos(turned)
    return np.asarray(atan2(c * y - s * x, c * x + s * y), dtype=float)


@dataclass(frozen=True)
class Around:
    """Load on a joint's surface over its angle in the frame of its body, ``edges`` (rad), shape (bins + 1,).

    ``time`` in contact (s), ``impulse`` of the normal force (N s) and ``friction`` energy (J), shape
    (contacts, bins) each.
    """

    side: str
    names: tuple[str, ...]
    edges: Array = field(repr=False)
    time: Array = field(repr=False)
    impulse: Array = field(repr=False)
    friction: Array = field(repr=False)

    @property
    def middles(self) -> Array:
        """Middle of each bin (rad), shape (bins,)."""
        return np.asarray(0.5 * (self.edges[1:] + self.edges[:-1]), dtype=float)


def around(record: Record, side: str = "bearing", bins: int = 72, window: Window | None = None) -> Around:
    """Distribute the load on a ``side`` ("bearing" or "journal") over its angle, of the run or of a window.

    Time in contact and friction energy are summed over all steps and assigned to the angle of the output that
    ends their interval, so the bins add up to those of the run. The impulse is the normal force at the
    outputs times that time. Raises ValueError for another side.
    """
    if side not in SIDES:
        raise ValueError(f'side = "{side}"; allowed: "bearing" or "journal"')
    edges = np.linspace(-np.pi, np.pi, bins + 1)
    angle, touching = contact_angle(record, side), contact_time(record)
    rubbed = (
        np.diff(spent_energy(record, "friction"), axis=0, prepend=0.0)
        if record.assembly.contacts
        else touching
    )
    terms = (touching, touching * record.block("contact_normal_force"), rubbed)
    inside = np.ones(len(record.steps), dtype=bool) if window is None else window
    sums = np.zeros((3, len(record.assembly.contacts), bins))
    for k in range(len(record.assembly.contacts)):
        for row, values in zip(sums, terms, strict=True):
            row[k] = np.bincount(bin_of(angle[inside, k], edges), values[inside, k], bins)
    return Around(side, tuple(record.assembly.contacts), edges, *sums)


def bin_of(angle: Array, edges: Array) -> NDArray[np.intp]:
    """Return the number of the bin of an angle (rad); the last bin contains both its edges.

    numpy.histogram is not used because it adds weights of one angle in an order of its own.
    """
    return np.asarray(
        np.clip(np.searchsorted(edges, angle, side="right") - 1, 0, len(edges) - 2), dtype=np.intp
    )


def knock_speeds(record: Record) -> tuple[Array, NDArray[np.bool_]]:
    """Return the largest approach speed (m/s) of each contact at an onset after the first output of a record,
    and whether it is the largest of the run up to its end, shape (contacts,) each.

    A record that begins with a run has all its contacts. The step keeps the hardest since the start of the
    run. Where a harder one came before the record, the speed is the largest of those between two outputs, a
    mean if several began there.
    """
    onsets, sums, fastest = (
        record.block(name) for name in ("contact_onsets", "contact_approach", "contact_fastest")
    )
    began, speeds = np.diff(onsets, axis=0), np.diff(sums, axis=0)
    means = np.divide(speeds, began, out=np.zeros_like(speeds), where=began > 0.0).max(axis=0, initial=0.0)
    hardest = (fastest[-1] > fastest[0]) | (record.steps[0] == 0)
    return np.where(hardest, fastest[-1], means), hardest


@dataclass(frozen=True)
class Impact:
    """A contact that began in a joint with clearance, or ``count`` of them if several began between two
    outputs.

    It began after ``since`` (s) and up to ``time`` (s), the output that shows it, with the crank between the
    angles ``crank_since`` and ``crank`` (degrees, 0 to 360, None without one). ``speed`` (m/s): normal
    approach speed, located inside the step; the mean of several. ``energy`` (J) lost in normal damping and
    ``depth`` (m), the largest penetration, are up to the next entry of the joint.

    ``struck`` of a :class:`~vfife.dynamics.PoincareSection` has the time of each onset, located inside the
    step.
    """

    joint: str
    since: float
    time: float
    crank: float | None
    count: int
    speed: float | None
    energy: float
    depth: float
    crank_since: float | None = None


@dataclass(frozen=True)
class Impacts(DataTable):
    """Impacts in the order of time; ``alone`` of ``count`` have an entry of their own. ``before`` (J): energy
    lost before the first. Contacts at stops are no impacts: ``stops`` has their number by name, as the
    outputs show them, and ``interval`` (s) that of the outputs: shorter contacts may be missed.
    """

    entries: tuple[Impact, ...]
    before: float
    stops: Mapping[str, int] = field(default_factory=dict)
    interval: float | None = None

    @property
    def count(self) -> int:
        """Number of contacts that began."""
        return sum(entry.count for entry in self.entries)

    @property
    def alone(self) -> int:
        """Number of those with an entry of their own."""
        return sum(entry.count == 1 for entry in self.entries)

    def __repr__(self) -> str:
        shared = self.count - self.alone
        part = f", {shared} of them in entries with others" if shared else ""
        count = f"{self.count} impacts in {len(self.entries)} entries{part}"
        stops = f" {stop_sentence(self.stops, self.interval)}" if self.stops else ""
        return f"<{count}; see .hardest(most), .to_dataframe()>{stops}"

    def table(self) -> Iterator[Sequence[object]]:
        """Yield a row for each entry, with the units of its columns."""
        yield [
            "joint",
            "since [s]",
            "time [s]",
            "crank [deg]",
            "count",
            "speed [m/s]",
            "energy [J]",
            "depth [m]",
            "crank since [deg]",
        ]
        yield from (dataclasses.astuple(entry) for entry in self.entries)

    def hardest(self, most: int) -> tuple[Impact, ...]:
        """Return the entries with the largest energy loss, the largest first."""
        return tuple(sorted(self.entries, key=lambda entry: -entry.energy)[:most])

    def fastest(self, most: int) -> tuple[Impact, ...]:
        """Return the entries with the largest approach speed, the largest first."""
        return tuple(sorted(self.entries, key=lambda impact: -(impact.speed or 0.0))[:most])


def impacts(record: Record) -> Impacts:
    """List the contacts that began in a run, from the counts, sums of speeds and works that the step keeps at
    every onset.

    None is missed, however short: those that began between the same two outputs share an entry with their
    number, so more outputs separate more of them. The energies of all entries and ``before`` add up to the
    ledger's loss in contacts.
    """
    assembly, stops, interval = record.assembly, stop_contacts(record), output_interval(record)
    if not assembly.contacts or not record.keeps("contact_onsets"):
        return Impacts((), 0.0, stops, interval)
    time, rotation = times(record), crank_rotation(record)
    crank = None if rotation is None else within_turn(rotation)
    onsets, work = record.block("contact_onsets"), spent_energy(record, "impact")
    speeds = record.block("contact_approach") if record.keeps("contact_approach") else None
    depths = record.block("contact_penetration_max")
    entries: list[Impact] = []
    earlier = 0.0
    for k, name in enumerate(assembly.contacts):
        began = np.diff(onsets[:, k], prepend=0.0)
        at = np.flatnonzero(began > 0.0)
        earlier += (
            float(work[at[0] - 1, k]) if len(at) and at[0] > 0 else 0.0 if len(at) else float(work[-1, k])
        )
        for row, following in zip(
            at.tolist(), [*at.tolist(), len(time)][1:], strict=True
        ):  # none, where a contact never began
            spent = work[following - 1, k] - (work[row - 1, k] if row else 0.0)
            mean = (
                None
                if speeds is None
                else float((speeds[row, k] - (speeds[row - 1, k] if row else 0.0)) / began[row])
            )
            angles = (None, None) if crank is None else (float(crank[max(row - 1, 0)]), float(crank[row]))
            depth = max(float(depths[row:following, k].max()), 0.0)
            entries.append(
                Impact(
                    name,
                    float(time[max(row - 1, 0)]),
                    float(time[row]),
                    angles[1],
                    int(began[row]),
                    mean,
                    float(spent),
                    depth,
                    angles[0],
                )
            )
    ordered = tuple(sorted(entries, key=lambda entry: (entry.time, entry.joint)))
    return Impacts(ordered, earlier, stops, interval)
