"""Panels and axes of figures of a study: parameters, measures and what is said about them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from ..measures.catalogue import CASE, COUNTED, IMPACT_SPEED, NO_IMPACT, counted_from_start
from ..numerics.outward import UP, significant
from ..results.case_errors import NOT_ESTIMATED
from ..results.parameters import Varied
from ..results.study import Study
from .style import RPM, Array, digits, panels, readable

MOST_TICKS, MOST_PANELS = 7, 6  # of a logarithmic axis; of a figure


def broken_name(name: str, width: int = 15) -> str:
    """Return a long name in lines, broken at its dots and underscores."""
    lines = [""]
    for part in re.split(r"(?<=[._ ])", name):
        if lines[-1] and len(lines[-1]) + len(part) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


def name_with_unit(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return f"{name} ({unit})" if unit else name


def unit_of_axis(study: Study, parameter: Varied, unit: str) -> str:
    """Return the unit of an axis, with "radial" for clearances of pins: shops count those in the diameter."""
    joints = tomllib.loads(study.request.get("text", "")).get("joint", {})
    paths = [path.split(".") for path in parameter.paths]
    radial = all(
        len(parts) == 3 and parts[2] == "clearance" and "bearing_radius" in joints.get(parts[1], {})
        for parts in paths
    )
    return f"{unit}, radial" if radial and unit else unit


def positions(values: Sequence[Any], parameter: Varied) -> tuple[Array, str]:
    """Return the positions of values of a parameter along an axis, and their unit: that in which the study
    file gives them, else a readable one; words one after another.
    """
    if any(isinstance(value, str) for value in values):
        return np.arange(len(values), dtype=float), ""
    factor, unit = readable_parameter(values, parameter)
    return factor * np.asarray(values, dtype=float), unit


def readable_parameter(values: Any, parameter: Varied) -> tuple[float, str]:
    """Return factor and unit for the values of a parameter."""
    if parameter.written:
        return 1.0 / parameter.written_factor, parameter.written
    return (RPM, "rpm") if parameter.unit == "rad/s" else readable(values, parameter.unit)


def edges(middles: Array) -> Array:
    """Return the edges of cells around their middles; the outer ones as far away as the inner ones."""
    if len(middles) == 1:
        half = 0.5 * (abs(middles[0]) or 1.0)
        return np.array([middles[0] - half, middles[0] + half])
    inner = 0.5 * (middles[1:] + middles[:-1])
    return np.concatenate([[2.0 * middles[0] - inner[0]], inner, [2.0 * middles[-1] - inner[-1]]])


def is_logarithmic(middles: Array) -> bool:
    """Return whether values lie evenly on a logarithmic scale, and not on a plain one."""
    if len(middles) < 3 or middles.min() <= 0.0:
        return False
    ratios, steps = middles[1:] / middles[:-1], np.diff(middles)
    return bool(np.ptp(ratios) < 1e-3 * ratios.mean() and np.ptp(steps) > 1e-2 * steps.mean())


def label_axis(
    ax: Axes, parameter: Varied, values: Sequence[Any], middles: Array, unit: str, axis_name: str = "x"
) -> None:
    """Labels an axis of a parameter."""
    axis, label = (ax.xaxis, ax.set_xlabel) if axis_name == "x" else (ax.yaxis, ax.set_ylabel)
    label(name_with_unit(parameter.name, unit))
    if any(isinstance(value, str) for value in values):
        axis.set_ticks(list(middles), [str(value) for value in values])
    elif is_logarithmic(middles):
        (ax.set_xscale if axis_name == "x" else ax.set_yscale)("log")
        at = [middles[k] for k in even_indices(len(middles), MOST_TICKS)]
        axis.set_ticks(at, [f"{value:.3g}" for value in at])
        axis.set_minor_locator(NullLocator())


def axes_of(study: Study) -> list[Varied]:
    """Return the parameters that may be axes, those with most values first, words last."""
    parameters = [parameter for parameter in study.parameters if parameter.name in study.axes]
    return sorted(
        parameters,
        key=lambda parameter: (
            any(isinstance(value, str) for value in study.axes[parameter.name]),
            -len(study.axes[parameter.name]),
        ),
    )


def other_dimensions(study: Study, parameters: Sequence[Varied]) -> str:
    """Return the dimensions of a study except some parameters in words."""
    names = [name for name in study.axes if name not in {parameter.name for parameter in parameters}]
    return ", ".join(f"{len(study.axes[name]):,} samples" if name == "sample" else name for name in names)


def arranged(study: Study, values: Array, parameters: Sequence[Varied]) -> Array:
    """Return values along the axes of a study with an axis for each of the parameters, then one for all other
    dimensions.
    """
    dimensions = list(study.axes)
    axes = [dimensions.index(parameter.name) for parameter in parameters]
    values = np.moveaxis(values, axes, list(range(len(axes))))
    return values.reshape(*values.shape[: len(axes)], -1)


def measure_panels(study: Study, measures: list[str], height: float) -> tuple[Figure, dict[str, Axes]] | None:
    """Return a figure and its panels of a height (inches) by measure; None where no measure has values."""
    names = [name for name in measures if np.isfinite(study.laid_out(name)).any()][:MOST_PANELS]
    if not names:
        return None
    figure, axes = panels(len(names), 2 if len(names) < 5 else 3, 4.8, height)
    return figure, dict(zip(names, axes, strict=True))


def even_indices(count: int, limit: int) -> list[int]:
    """Return at most ``most`` of ``count`` indices, evenly."""
    return (
        sorted({round(k * (count - 1) / max(limit - 1, 1)) for k in range(limit)})
        if count > limit
        else list(range(count))
    )


EMPTY: dict[str, Any] = {"ls": "", "marker": "o", "ms": 6.0, "mfc": "white", "zorder": 4}
LEAST_SHARE = 0.05  # of the largest measure with the same unit: smaller ones have a unit of their own
RING = 3.0  # points by which the hollow marker of the next curve is larger
HOLLOW = f"; hollow: {NO_IMPACT}"
HOLLOW_SOME = "; hollow: cases without impact"  # among others at the same place


def ring(curve: int) -> dict[str, Any]:
    """Return the hollow marker of a curve by its number: those of several curves at one place lie within one
    another.
    """
    return EMPTY | {"ms": EMPTY["ms"] + RING * curve, "zorder": EMPTY["zorder"] - 0.1 * curve}


def no_impact(name: str, values: Array) -> NDArray[np.bool_]:
    """Return where values of a measure are largest impact speeds of cases without impacts."""
    return np.asarray((values == 0.0) & name.endswith(IMPACT_SPEED))


def hollow_words(quiet: NDArray[np.bool_]) -> str:
    """Return what hollow circles are: places whose cases, or some of whose cases, have no impact; "" without
    any.
    """
    if not quiet.any():
        return ""
    return HOLLOW if quiet.shape[-1] == 1 else HOLLOW_SOME


def with_impact(name: str, values: Array) -> Array:
    """Return values of a measure, NaN for those that are no impact: a median does not count them as 0."""
    return np.where(no_impact(name, values), np.nan, values)


def shared_scales(study: Study, names: Sequence[str]) -> dict[str, tuple[float, str]]:
    """Return factor and unit of each measure: one for those of the same kind that lie side by side, after the
    largest, unless a measure is less than LEAST_SHARE of it.
    """
    sizes = {name: float(np.nanmax(np.abs(study.values(name)))) for name in names}
    scales = {}
    for name in names:
        unit = study.measures[name]
        largest = max(sizes[key] for key in names if study.measures[key] == unit)
        size = largest if sizes[name] >= LEAST_SHARE * largest else sizes[name]
        scales[name] = readable([size], unit)
    return scales


def places_of_cases(study: Study, name: str, parameters: Sequence[Varied]) -> tuple[Array, Array]:
    """Return for the cases at each place over parameters, along their axes and one for all other dimensions,
    the values of a measure, and the errors that a figure shows; NaN where they are unknown.
    """
    values = arranged(study, study.laid_out(name), parameters)
    if name not in study.errors:
        return values, np.full(values.shape, np.nan)
    return values, arranged(study, study.error_bars(name), parameters)


def largest_error(name: str, values: Array, errors: Array) -> Array:
    """Return the largest error of the values along the last axis, which that of their median does not exceed;
    0 where none is known. Cases without impact count only where no other one is.
    """
    bars = np.where(np.isfinite(with_impact(name, values)), errors, np.nan)
    bars = np.where(np.isfinite(bars).any(axis=-1, keepdims=True), bars, errors)
    return np.asarray(np.max(bars, axis=-1, initial=0.0, where=np.isfinite(bars)))


def error_line(study: Study, name: str, factor: float, unit: str) -> str:
    """Return the numerical error of a measure, which is multiplied by a factor to have the unit."""
    if (error := study.errors.get(name)) is None:
        return f"numerical error {NOT_ESTIMATED}"
    size, word = (error.most, "up to") if error.sensitive else (error.typical, "typically")
    if size < error.floor:
        size, word = error.floor, "typically below"
    return f"numerical error {word} {digits(float(significant(factor * size, 3, UP)))} {unit}".rstrip()


def turns_of_measure(study: Study, name: str) -> str:
    """Return of which turns of a case a measure is."""
    plan = study.request["wanted"]
    if counted_from_start([name], plan.get("counts", CASE)) or plan.get("duration"):
        return "whole case"
    if name.endswith(COUNTED) and plan["last"] > 1:
        return f"last {plan['last']} turns"
    if plan["last"] > 1:
        return f"mean of the last {plan['last']} turns"
    periods = (outcome.get("measured_turns") or 1 for outcome in study.outcomes.values())
    return "last turn, or mean of the period" if max(periods, default=1) > 1 else "last turn"


def sensitive_words(study: Study) -> str:
    """Return how many sampled cases are sensitive to the step; empty if none is."""
    sensitive, count = study.sensitive
    return f"{sensitive} of {count} sampled cases are sensitive to the step" if sensitive else ""
