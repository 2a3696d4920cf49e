"""Figures of comparisons of laws, of fits, and of sensitivities as tornado charts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context

from ..measures.values import NOT_ESTIMATED
from ..report.amounts import decimals, fixed_point
from .overlay import overlay
from .style import (
    BLUE,
    BODIES,
    CENTRE,
    FAINT,
    GREY,
    INK,
    STYLE,
    VERMILION,
    heading,
    panels,
    readable,
    saved,
    scale_of,
)
from .turn import CRANK_ANGLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.derivatives import Sensitivity
    from ..results.fit import Fit, FitCurve
    from ..studies.methods.compare import Comparison


def labels(comparison: Comparison) -> list[str]:
    """Names of the runs: only the kind of law that differs."""
    kinds = [kind for kind in ("contact", "friction") if len({row[kind] for row in comparison.rows}) > 1] or [
        "contact"
    ]
    return [" + ".join(row[kind] for kind in kinds) for row in comparison.rows]


def forces(comparison: Comparison) -> Figure:
    """Return a figure of the size of each joint's force over the last turn, a line a run; the largest force
    in each output interval, so that no peak is missed.
    """
    titles = [f"joint {name}" for name in comparison.joints]
    return overlay("forces", comparison.results, labels(comparison), titles, comparison.progress)


@rc_context(STYLE)
def bars(comparison: Comparison) -> Figure:
    """Return a figure of the largest force, deepest penetration, impacts and energy lost, a bar a run;
    a line is the range of a number whose error was estimated.
    """
    rows = comparison.rows
    factor, unit = scale_of(max(row["force"] for row in rows), "N")
    measures = (
        (f"largest force ({unit})", "force", factor),
        ("deepest penetration (µm)", "penetration", 1e6),
        ("impacts", "impacts", 1.0),
        ("energy lost (J)", "energy_lost", 1.0),
    )
    count, estimated = len(rows), any(key.endswith(".low") for row in rows for key in row)
    figure, axes = panels(4, 4, 2.9, 1.5 + 0.32 * count, sharey=True)
    places = np.arange(count)
    for ax, (title, key, scale) in zip(axes, measures, strict=True):
        values = [scale * row[key] for row in rows]
        ax.barh(places, values, color=[BODIES[k % len(BODIES)] for k in range(count)], height=0.66)
        ax.set_title(title, fontsize=10)
        ax.grid(axis="y", visible=False)
        reach = max(values)
        for place, value, row in zip(places, values, rows, strict=True):
            look: Any = {"textcoords": "offset points", "va": "center", "fontsize": 8, "color": INK}
            low, high = (scale * row.get(f"{key}.{end}", row[key]) for end in ("low", "high"))
            if high > low:
                ax.hlines(place, low, high, color=INK, lw=1.0)
            width = high - low if key != "impacts" else 0.0
            text = fixed_point(value, decimals(value, width)) if width > 0.0 else f"{value:,.4g}"
            ax.annotate(text, (max(value, high), place), (3, 0), **look)
            reach = max(reach, high)
        ax.set_xlim(0.0, 1.3 * max(reach, 1e-30))
        ax.locator_params(axis="x", nbins=4)
        ax.tick_params(axis="x", labelcolor=GREY, labelsize=8)
    axes[0].set_yticks(places, labels(comparison))
    axes[0].invert_yaxis()
    note = "lines: ranges by runs with other step sizes" if estimated else f"errors {NOT_ESTIMATED}"
    heading(figure, f"{comparison.mechanism} ({note})", comparison.progress)
    return figure


def comparison_figures(comparison: Comparison) -> dict[str, Figure]:
    """Return the figures ``forces``, of the joint forces over a turn, and ``bars``, of the largest values;
    none where no run is complete.
    """
    return {"forces": forces(comparison), "bars": bars(comparison)} if comparison.rows else {}


def save_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write the figures into a folder."""
    return [saved(figure, folder / f"{name}.png") for name, figure in comparison_figures(comparison).items()]


