"""Joint forces, moments and accelerations over the crank angle with the ideal ones (Figs. 16-17 of the VFIFE
paper); energies over time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..measures.error_ranges import band
from ..measures.forces import joint_force, joint_force_max, joint_moment, joint_rows
from ..measures.motion import slider_motion, sliders
from ..measures.zero_limits import about_zero
from ..numerics.elementwise import hypot
from ..results.run_data import RunData
from ..solvers.record import Record
from .layout import Panels
from .style import (
    BLUE,
    GREEN,
    GREY,
    IDEAL,
    INK,
    ORANGE,
    PREFIXED,
    PURPLE,
    SKY,
    VERMILION,
    Array,
    corner_text,
    mark_peak,
    peak_digits,
    readable,
    scale_of,
    turns_digits,
)
from .turn import Span, shown_part, shown_span

NOISE = 1e-5  # of the largest force or moment (N, N m), below which a joint carries nothing
ROUNDING = 1e-6  # of the largest acceleration, below which one is what rounding leaves


@dataclass(frozen=True)
class Quantity:
    """A quantity over time.

    ``samples`` gives its values at the outputs of a record, shape (outputs,); ``extremes`` the largest size
    since the output before; ``peak`` is the name of the measure of its largest value.
    """

    title: str
    kind: str
    unit: str
    samples: Callable[[Record], Array]
    extremes: Callable[[Record], Array] | None = None
    peak: str = ""

    def sizes(self, record: Record) -> Array | None:
        """Return the largest size since the output before, shape (outputs,); None if none is recorded."""
        return None if self.extremes is None or record.static else self.extremes(record)

    def recorded(self, record: Record) -> Array:
        """Return the largest size since the output before, or the samples where it is not recorded."""
        sizes = self.sizes(record)
        return self.samples(record) if sizes is None else sizes

    def largest(self, record: Record) -> float:
        """Return the largest size over a whole record."""
        values = [self.samples(record), self.recorded(record)]
        return float(np.nanmax(np.abs(values), initial=0.0))

    def extreme(self, record: Record) -> Array:
        """Return the extreme since the output before, with the sign of the output, shape (outputs,)."""
        samples, sizes = self.samples(record), self.sizes(record)
        if sizes is None:
            return samples
        sizes = np.maximum(sizes, np.abs(samples))
        sizes[0] = np.abs(samples[0])
        return np.copysign(sizes, samples)


def joint_forces(result: RunData) -> dict[str, Quantity]:
    """Return the size of the force of each joint that carries one, in the order of tables."""
    shared = SharedForces()
    forces = {name: _force(result, name, shared) for name in joint_rows(result.record)}
    moments = [quantity.largest(result.record) for quantity in _all_moments(result).values()]
    return _significant(result, forces, max(moments, default=0.0))


def moments(result: RunData) -> dict[str, Quantity]:
    """Return the moment of each gear, weld, guide and driver that has one, and torque of each driver."""
    return _significant(result, _all_moments(result))


def _all_moments(result: RunData) -> dict[str, Quantity]:
    """Return the same with zero moments."""
    record, quantities = result.record, {}
    for name, (block, _) in joint_rows(record).items():
        if block == "joint":
            samples, extremes = _column(joint_moment, name), _moment_max(name)
            quantities[name] = Quantity(
                title_of(result, name), "moment", "N m", samples, extremes, f"{name}.moment.max"
            )
    for name, body in record.assembly.bodies.items():
        if body.driven is not None and not record.static and record.keeps("driven_torque_max"):
            torque, extremes = (
                _of_body(block, name, "driven") for block in ("driven_torque", "driven_torque_max")
            )
            quantities[f"{name} "] = Quantity(
                f"drive of {name}", "torque", "N m", torque, extremes, f"{name}.torque.max"
            )
    return quantities


def accelerations(result: RunData) -> dict[str, Quantity]:
    """Return the acceleration of each slider along its guide, and angular acceleration of each other body
    that is not driven.
    """
    record = result.record
    if record.static:
        return {}
    sliding, turning, gliding = {}, {}, set()
    for name in sliders(record) if record.keeps("particle_u") else ():
        slider = record.assembly.mechanism.joints[name].sides[1][0]
        gliding.add(slider)
        sliding[name] = Quantity(
            f"{slider} along {name}", "acceleration", "m/s²", _sliding_acceleration(name),
            peak=f"{name}.acceleration.max",
        )  # fmt: skip
    for name, body in record.assembly.bodies.items():
        measure = f"{name}.angular_acceleration.max"
        if body.driven is None and name not in gliding and result.measures.get(measure):
            samples, extremes = (_of_body(block, name, "row") for block in ("body_alpha", "body_alpha_max"))
            turning[f"{name} "] = Quantity(name, "angular acceleration", "rad/s²", samples, extremes, measure)
    return _significant(result, sliding, share=ROUNDING) | _significant(result, turning, share=ROUNDING)


def _sliding_acceleration(name: str) -> Callable[[Record], Array]:
    return lambda record: slider_motion(record, name).acceleration


def largest_forces(result: RunData, count: int) -> dict[str, Quantity]:
    """Return the ``most`` largest joint forces, in the order of tables."""
    return largest(result, joint_forces(result), count)


def largest(result: RunData, quantities: dict[str, Quantity], count: int) -> dict[str, Quantity]:
    """Return the ``most`` quantities with the largest values, in the same order."""
    chosen = sorted(quantities, key=lambda name: -quantities[name].largest(result.record))[:count]
    return {name: quantity for name, quantity in quantities.items() if name in chosen}


def title_of(result: RunData, name: str) -> str:
    """Return the title of the panel of a joint, gear or driver."""
    mechanism = result.record.assembly.mechanism
    return (
        "joint " if name in mechanism.joints else "gear " if name in mechanism.gears else "driver "
    ) + name


class SharedForces:
    """Forces of all joints, computed once for each record of a figure: the run, the ideal mechanism,
    companions.
    """

    def __init__(self) -> None:
        self.cache: list[tuple[Record, Callable[[Record], Array], Array]] = []

    def column(self, of: Callable[[Record], Array], name: str) -> Callable[[Record], Array]:
        """Return a function of a record that returns a joint's column of what ``of`` computes."""
        return lambda record: np.array(self._values(of, record)[:, list(joint_rows(record)).index(name)])

    def _values(self, of: Callable[[Record], Array], record: Record) -> Array:
        for cached_record, function, values in self.cache:
            if cached_record is record and function is of:
                return values
        self.cache.append((record, of, of(record)))
        return self.cache[-1][2]


