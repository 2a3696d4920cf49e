"""Runs of one mechanism under several laws, over one another."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context

from .style import BODIES, GREY, INK, STYLE, heading, one_legend, panels, saved, scale_of
from .turn import abscissa, one_turn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.comparison import Comparison

LINES = ("-", (0, (5, 1.5)), (0, (1.5, 1)))


def labels(found: Comparison) -> list[str]:
    """Names of the runs: only the kind of law that differs."""
    kinds = [kind for kind in ("contact", "friction") if len({row[kind] for row in found.rows}) > 1] or ["contact"]
    return [" + ".join(row[kind] for kind in kinds) for row in found.rows]


@rc_context(STYLE)
def forces(found: Comparison) -> Figure:
    """Size of each joint's force over the last turn, a line a run; the largest force in each output interval, so that no peak is missed."""
    count = len(found.joints)
    figure, axes = panels(count, 2, 5.6 if count > 1 else 8.0, 3.2 if count > 2 else 4.0)
    for ax, name in zip(axes, found.joints, strict=True):
        factor, unit = scale_of(max(row["joints"][name]["force.max"] for row in found.rows), "N")
        for k, (result, label) in enumerate(zip(found.results, labels(found), strict=True)):
            first = max(int(np.argmax(result.last_turn)) - 1, 0)
            x, _ = one_turn(abscissa(result)[first:], result)
            joint = list(result.record.assembly.mechanism.joints).index(name)
            y = result.channels["joint_force_max"].values[first:, joint]
            ax.plot(x, factor * y, color=BODIES[k % len(BODIES)], ls=LINES[k // len(BODIES) % len(LINES)], lw=1.0, label=label)
        ax.set(title=f"joint {name}", ylabel=f"joint force\n({unit})")
        ax.set_xlabel("time (ms)" if found.results[0].crank is None else f"angle of {found.results[0].crank} (degrees)")
        ax.margins(x=0.0)
    one_legend(figure, axes)
    turn = "" if found.results[0].crank is None else ", last turn"
    heading(figure, f"{found.mechanism}: joint force{turn}")
    return figure


@rc_context(STYLE)
def bars(found: Comparison) -> Figure:
    """Largest force, deepest penetration, impacts and energy lost, a bar a run."""
    peak = max(row["force"] for row in found.rows)
    factor, unit = scale_of(peak, "N")
    what = (
        (f"largest force ({unit})", [factor * row["force"] for row in found.rows]),
        ("deepest penetration (µm)", [1e6 * row["penetration"] for row in found.rows]),
        ("impacts", [row["impacts"] for row in found.rows]),
        ("energy lost (J)", [row["energy_lost"] for row in found.rows]),
    )
    count = len(found.rows)
    figure, axes = panels(4, 4, 2.9, 1.5 + 0.32 * count, sharey=True)
    places = np.arange(count)
    for ax, (title, values) in zip(axes, what, strict=True):
        ax.barh(places, values, color=[BODIES[k % len(BODIES)] for k in range(count)], height=0.66)
        ax.set_title(title, fontsize=10)
        ax.grid(axis="y", visible=False)
        for place, value in zip(places, values, strict=True):
            ax.annotate(f"{value:,.4g}", (value, place), (3, 0), textcoords="offset points", va="center", fontsize=8, color=INK)
        ax.set_xlim(0.0, 1.3 * max(max(values), 1e-30))
        ax.locator_params(axis="x", nbins=4)
        ax.tick_params(axis="x", labelcolor=GREY, labelsize=8)
    axes[0].set_yticks(places, labels(found))
    axes[0].invert_yaxis()
    heading(figure, found.mechanism)
    return figure


def drawn(found: Comparison, folder: Path) -> list[Path]:
    """Writes both figures into a folder; nothing where no run is complete."""
    return [saved(draw(found), folder / f"{name}.png") for name, draw in (("forces", forces), ("bars", bars)) if found.rows]