CURVES = 4  # in one figure, at the most
SAMPLES = 4000  # drawn of each
ABSCISSAE = {
    "time": (1e3, "time (ms)"), "angle": (180.0 / math.pi, CRANK_ANGLE),
    "penetration": (1e6, "penetration (µm)"),
    "frequency": (1.0, "frequency (Hz)"), "order": (1.0, "order"),
}  # fmt: skip


@rc_context(STYLE)
def fit_figure(fit: Fit) -> Figure:
    """Return a figure with a row for each curve with its residual, of many those that are missed most; on the
    right parameters between their bounds with their confidence, and correlations.
    """
    curves = fit.curves
    if len(curves) > CURVES:
        curves = sorted(curves, key=lambda curve: -curve.share)[:CURVES]
    figure, axes = panels(3 * len(curves), 3, 4.0, 2.7, width_ratios=(1.6, 1.2, 1.2))
    for k, curve in enumerate(curves):
        fitted_curve(axes[3 * k], curve, k == 0)
        residual(axes[3 * k + 1], curve)
    ranges(axes[2], fit)
    shown = len(curves) > 1 and len(fit.values) > 1 and bool(np.isfinite(fit.correlation).all())
    if shown:
        correlations(axes[5], fit)
    for k in range(1 + shown, len(curves)):
        axes[3 * k + 2].set_visible(False)
    residual_words = f"residual {100.0 * fit.share:.3g} %"
    heading(figure, f"{fit.mechanism} fitted to {fit.data}: {residual_words}", fit.progress)
    return figure


def abscissa_of(curve: FitCurve) -> tuple[Any, str]:
    """Return the abscissa of a curve, and its label."""
    factor, label = ABSCISSAE[curve.over]
    return factor * curve.places, label


