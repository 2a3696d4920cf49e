"""Where energy is and where it goes, over the whole run: the ledger drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .layout import Panels
from .style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILION, readable, scale_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..results.view import View

STORED: dict[str, tuple[str, dict[str, Any]]] = {
    "kinetic": ("kinetic", {"color": BLUE}),
    "strain": ("strain of elastic links", {"color": GREEN}),
    "spring": ("springs", {"color": PURPLE}),
    "contact": ("contacts", {"color": SKY}),
}
FLOWN: dict[str, tuple[str, dict[str, Any]]] = {
    "driver": ("work of drivers", {"color": INK, "ls": (0, (5, 1.6))}),
    "external": ("work of weight and loads", {"color": GREY, "ls": (0, (5, 1.6))}),
    "contact_loss": ("lost in impacts", {"color": VERMILION}),
    "friction_loss": ("lost in friction", {"color": ORANGE}),
    "damping_loss": ("lost in damping", {"color": INK, "ls": (0, (1, 1.2))}),
    "spring_loss": ("lost in dampers", {"color": GREY, "ls": (0, (1, 1.2))}),
}
PRESENT = 1e-9  # of the largest term, below which one is nothing


def energy(result: View) -> Figure:
    """What is stored, what was supplied and lost since the start, and what the ledger leaves open, over time."""
    ledger, time = result.ledger, 1e3 * result.time
    panels = Panels([(4.6, 2.3), (4.6, 2.3), (4.6, 1.5)], 1)
    most = max(float(np.abs(values).max()) for values in ledger.terms.values())
    for ax, terms, what in ((panels.axes[0], STORED, "stored"), (panels.axes[1], FLOWN, "since the start")):
        kept = {
            name: ledger.terms[name] for name in terms if np.abs(ledger.terms[name]).max() > PRESENT * most
        }
        factor, unit = scale_of(
            max((float(np.abs(values).max()) for values in kept.values()), default=0.0), "J"
        )
        for name, values in kept.items():
            label, look = terms[name]
            ax.plot(time, factor * values, label=label, **({"lw": 1.2} | look))
        ax.set(ylabel=f"{what} ({unit})", title="stored energy" if terms is STORED else "supplied and lost")
    _residual(panels.axes[2], time, ledger.residual)
    for k, ax in enumerate(panels.axes):
        ax.set_xlim(time[0], time[-1] if time[-1] > time[0] else time[0] + 1.0)
        if k in panels.lowest:
            ax.set_xlabel("time (ms)")
        else:
            ax.tick_params(labelbottom=False)
    return panels.close(f"{result.name}: energy")


def _residual(ax: Axes, time: Any, residual: Any) -> None:
    factor, unit = readable(residual, "J")
    ax.plot(time, factor * residual, color=BLUE, lw=1.0)
    ax.set(ylabel=f"residual ({unit})", title="what the ledger leaves open")
