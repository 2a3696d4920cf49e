"""Several runs in one figure: a panel for each quantity, and in it a line for each run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..errors import VfifeError, shown
from ..measures import elastic
from ..measures.motion import pin_path
from ..results.run_data import RunData
from .catalogue import ALL_FIGURES, FIGURES, check_names
from .curves import (
    ENERGIES,
    PRESENT,
    Quantity,
    accelerations,
    ideal_curve,
    joint_forces,
    largest,
    largest_forces,
)
from .curves import moments as all_moments
from .elastic import bodies_with_stress, links_with_deflection, nodes_and_middles, places
from .labels import run_labels
from .layout import Panels
from .motion import (
    MOST_PANELS,
    bearing_force,
    journals,
    loose_guides,
    points,
    portraits,
    relative_to_bearing,
    square,
    tilt_and_offset,
    touching,
)
from .spectra import latest_spectra, logarithmic_axis
from .style import (
    BLUE,
    GREEN,
    GREY,
    IDEAL,
    INK,
    ORANGE,
    PREFIXED,
    PURPLE,
    STYLE,
    VERMILION,
    Array,
    Figures,
    circle,
    corner_text,
    curve_look,
    legend_entries,
    peak_digits,
    scale_of,
)
from .turn import CRANK_ANGLE, Span, shown_span, shown_turn

RUNS: tuple[dict[str, Any], ...] = (  # colours of different brightness, and dashes, which a grey print keeps
    {"color": BLUE, "ls": "-"},
    {"color": ORANGE, "ls": (0, (6, 1.4))},
    {"color": INK, "ls": (0, (1.5, 1.1))},
    {"color": VERMILION, "ls": (0, (6, 1.4, 1.2, 1.4))},
    {"color": GREEN, "ls": (0, (3, 1.4))},
    {"color": PURPLE, "ls": (0, (6, 1.2, 1.2, 1.2, 1.2, 1.2))},
)
OF_RUN = ("whole", "amplitude")  # shapes of figures that are not of the outputs of a turn
MEAN, OF_MEAN = "means", " *"  # before peaks in narrow panels, and behind one that is a mean beside others
ALIKE = 1e-3  # of the largest value: ideal curves that differ by less are one


@dataclass(frozen=True)
class Curve:
    """A curve of a run in a panel. ``across`` and ``up``: words and SI unit of an axis, an empty unit for
    words that have theirs.

    ``peak`` is the reported peak, ``border`` a line that the motion does not leave, shape (points, 2).
    """

    x: Array
    y: Array
    across: tuple[str, str]
    up: tuple[str, str]
    peak: float | None = None
    border: Array | None = None
    ideal: tuple[Array, Array] | None = None
    span: Span | None = None


@dataclass(frozen=True)
class Overlay:
    """A figure of several runs: its title, the curves of a run by the titles of their panels, the panels, and
    how their axes are scaled.
    """

    title: str
    curves: Callable[[RunData], dict[str, Curve]]
    shape: str = "free"  # turn, square, equal, whole or amplitude
    columns: int = 2
    size: tuple[float, float] = (4.6, 2.3)
    alone: tuple[float, float] | None = (8.0, 3.0)


def _over_turn(quantities: Callable[[RunData], dict[str, Quantity]], run: RunData) -> dict[str, Curve]:
    """Return the curves of quantities: the largest since the output before, so that no peak is missed."""
    span, chosen = shown_span(run), largest(run, quantities(run), MOST_PANELS)
    return {
        quantity.title: Curve(
            *span.placed(quantity.extreme(run.record)[span.outputs]),
            (CRANK_ANGLE if span.angular else span.title, ""),
            (quantity.kind, quantity.unit),
            run.measures.get(quantity.peak),
            ideal=ideal_curve(run.reference, quantity.samples, span),
            span=span,
        )
        for quantity in chosen.values()
    }


def _part(run: RunData) -> slice:
    return shown_span(run).outputs


def _plane(points: Array, unit: str, **extra: Any) -> Curve:
    return Curve(points[:, 0], points[:, 1], ("x", unit), ("y", unit), **extra)


def _orbits(run: RunData) -> dict[str, Curve]:
    clearances = run.record.assembly.mechanism.clearances
    return {
        f"joint {name}": _plane(
            relative_to_bearing(run, name)[_part(run)], "m", border=circle(clearances[name].clearance).T
        )
        for name in journals(run)
    }


def _guides(run: RunData) -> dict[str, Curve]:
    curves = {}
    for name in loose_guides(run):
        tilt, offset = (values[_part(run)] for values in tilt_and_offset(run, name))
        curves[f"joint {name}"] = Curve(
            offset, tilt, ("offset", "m"), ("tilt", "rad"), border=touching(run, name)
        )
    return curves


def _traces(run: RunData) -> dict[str, Curve]:
    return {name: _plane(pin_path(run.record, *at)[_part(run)], "m") for name, at in points(run).items()}


def _polar(run: RunData) -> dict[str, Curve]:
    return {
        f"joint {name}": _plane(
            bearing_force(run, name)[_part(run)],
            "N",
            peak=run.measures.get(f"{name}.force.max"),
            span=shown_span(run),
        )
        for name in largest_forces(run, MOST_PANELS)
    }


def _phase(run: RunData) -> dict[str, Curve]:
    return {
        name: Curve(
            position[_part(run)],
            velocity[_part(run)],
            ("position", "m") if unit == "m" else ("angle (degrees)", ""),
            ("velocity" if unit == "m" else "angular velocity", rate),
        )
        for name, (unit, rate, position, velocity) in portraits(run).items()
    }


def _spectrum(run: RunData) -> dict[str, Curve]:
    curves = {}
    for force in largest_forces(run, MOST_PANELS).values():
        turning, spectra = latest_spectra(run, force)
        across = "order of the crank" if turning else "frequency (Hz)"
        curves[force.title] = Curve(
            spectra.abscissa, spectra.amplitudes, (across, ""), ("amplitude", force.unit)
        )
    return curves


def _energy(run: RunData) -> dict[str, Curve]:
    rotation = run.crank_rotation
    x = 1e3 * run.time if rotation is None else np.abs(rotation - rotation[0]) / 360.0
    across = "time (ms)" if rotation is None else "turns of the crank"
    terms, largest_energy = run.ledger.terms, run.ledger.largest
    return {
        label: Curve(x, terms[name], (across, ""), ("energy", "J"))
        for name, (label, _) in ENERGIES.items()
        if np.abs(terms[name]).max() > PRESENT * largest_energy
    }


def _stress(run: RunData) -> dict[str, Curve]:
    curves, gap = {}, [np.nan]
    tension, compression = elastic.fibres(run.record)
    for name in bodies_with_stress(run):
        elements = list(run.record.assembly.bodies[name].elements)
        x = places(run, name).ravel()
        upper, lower = (
            fibre[_part(run)][:, elements].reshape(-1, len(x)) for fibre in (tension, compression)
        )
        y = np.concatenate([upper.max(axis=0), gap, lower.min(axis=0)])
        curves[name] = Curve(np.concatenate([x, gap, x]), y, (f"along {name}", "m"), ("stress", "Pa"))
    return curves


def _deflection(run: RunData) -> dict[str, Curve]:
    curves = {}
    for name in links_with_deflection(run):
        off = elastic.chord_deflection(run.record, name)[_part(run)]
        shape = off[int(np.abs(off).max(axis=1).argmax())]
        curves[name] = Curve(nodes_and_middles(run, name), shape, (f"along {name}", "m"), ("deflection", "m"))
    return curves


SQUARE: Any = {"shape": "square", "columns": 3, "size": (3.0, 3.0), "alone": None}
OVERLAYS = {
    "orbits": Overlay("journal centres in their bearings", _orbits, **SQUARE),
    "guides": Overlay("blocks in their guides", _guides, size=(3.6, 3.0), columns=3, alone=None),
    "forces": Overlay("joint forces", partial(_over_turn, joint_forces), "turn"),
    "moments": Overlay("moments", partial(_over_turn, all_moments), "turn"),
    "accelerations": Overlay("accelerations", partial(_over_turn, accelerations), "turn"),
    "traces": Overlay("paths of points", _traces, **SQUARE | {"shape": "equal"}),
    "polar": Overlay("forces on journals, in the frames of their bearings", _polar, **SQUARE),
    "phase": Overlay("velocity over position", _phase, size=(3.9, 2.7), alone=None),
    "spectrum": Overlay("spectra of joint forces", _spectrum, "amplitude"),
    "energy": Overlay("energies since the start", _energy, "whole"),
    "stress": Overlay("largest and smallest stress along elastic bodies", _stress),
    "deflection": Overlay("largest deflection of elastic links", _deflection),
}


# -------------------------------------------------------------------------------------------- the figures


def overlays(runs: Sequence[RunData], names: Collection[str] = (), labels: Sequence[str] = ()) -> Figures:
    """Return figures of several runs by name: the usual ones, "all" that there are, or ``names``; ``labels``
    are the names of the runs.

    Raises VfifeError for runs that are more than can be told apart, for a figure that is unknown, not
    overlaid or without data in one of the runs, and for runs over different abscissae.
    """
    check_count(runs, labels)
    named = [*labels] or run_labels(runs)
    return Figures({name: overlay(name, runs, named) for name in overlaid(runs, names, named)[0]})


def check_count(runs: Sequence[Any], labels: Sequence[str]) -> None:
    """Raise VfifeError for more runs than can be told apart, and for another number of labels."""
    if len(runs) > len(RUNS):
        raise VfifeError(f"{len(runs)} runs: a figure shows {len(RUNS)} at most; name fewer")
    if labels and len(labels) != len(runs):
        raise VfifeError(f"labels: these are {len(labels)} for {len(runs)} runs; give one for each run")


def overlaid(runs: Sequence[RunData], names: Collection[str], labels: Sequence[str]) -> tuple[list[str], str]:
    """Return the names of the figures that are overlaid, and a sentence about the usual ones that are not.

    Raises VfifeError for a named figure that cannot be overlaid.
    """
    check_names(names)
    candidates = [name for name, kind in FIGURES.items() if kind.usual or ALL_FIGURES in names]
    if names and ALL_FIGURES not in names:
        candidates = list(dict.fromkeys(names))
    reasons = {name: _reason(name, runs, labels) for name in candidates}
    left_out = {name: reason for name, reason in reasons.items() if reason}
    chosen = [name for name, reason in reasons.items() if not reason]
    if not chosen or (left_out and names and ALL_FIGURES not in names):
        name, reason = next(iter(left_out.items()))
        raise VfifeError(f"the figure {shown(name)} is not overlaid: {reason}")
    single_only = [name for name, reason in left_out.items() if name not in OVERLAYS]
    not_overlaid = [f"{name} ({reason})" for name, reason in left_out.items() if name in OVERLAYS]
    first = [f"{', '.join(single_only)} (drawn of one run at a time)"] if single_only else []
    return chosen, f"Not overlaid: {', '.join(first + not_overlaid)}." if left_out else ""


def _reason(name: str, runs: Sequence[RunData], labels: Sequence[str]) -> str:
    """Return why a figure cannot be overlaid, or an empty text."""
    if name not in OVERLAYS:
        return f"name one of {', '.join(OVERLAYS)}"
    missing = zip(labels, (FIGURES[name].missing(run) for run in runs), strict=True)
    return next((f"{label.partition(':')[0]}: {reason}" for label, reason in missing if reason), "")


@rc_context(STYLE)
def overlay(
    name: str,
    runs: Sequence[RunData],
    labels: Sequence[str],
    panel_titles: Collection[str] = (),
    progress: str = "",
) -> Figure:
    """Return a figure of several runs with data for it, of all panels or some. ``progress``: how many of the
    planned runs these are, if not all. Raises VfifeError for runs over different abscissae.
    """
    kind = OVERLAYS[name]
    curves_of_runs = [kind.curves(run) for run in runs]
    counts = Counter(title for curves in curves_of_runs for title in curves)
    if len(runs) > 1 and max(counts.values()) < 2:
        raise VfifeError(f"the figure {shown(name)} is not overlaid: the runs have no panel of it in common")
    titles = [title for title in counts if title in panel_titles or not panel_titles][:MOST_PANELS]
    labelled = kind.shape == "turn"
    gaps: dict[str, float] = {} if labelled else {"across": 1.1, "down": 0.95}
    panels = Panels.alike(len(titles), kind.columns, kind.size, kind.alone, **gaps)
    for ax, title in zip(panels.axes, titles, strict=True):
        curves = {k: run_curves[title] for k, run_curves in enumerate(curves_of_runs) if title in run_curves}
        axes = {curves[k].across[0]: labels[k] for k in curves}
        if len(axes) > 1:
            abscissae = "; ".join(f"{label} over {words}" for words, label in axes.items())
            raise VfifeError(f"the figure {shown(name)} is not overlaid: its abscissae differ: {abscissae}")
        _draw(ax, curves, kind.shape, labels)
        ax.set_title(title)
    if labelled:
        panels.label_lowest(panels.axes[0].get_xlabel(), hide=True)
    lines = {label: Line2D([], [], lw=1.6, **look_of(k)) for k, label in enumerate(labels)}
    panels.entries = lines | legend_entries(panels.axes)
    names = " and ".join(dict.fromkeys(run.name for run in runs))
    turns = {shown_turn(run, shown_span(run)) for run in runs} if kind.shape not in OF_RUN else {""}
    turn = turns.pop() if len(turns) == 1 else ""
    if any(ax.get_title(loc="right").startswith(MEAN) for ax in panels.axes):
        turn += ", means of peaks"
    elif any(OF_MEAN in ax.get_title(loc="right") for ax in panels.axes):
        turn += f", {OF_MEAN.strip()} mean of peaks"
    return panels.close(f"{names}: {kind.title}{turn}, {progress or f'{len(runs)} runs'}")


def look_of(k: int) -> dict[str, Any]:
    """Return colour and dashes of a run; those of the first six differ in grey print too."""
    return RUNS[k] if k < len(RUNS) else curve_look(k)


def _draw(ax: Axes, curves: dict[int, Curve], shape: str, labels: Sequence[str]) -> None:
    """Draw the curves of a panel by the numbers of their runs."""
    first = next(iter(curves.values()))
    alike = first.across[1] == first.up[1]
    sizes = [
        max(map(_size, axis)) for axis in zip(*((curve.x, curve.y) for curve in curves.values()), strict=True)
    ]
    scales = [
        (1.0, "") if not unit else scale_of(max(sizes) if alike else size, unit)
        for size, (_, unit) in zip(sizes, (first.across, first.up), strict=True)
    ]
    (across, _), (up, unit) = scales
    _ideals(ax, curves, up, labels)
    for k, curve in curves.items():
        ax.plot(across * curve.x, up * curve.y, lw=1.1, zorder=3.0 - 0.1 * k, **look_of(k))
        if curve.border is not None:
            ax.plot(*(np.array([across, up]) * curve.border).T, lw=0.8, zorder=2.0, **look_of(k))
    labels_of = [
        f"{words} ({name})" if name else words
        for (words, _), (_, name) in zip((first.across, first.up), scales, strict=True)
    ]
    ax.set(xlabel=labels_of[0], ylabel=labels_of[1])
    peaks = [peak_digits(curve.peak, up) for curve in curves.values() if curve.peak is not None]
    if len(peaks) == len(curves):
        times = "" if first.up[1] in PREFIXED or up == 1.0 else "× "
        means = [curve.span is not None and curve.span.turns is not None for curve in curves.values()]
        # Square panels are too narrow for more words
        word = "peak" if not all(means) else MEAN if shape == "square" else "mean peak"
        if any(means) and not all(means):
            mark = OF_MEAN if shape == "square" else " (mean)"
            peaks = [f"{peak}{mark}" if mean else peak for peak, mean in zip(peaks, means, strict=True)]
        corner_text(ax, f"{word} {' / '.join(peaks)} {times}{unit}")
    _limits(ax, curves, shape, across, up)


def _limits(ax: Axes, curves: dict[int, Curve], shape: str, across: float, up: float) -> None:
    if shape == "square":
        values = [axis for curve in curves.values() for axis in (curve.x, curve.y, curve.border)]
        square(ax, 1.08 * across * max(_size(axis) for axis in values if axis is not None))
    elif shape == "whole":
        ax.margins(x=0.0)
    elif shape == "equal":
        ax.set_aspect("equal", adjustable="datalim")
    elif shape == "amplitude":
        widest = max(curves.values(), key=lambda curve: _size(curve.y))
        logarithmic_axis(ax, widest.x, up * widest.y)
    elif shape == "turn":
        spans = [curve.span for curve in curves.values() if curve.span is not None]
        max(spans, key=lambda span: span.limits[1] - span.limits[0]).set_limits(ax)


def _ideals(ax: Axes, curves: dict[int, Curve], up: float, labels: Sequence[str]) -> None:
    """Draw the ideal curves of the runs, those that are the same once."""
    distinct: dict[int, tuple[Array, Array]] = {}
    for k, curve in curves.items():
        if curve.ideal is not None and not any(_same(curve.ideal, ideal) for ideal in distinct.values()):
            distinct[k] = curve.ideal
    for k, (x, y) in distinct.items():
        look = {"color": GREY} if len(distinct) == 1 else {"color": look_of(k)["color"], "lw": 0.8}
        label = "ideal joints" if len(distinct) == 1 else f"ideal joints, {labels[k].partition(':')[0]}"
        ax.plot(x, up * y, zorder=2.5, **(IDEAL | {"lw": 1.0, "ls": (0, (2, 1.4)), "label": label} | look))


def _same(first: tuple[Array, Array], second: tuple[Array, Array]) -> bool:
    x = second[0]
    finite, of = np.isfinite(first[0] + first[1]), np.isfinite(x + second[1])
    if not finite.any() or not of.any():
        return True
    order = np.argsort(first[0][finite], kind="stable")
    at = np.interp(x[of], first[0][finite][order], first[1][finite][order])
    return bool(np.quantile(np.abs(at - second[1][of]), 0.99) <= ALIKE * _size(second[1]))


def _size(values: Array) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))