def fitted_curve(ax: Axes, curve: FitCurve, first: bool) -> None:
    """Draw measured and model's values."""
    stride = max(1, len(curve.places) // SAMPLES)
    x, label = abscissa_of(curve)
    factor, unit = readable(curve.measured, curve.unit)
    ax.plot(x[::stride], factor * curve.measured[::stride], ".", color=GREY, ms=2.5, label="measured")
    ax.plot(x[::stride], factor * curve.model[::stride], color=BLUE, lw=1.1, label="model")
    ax.set(
        title=f"{curve.record}: {curve.channel}" if curve.record else curve.channel,
        xlabel=label,
        ylabel=unit if curve.unit != "1" else "",
    )
    if first:
        # Curves fill the axes
        ax.figure.legend(*ax.get_legend_handles_labels(), loc="outside lower left", ncols=2, markerscale=3.0)


def residual(ax: Axes, curve: FitCurve) -> None:
    """Draw the residual in per cent of the measured standard deviation."""
    spread = float(curve.measured.std()) or 1.0
    x, label = abscissa_of(curve)
    ax.plot(x, 100.0 * (curve.measured - curve.model) / spread, color=VERMILION, lw=0.7)
    ax.axhline(0.0, color=GREY, lw=0.8)
    ax.set(title=f"left: {100.0 * curve.share:.3g} %", xlabel=label, ylabel="% of the deviation")


def ranges(ax: Axes, fit: Fit) -> None:
    """Draw the position of each parameter between its bounds, with its confidence; open markers without
    limits for those whose confidence is not known.
    """
    for k, value in enumerate(fit.values):
        at, limits = value.share(value.value), (value.low, value.high) if value.known else ()
        ends = [value.share(end) for end in limits]
        colour = INK if value.determined else VERMILION
        if ends and all(map(math.isfinite, ends)):
            ax.plot(np.clip(ends, 0.0, 1.0), [k, k], color=colour, lw=3.0, solid_capstyle="butt")
        ax.plot([at], [k], "o", color=colour, ms=5.0, mfc=colour if value.known else "none")
        if not value.known:
            ax.text(0.5, k - 0.12, "not known", color=colour, fontsize=8, ha="center", va="bottom")
    ax.set_yticks(range(len(fit.values)), [short_name(value.name) for value in fit.values], fontsize=8)
    ax.set(
        xlim=(0.0, 1.0),
        ylim=(len(fit.values) - 0.5, -0.5),
        xlabel="from bound to bound",
        title=f"{100.0 * fit.confidence:g} % confidence",
    )


def correlations(ax: Axes, fit: Fit) -> None:
    """Draw the correlation of each pair of parameters."""
    ax.imshow(fit.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    names = [short_name(value.name) for value in fit.values]
    ax.set_xticks(range(len(names)), names, rotation=30, ha="right", fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    for row, line in enumerate(fit.correlation):
        for column, value in enumerate(line):
            colour = INK if abs(value) < 0.6 else FAINT
            ax.text(column, row, f"{value:.2f}", fontsize=8, color=colour, **CENTRE)
    ax.grid(visible=False)
    ax.set_title("correlation")


def short_name(name: str) -> str:
    """Return the last parts of a path."""
    first = name.split(",")[0]
    return first.split(".", 1)[1] if first.count(".") > 1 else first


BARS = 10  # of a measure, at the most
MARKS = {"derivative": "", "change": " *", "unknown": " ?"}
PANELS = 6  # measures in one figure, at the most


@rc_context(STYLE)
def tornado(sensitivity: Sensitivity) -> Figure:
    """Change of measures in per cent for one per cent of each parameter: hatched bars to the left where they
    fall, thin lines are ranges.

    A bar is an elasticity; with a star it is the change for 1 %, which the derivative does not describe. A
    parameter with an unknown effect has a question mark and no bar, a measure on which the companion runs
    disagree the question mark alone. Measures that are zero are left out.
    """
    names = [
        name
        for name in sensitivity.measures
        if name in sensitivity.doubtful
        or any(np.isfinite(e) and e for e in sensitivity.elasticities(name).values())
    ][:PANELS]
    figure, axes = panels(max(1, len(names)), 2, 5.4, 0.9 + 0.24 * BARS)
    for ax, name in zip(axes, names, strict=False):
        ax.set_title(name)
        if name in sensitivity.doubtful:
            text = "?\nnot known: depends\non the time step"
            ax.text(0.5, 0.5, text, transform=ax.transAxes, color=GREY, **CENTRE)
            ax.set(xticks=[], yticks=[])
            continue
        effects = [effect for effect in sensitivity.effects(name) if np.isfinite(effect.value)][:BARS]
        places = np.arange(len(effects))
        values = [0.0 if effect.kind == "unknown" else effect.value for effect in effects]
        bars = ax.barh(
            places, values, height=0.66, color=[BLUE if value > 0.0 else VERMILION for value in values]
        )
        for bar, value in zip(bars, values, strict=True):
            bar.set_hatch("" if value > 0.0 else "////")
            bar.set_edgecolor("white")
        for place, effect in zip(places, effects, strict=True):
            if effect.kind != "unknown":
                ax.hlines(place, effect.low, effect.high, color=INK, lw=1.0)
        ax.axvline(0.0, color=GREY, lw=0.8)
        ax.set_yticks(places, [f"{effect.path}{MARKS[effect.kind]}" for effect in effects], fontsize=8)
        ax.invert_yaxis()
        ax.grid(axis="y", visible=False)
        starred = any(effect.kind == "change" for effect in effects)
        note = " (*: computed with this change)" if starred else ""
        ax.set_xlabel(f"change (%) for 1 % more{note}")
    for ax in axes[len(names) :]:
        ax.set_visible(False)
    heading(figure, f"{sensitivity.mechanism}: what its measures depend on", sensitivity.progress)
    return figure
