"""Figures of single laws: loops of free impacts with the restitution they deliver; friction over sliding
velocity.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from ..measures.impact import FreeImpact
from .style import (
    BLUE,
    BODIES,
    GREY,
    STYLE,
    VERMILION,
    Array,
    heading,
    length_unit,
    panels,
    power_of_ten,
    saved,
    scale_of,
)


@rc_context(STYLE)
def contact_figure(title: str, loops: dict[str, FreeImpact], delivered: tuple[Array, Array] | None) -> Figure:
    """Return a figure of the force against penetration of free impacts, by label, and restitution delivered
    against restitution asked for, if the law has any.
    """
    figure, axes = panels(2 if delivered is not None else 1, 2, 4.9, 4.3)
    length, unit = length_unit(max(impact.deepest for impact in loops.values()))
    factor, force = scale_of(max(impact.largest for impact in loops.values()), "N")
    for k, (label, impact) in enumerate(loops.items()):
        axes[0].plot(
            length * impact.penetration, factor * impact.force, color=BODIES[k % len(BODIES)], label=label
        )
    axes[0].set(xlabel=f"penetration ({unit})", ylabel=f"force ({force})", title="loading and unloading")
    axes[0].set_xlim(left=0.0)
    axes[0].set_ylim(bottom=0.0)
    if delivered is not None:
        figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, columnspacing=1.4,
            handlelength=1.4, title="loops: restitution asked for → delivered",
        )  # fmt: skip
        axes[1].plot([0.0, 1.0], [0.0, 1.0], color=GREY, lw=0.9, ls=(0, (4, 3)), label="as asked for")
        axes[1].plot(*delivered, color=BLUE, label="delivered")
        axes[1].set(xlabel="restitution asked for", ylabel="restitution delivered", title="restitution")
        axes[1].set(xlim=(0.0, 1.0), ylim=(0.0, 1.02))
        axes[1].set_aspect("equal", adjustable="box")
        axes[1].legend(loc="upper left")
    heading(figure, title)
    return figure


@rc_context(STYLE)
def friction_figure(
    title: str, speeds: Array, forces: Array, loops: dict[str, tuple[Array, Array]], normal: float
) -> Figure:
    """Return a figure of the force against the motion over the normal force, against sliding velocity,
    steady; loops of small sliding for a law with memory.
    """
    figure, axes = panels(2 if loops else 1, 2, 4.9, 4.1 if loops else 3.6)
    axes[0].plot(speeds, -forces / normal, color=BLUE)
    small = float(np.abs(speeds[np.abs(speeds) > 0.0]).min())
    axes[0].set_xscale("symlog", linthresh=small)
    powers = range(round(np.log10(small)), 1, 2)
    signs = ((-1, "\N{MINUS SIGN}"), (1, ""))
    axes[0].set_xticks(
        [sign * 10.0**power for sign, _ in signs for power in powers] + [0.0],
        [text + power_of_ten(power) for _, text in signs for power in powers] + ["0"],
    )
    axes[0].minorticks_off()
    axes[0].set(
        xlabel="sliding velocity (m/s)", ylabel="resisting force / normal force", title="steady sliding"
    )
    if loops:
        length, unit = length_unit(max(float(np.abs(place).max()) for place, _ in loops.values()))
        for colour, (label, (place, force)) in zip(
            (VERMILION, BLUE, BODIES[2]), reversed(loops.items()), strict=False
        ):
            axes[1].plot(length * place, -force / normal, color=colour, lw=1.2, label=label)
        axes[1].set(
            xlabel=f"displacement ({unit})", ylabel="resisting force / normal force", title="before it slides"
        )
        figure.legend(
            *axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=3,
            title="strokes, of the displacement at which it breaks away",
        )  # fmt: skip
    heading(figure, title)
    return figure


def save_law(kind: str, target: Path, **numbers: Any) -> Path:
    """Draw a contact or friction law into a file; its ending chooses PNG, PDF or SVG."""
    return saved((contact_figure if kind == "contact" else friction_figure)(**numbers), target)
