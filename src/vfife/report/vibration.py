"""Natural vibrations of a mechanism, and the strongest waves of series of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .document import Document, Paragraph, Part, Table

if TYPE_CHECKING:
    from ..measures.modes import Modes
    from ..model.mechanism import Mechanism

NOTE = (
    "About the start, at rest, joints with play taken as ideal, external contacts as open, loads left out; no"
    " damping."
)
UNBALANCED = 1e-3  # of all forces
PEAKS = 8


def modes(mechanism: Mechanism, found: Modes) -> Document:
    """Natural frequencies about the start: of the whole mechanism, and of its elastic links by themselves."""
    data = {
        "model": mechanism.name,
        "note": NOTE,
        "coordinates": found.count,
        "unbalanced": found.unbalanced,
        "modes": [
            {
                "frequency": one.frequency,
                "angular_frequency_squared": one.square,
                "energy": one.energy,
                "shape": one.shape.tolist(),
            }
            for one in found.modes
        ],
        "links": {name: list(frequencies) for name, frequencies in found.links.items()},
    }
    count = f": {found.count or 'no'} natural vibration{'s' * (found.count != 1)}"
    parts: list[Part] = [Paragraph(count, lead=mechanism.name), Paragraph(NOTE)]
    if not found.count:
        parts.append(
            Paragraph(
                "Drivers and joints leave nothing that could vibrate: rigid links, and a drive that holds"
                " them. See --released."
            )
        )
        return Document(parts, data=data)
    crank, rows = _turns_per_second(mechanism), []
    for number, mode in enumerate(found.modes, start=1):
        name, share = mode.leading
        order = [f"{mode.frequency / crank:.4g}"] if crank else []
        rows.append(
            (
                number,
                _frequency(mode.frequency, mode.square),
                *order,
                f"{name}, {100.0 * share:.0f} % of the energy",
            )
        )
    heads = ("", "frequency", *(["turns of the crank"] if crank else []), "moves most")
    parts.append(Table(heads, rows, numbers=range(len(heads) - 1)))
    for name, frequencies in found.links.items():
        parts.append(
            Paragraph(
                f"{name} alone, pinned at both ends: {', '.join(f'{one:.5g}' for one in frequencies)} Hz"
            )
        )
    if found.unbalanced > UNBALANCED:
        unbalanced = (
            f"The start is no equilibrium: {100.0 * found.unbalanced:.2g} % of weight and springs set the"
            " mechanism in motion. These are the vibrations about it as if it stood still."
        )
        parts.append(Paragraph(unbalanced, style="caution"))
    return Document(parts, data=data)


def _turns_per_second(mechanism: Mechanism) -> float | None:
    """Speed of the first driver that turns at constant speed (1/s)."""
    speeds = (driver.steady_speed for driver in mechanism.drivers.values() if driver.moves)
    return next((abs(speed) / (2.0 * math.pi) for speed in speeds if speed), None)


def _frequency(value: float, square: float) -> str:
    """A frequency in words; an unstable mode by the time in which it grows e-fold."""
    if square < 0.0:
        return f"unstable, e-fold in {1.0 / math.sqrt(-square):.3g} s"
    return "0 Hz: moves freely" if square == 0.0 else f"{value:.5g} Hz"


def spectra(found: Sequence[Any], name: str) -> Document:
    """The strongest waves of each series; of a spectrogram with the time at which they are strongest, of an
    envelope those of its own spectrum.
    """
    first = found[0]
    timed = hasattr(first, "times") and not hasattr(first, "spectrum")
    turning = getattr(first, "spectrum", first).turn is not None
    heads = (
        "series",
        *(("order",) if turning else ()),
        "frequency, Hz",
        "amplitude",
        *(("at, ms",) if timed else ()),
    )
    rows = []
    for one in found:
        of = getattr(one, "spectrum", one)
        sizes = of.amplitudes.max(axis=0) if timed else of.amplitudes
        for n, k in enumerate(strongest(sizes, of.window)):
            time = (f"{1e3 * of.times[int(of.amplitudes[:, k].argmax())]:.4g}",) if timed else ()
            order = (f"{of.orders[k]:.4g}",) if turning else ()
            rows.append(
                (
                    of.name if n == 0 else "",
                    *order,
                    f"{of.frequencies[k]:.5g}",
                    f"{sizes[k]:.4g} {of.unit}",
                    *time,
                )
            )
    words = f"{first.words[0].upper()}{first.words[1:]}."
    return Document([Table.of(heads, rows), Paragraph(words)], title=f"{name}: the strongest waves")


def strongest(sizes: Any, window: str) -> list[int]:
    """Indices of the highest local maxima, without the mean and the neighbours over which the window spreads
    it.
    """
    from ..measures.spectral import COSINES

    inside = ((sizes[1:-1] >= sizes[:-2]) & (sizes[1:-1] > sizes[2:])).nonzero()[0] + 1
    return sorted((int(k) for k in inside if k >= len(COSINES[window])), key=lambda k: -sizes[k])[:PEAKS]
