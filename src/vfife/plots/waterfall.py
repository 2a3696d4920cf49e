"""A waterfall: amplitudes of waves over a number that changes from run to run, by orders of the crank or frequencies, as colour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .layout import Panels
from .spectra import DECADES, power_of_ten
from .spectrograms import edges
from .style import FAINT, length_unit, scale_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..study.maps.waterfall import Waterfall

Array = NDArray[np.float64]
RPM = 30.0 / np.pi


def drawn(found: Waterfall, hertz: bool = False) -> Figure:
    """A panel for each series, orders to the right, or frequencies (``hertz``), the number upwards; what is not known, or diverged, stays grey."""
    asked = found.asked
    panels = Panels([(5.2, 3.4) if len(asked.series) > 1 else (8.0, 4.4)] * len(asked.series), 2, across=1.85)
    factor_y, unit_y = upwards(found)
    y = edges(factor_y * np.array(asked.values), len(asked.values))
    for ax, name, unit_of in zip(panels.axes, asked.series, asked.units, strict=True):
        every = found.amplitudes[name]
        most = float(np.nanmax(every, initial=0.0))
        factor, unit = scale_of(most, unit_of)
        top = float(np.log10(max(factor * most, 1e-300)))
        shown = np.ma.masked_invalid(np.log10(np.maximum(factor * every, 10.0 ** (top - DECADES))))
        ax.set_facecolor(FAINT)
        mesh = ax.pcolormesh(across(found, hertz), np.repeat(y[:, None], every.shape[1] + 1, axis=1), shown, cmap="cividis", rasterized=True)
        ax.grid(visible=False)
        ax.set(title=name, ylabel=f"{asked.path} ({unit_y})", xlabel="frequency (Hz)" if hertz else "order of the crank")
        ax.set_xlim(left=0.0)
        bar = panels.scale(ax, mesh, f"amplitude ({unit})")
        powers = range(int(np.ceil(top - DECADES)), int(np.floor(top)) + 1)
        bar.set_ticks(list(powers), labels=[power_of_ten(power) for power in powers])
    return panels.close(f"{found.name}: {found.words}; {found.limits}; no companions")


def upwards(found: Waterfall) -> tuple[float, str]:
    """Factor and unit of the number; speeds of cranks are told in rpm."""
    unit, most = found.asked.unit, float(np.abs(found.asked.values).max())
    if unit == "rad/s":
        return RPM, "rpm"
    return length_unit(most) if unit == "m" else scale_of(most, unit)


def across(found: Waterfall, hertz: bool) -> Array:
    """Edges of cells from left to right, shape (values + 1, places + 1); of frequencies those of the values, which fan out with the speed."""
    places = np.append(found.orders, 2.0 * found.orders[-1] - found.orders[-2]) - 0.5 * found.orders[1]
    rate = 1.0 / found.turn if hertz else np.ones(len(found.turn))
    rate = np.concatenate([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    return np.asarray(np.maximum(places, 0.0) * rate[:, None], dtype=float)
