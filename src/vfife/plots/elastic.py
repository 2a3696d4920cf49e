"""Stress and deflection along elastic links and members of frames."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..measures import elastic
from ..model.lumping import mesh
from ..results.run_data import RunData
from .layout import Panels
from .style import BLUE, GREY, SKY, Array, corner_text, digits, length_unit, mark_peak, scale_of
from .turn import Span, shown_span, shown_turn

MOST_PANELS = 8
PANEL, ALONE = (4.6, 2.3), (7.0, 3.0)  # inches
FAINT = 12  # shapes over a turn


def bodies_with_stress(result: RunData) -> list[str]:
    """Return the elastic bodies with known stress: an element has a section with an extreme fibre."""
    record = result.record
    if not record.keeps("frame_axial_force") or not any(
        body.elements for body in record.assembly.bodies.values()
    ):
        return []
    tension, _ = elastic.fibres(record)
    return [
        name
        for name, body in record.assembly.bodies.items()
        if body.elements and not np.isnan(tension[:, list(body.elements)]).all()
    ]


def links_with_deflection(result: RunData) -> list[str]:
    """Return the elastic links; a frame has no chord from which it could deflect."""
    return elastic.elastic_links(result.record) if result.record.keeps("frame_moment_1") else []


def places(result: RunData, name: str) -> Array:
    """Return the end of each element along its body (m), members of a frame in sequence, shape
    (elements, 2).
    """
    ends = np.concatenate([[0.0], np.cumsum(mesh(result.record.assembly.mechanism.bodies[name]).length)])
    return np.stack([ends[:-1], ends[1:]], axis=1)


def nodes_and_middles(result: RunData, name: str) -> Array:
    """Return the places along a link (m) at which its deflection is known, shape (2 elements + 1,)."""
    ends = places(result, name)
    return np.append(np.stack([ends[:, 0], ends.mean(axis=1)], axis=1), ends[-1, 1])


def stress(result: RunData) -> Figure:
    """Return a figure of the largest and smallest stress in the outermost fibres along each elastic body, and
    along it at the moment of the largest.
    """
    names, span = bodies_with_stress(result)[:MOST_PANELS], shown_span(result)
    panels = Panels.alike(len(names), 2, PANEL, ALONE, down=0.95)
    tension, compression = (fibre[span.outputs] for fibre in elastic.fibres(result.record))
    for ax, name in zip(panels.axes, names, strict=True):
        elements, at = list(result.record.assembly.bodies[name].elements), places(result, name)
        tensile, compressive = (
            fibre[:, elements].reshape(len(fibre), -1) for fibre in (tension, compression)
        )
        size = np.nan_to_num(np.maximum(np.abs(tensile), np.abs(compressive)))
        k, largest = int(size.max(axis=1).argmax()), float(size.max())
        (factor, unit), (long, of) = scale_of(largest, "Pa"), length_unit(float(at.max()))
        x = long * at.ravel()
        low, high = factor * compressive.min(axis=0), factor * tensile.max(axis=0)
        ax.fill_between(x, low, high, color=SKY, alpha=0.55, lw=0.7, label="over the part shown")
        ax.plot(x, factor * tensile[k], color=BLUE, lw=1.2, label="when it is largest, both fibres")
        ax.plot(x, factor * compressive[k], color=BLUE, lw=1.2)
        ax.axhline(0.0, color=GREY, lw=0.7)
        _largest(ax, x, factor * tensile[k], factor * compressive[k], unit)
        ax.set(title=name, xlabel=f"along {name} ({of})", ylabel=f"stress ({unit})", xlim=(0.0, x[-1]))
    return panels.close(f"{result.name}: stress along elastic bodies{shown_turn(result, span)}")


def _largest(ax: Axes, x: Array, upper: Array, lower: Array, unit: str) -> None:
    """Mark the largest size, and write its value."""
    values = np.where(np.abs(np.nan_to_num(upper)) >= np.abs(np.nan_to_num(lower)), upper, lower)
    at = int(np.nanargmax(np.abs(values)))
    mark_peak(ax, x[at], values[at], values[at] > 0.0, "largest")
    corner_text(ax, f"{digits(values[at])} {unit}")


def deflection(result: RunData) -> Figure:
    """Return a figure of the deflection of each elastic link from the line through its ends: its range, and
    its shape when it is largest.
    """
    names, span = links_with_deflection(result)[:MOST_PANELS], shown_span(result)
    panels = Panels.alike(len(names), 2, PANEL, ALONE, down=0.95)
    for ax, name in zip(panels.axes, names, strict=True):
        _shape(ax, result, name, span)
    return panels.close(f"{result.name}: deflection of elastic links{shown_turn(result, span)}")


def _shape(ax: Axes, result: RunData, name: str, span: Span) -> None:
    deflections = elastic.chord_deflection(result.record, name)[span.outputs]
    places = nodes_and_middles(result, name)
    factor, unit = length_unit(float(np.abs(deflections).max()))
    x_factor, x_unit = length_unit(float(places[-1]))
    x, y = x_factor * places, factor * deflections
    largest = y[int(np.abs(deflections).max(axis=1).argmax())]
    low, high = y.min(axis=0), y.max(axis=0)
    ax.fill_between(x, low, high, color=SKY, alpha=0.45, lw=0.7, label="over the part shown")
    for j in np.linspace(0, len(y) - 1, min(FAINT, len(y))).astype(int):
        label = "from time to time" if j == 0 else None
        ax.plot(x, y[j], color=GREY, lw=0.5, alpha=0.6, label=label)
    ax.plot(x, largest, color=BLUE, lw=1.4, label="when it is largest")
    _largest(ax, x, largest, largest, unit)
    ax.set(title=name, xlabel=f"along {name} ({x_unit})", ylabel=f"deflection ({unit})", xlim=(0.0, x[-1]))