def _force_sizes(record: Record) -> Array:
    force = joint_force(record)
    return np.asarray(hypot(force[..., 0], force[..., 1]), dtype=float)


def _force(result: RunData, name: str, shared: SharedForces) -> Quantity:
    extremes = None if result.record.static else shared.column(joint_force_max, name)
    size = shared.column(_force_sizes, name)
    return Quantity(title_of(result, name), "force", "N", size, extremes, f"{name}.force.max")


def _significant(
    result: RunData, quantities: dict[str, Quantity], largest: float = 0.0, share: float = NOISE
) -> dict[str, Quantity]:
    """Return the quantities that exceed a share of the largest of them, and of ``largest``, and whose peaks
    are not about zero.
    """
    sizes = {name: quantity.largest(result.record) for name, quantity in quantities.items()}
    noise = share * max([largest, *sizes.values()])
    small = about_zero(result.record, result.measures)
    return {
        name: quantity
        for name, quantity in quantities.items()
        if sizes[name] > noise and quantity.peak not in small
    }


def _column(of: Callable[[Record], Array], name: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(of(record)[:, list(joint_rows(record)).index(name)], dtype=float)


def _moment_max(name: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(
        record.block("joint_moment_max")[:, joint_rows(record)[name][1][0]], dtype=float
    )


def _of_body(block: str, name: str, place: str) -> Callable[[Record], Array]:
    return lambda record: np.asarray(
        record.block(block)[:, getattr(record.assembly.bodies[name], place)], dtype=float
    )


MOST_PANELS = 16  # panels of a figure; of more those with the largest values
# A band is drawn if it exceeds the outputs by this share of the largest value.
VISIBLE = 0.004
PANEL = (4.6, 2.05)  # inches
ALONE = (8.0, 2.9)  # of a panel without another one


@dataclass(frozen=True)
class Reach:
    """Values of a quantity over a span: ``line`` at the outputs, ``low`` and ``high`` the extremes between
    them and over all turns.
    """

    line: Array
    low: Array
    high: Array

    @property
    def largest_size(self) -> float:
        """Size of the largest value."""
        return float(np.nanmax(np.abs([self.line, self.low, self.high]), initial=0.0))

    @property
    def exceeds_outputs(self) -> bool:
        """Whether the extremes are visibly beyond the outputs on both sides of them."""
        previous = np.append(self.line[:1], self.line[:-1])
        beyond_top = self.high - np.maximum(self.line, previous)
        beyond_bottom = np.minimum(self.line, previous) - self.low
        return bool(np.nanmax([beyond_top, beyond_bottom], initial=0.0) > VISIBLE * self.largest_size)


def force_curves(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of the size of each joint's force over the last crank turn, one panel a joint, in the
    order of tables.
    """
    return curves(result, reference, joint_forces(result), "joint forces")


def moment_curves(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of the moment of each gear, weld, guide and driver that has one, and torque of what is
    driven.
    """
    return curves(result, reference, moments(result), "moments")


def acceleration_curves(result: RunData, reference: RunData | None = None) -> Figure:
    """Return a figure of the acceleration of sliders along their guides, and angular acceleration of each
    other body that is not driven.
    """
    return curves(result, reference, accelerations(result), "accelerations")


def curves(result: RunData, reference: RunData | None, quantities: dict[str, Quantity], title: str) -> Figure:
    """Return a figure with a panel for each quantity: samples as a line, a band to the extremes between them,
    the ideal mechanism, the reported peak.
    """
    chosen = list(largest(result, quantities, MOST_PANELS).values())
    panels = Panels.alike(len(chosen), 2, PANEL, ALONE)
    span = shown_span(result)
    for ax, quantity in zip(panels.axes, chosen, strict=True):
        draw(ax, result, reference, quantity, span)
        span.set_limits(ax)
        ax.set_title(quantity.title)
    panels.label_lowest(span.title, hide=True)
    return panels.close(f"{result.name}: {title}{shown_part(result, span)}")


def reach_of(result: RunData, quantity: Quantity, span: Span) -> Reach:
    """Return the extremes of a quantity at each output of a span. They are recorded as sizes since the last
    output and take the sign of the sample. A size no larger than those of the two samples is theirs: where
    the sign changes it belongs to the earlier one.
    """
    record = result.record
    samples = quantity.samples(record)
    turns = span.overlaid(samples)
    low, high = turns.min(axis=0), turns.max(axis=0)
    if (sizes := quantity.sizes(record)) is not None and len(samples) > 1:
        sample_sizes = np.abs(samples)
        exceeds = sizes > np.maximum(sample_sizes, np.append(sample_sizes[:1], sample_sizes[:-1]))
        reach = span.overlaid(np.copysign(np.where(exceeds, sizes, sample_sizes), samples))[:, 1:]
        low[1:], high[1:] = np.minimum(low[1:], reach.min(axis=0)), np.maximum(high[1:], reach.max(axis=0))
    return Reach(samples[span.outputs], low, high)


def draw(ax: Axes, result: RunData, reference: RunData | None, quantity: Quantity, span: Span) -> None:
    """Draw one quantity on its axes."""
    reach = reach_of(result, quantity, span)
    ideal = ideal_curve(reference, quantity.samples, span)
    ideal_size = 0.0 if ideal is None else float(np.nanmax(np.abs(ideal[1])))
    factor, unit = scale_of(max(reach.largest_size, ideal_size), quantity.unit)
    _companions(ax, result, quantity, span, factor)
    if reach.exceeds_outputs:
        x, low = span.placed(factor * reach.low)
        _, high = span.placed(factor * reach.high)
        name = "extremes between outputs" if span.turns is None else "from turn to turn, and between outputs"
        ax.fill_between(x, low, high, color=SKY, alpha=0.55, lw=0.0, label=name, zorder=3.6)
        for edge in (low, high):
            ax.plot(x, edge, color=SKY, lw=0.7, zorder=3.7)
    if ideal is not None:
        ax.plot(ideal[0], factor * ideal[1], **IDEAL, zorder=4.2)
    look: dict[str, Any] = {"marker": "o", "ms": 3.0} if len(span.x) < 40 else {}
    ax.plot(*span.placed(factor * reach.line), color=BLUE, lw=0.9, label="at the outputs", zorder=4, **look)
    _peak(ax, result, quantity, span, reach, factor, unit)
    ax.set_ylabel(f"{quantity.kind} ({unit})")
    ax.margins(y=0.08)


def _peak(
    ax: Axes, result: RunData, quantity: Quantity, span: Span, reach: Reach, factor: float, unit: str
) -> None:
    """Mark the reported peak and write its value; of a mean over turns also the range of single turns that
    the answer has. The highest of the turns that are drawn is marked.
    """
    measure = result.measures.get(quantity.peak)
    if measure is None:
        return
    sizes = np.maximum(np.abs(reach.low), np.abs(reach.high))
    k = int(np.argmax(sizes))
    top = reach.high if reach.high[k] >= -reach.low[k] else reach.low
    x, y = span.placed(np.where(np.arange(len(sizes)) == k, factor * top, np.nan))
    name = "peak that is reported" if span.turns is None else "highest of these turns"
    mark_peak(ax, x, y, top is reach.high, name)
    times = "" if quantity.unit in PREFIXED or factor == 1.0 else "× "
    peak = f"peak {peak_digits(measure, factor)}"
    if span.turns is not None:
        motion = result.motion.motion if result.motion is not None else ""
        single = turns_digits(measure, factor, motion)
        peak = f"mean {peak}, single turns {single}" if single else f"mean {peak}"
    corner_text(ax, f"{peak} {times}{unit}")


def _companions(ax: Axes, result: RunData, quantity: Quantity, span: Span, factor: float) -> None:
    """Draw the range of the companion runs."""
    sizes = quantity.extremes
    if result.record.companions is None or sizes is None or span.last != len(result.record.steps) - 1:
        return
    reach = band(result.record, sizes)
    if reach is None or len(reach[0]) != len(span.x):
        return
    # Companions keep sizes
    side = np.where(quantity.samples(result.record)[span.outputs] < 0.0, -factor, factor)
    (x, low), (_, high) = span.placed(side * reach[0]), span.placed(side * reach[1])
    ax.fill_between(
        x, low, high, color=ORANGE, alpha=0.6, lw=0.5, label="range of the companions", zorder=3.5
    )


def ideal_curve(
    reference: RunData | None, series: Callable[[Record], Array], span: Span
) -> tuple[Array, Array] | None:
    """Return the curve of a series of the ideal mechanism; None where it has no outputs over the same angles,
    as during a run-up.
    """
    if reference is None:
        return None
    try:
        x, y = span.curve_of(reference, series(reference.record))
    except (KeyError, ValueError, IndexError):
        return None
    return (x, y) if np.isfinite(y).sum() > 1 else None


# --------------------------------------------------------------------------------------------------- energies

STORED: dict[str, tuple[str, dict[str, Any]]] = {
    "kinetic": ("kinetic", {"color": BLUE}),
    "strain": ("strain of elastic links", {"color": GREEN}),
    "spring": ("springs", {"color": PURPLE}),
    "contact": ("contacts", {"color": SKY}),
}
SUPPLIED: dict[str, tuple[str, dict[str, Any]]] = {
    "driver": ("work of drivers", {"color": INK, "ls": (0, (5, 1.6))}),
    "external": ("work of weight, loads and driver torques", {"color": GREY, "ls": (0, (5, 1.6))}),
    "contact_loss": ("lost in impacts", {"color": VERMILION}),
    "friction_loss": ("lost in friction", {"color": ORANGE}),
    "damping_loss": ("lost in damping", {"color": INK, "ls": (0, (1, 1.2))}),
    "spring_loss": ("lost in dampers", {"color": GREY, "ls": (0, (1, 1.2))}),
}
ENERGIES = STORED | SUPPLIED
PRESENT = 1e-9  # of the largest term, below which one is nothing


def energy(result: RunData) -> Figure:
    """Plot stored energies, energies supplied and dissipated since the start, and the residual of the balance
    over time.
    """
    ledger, time = result.ledger, 1e3 * result.time
    panels = Panels([(4.6, 2.3), (4.6, 2.3), (4.6, 1.5)], 1)
    largest = max(float(np.abs(values).max()) for values in ledger.terms.values())
    for ax, terms, kind in (
        (panels.axes[0], STORED, "stored"),
        (panels.axes[1], SUPPLIED, "since the start"),
    ):
        present = {
            name: ledger.terms[name] for name in terms if np.abs(ledger.terms[name]).max() > PRESENT * largest
        }
        factor, unit = scale_of(
            max((float(np.abs(values).max()) for values in present.values()), default=0.0), "J"
        )
        for name, values in present.items():
            label, look = terms[name]
            ax.plot(time, factor * values, label=label, **({"lw": 1.2} | look))
        ax.set(ylabel=f"{kind} ({unit})", title="stored energy" if terms is STORED else "supplied and lost")
    factor, unit = readable(ledger.residual, "J")
    panels.axes[2].plot(time, factor * ledger.residual, color=BLUE, lw=1.0)
    panels.axes[2].set(ylabel=f"residual ({unit})", title="what the ledger leaves open")
    for ax in panels.axes:
        ax.set_xlim(time[0], time[-1] if time[-1] > time[0] else time[0] + 1.0)
    panels.label_lowest("time (ms)", hide=True)
    return panels.close(f"{result.name}: energy")
