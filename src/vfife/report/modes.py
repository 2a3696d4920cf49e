"""Document of the natural frequencies of a mechanism, with their ranges by the mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..job.progress import counted
from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import exponent
from .amounts import fixed_point, interval
from .document import Document, Paragraph, Part, Table

if TYPE_CHECKING:
    from ..measures.modes import Mode, Modes
    from ..measures.values import Measured
    from ..model.mechanism import Mechanism

NOTE = (
    "About the start, at rest, with clearance joints as ideal and external contacts as open, without loads"
    " and damping."
)
UNKNOWN = (
    "Ranges come from the same vibrations with other numbers of elements. The error is not estimated"
    " for a vibration that has no counterpart there or changes by a factor of two, for links that are one"
    " element by definition, and for large meshes."
)
UNBALANCED = 1e-3  # of all forces


def modes(mechanism: Mechanism, result: Modes) -> Document:
    """Return a document of the natural frequencies about the start: of the whole mechanism, and of its
    elastic links alone.
    """
    data = {
        "model": mechanism.name,
        "note": NOTE,
        "coordinates": result.count,
        "unbalanced": result.unbalanced,
        "modes": [
            {
                "frequency": mode.frequency.value,
                "range": range_of(mode.frequency),
                "angular_frequency_squared": mode.square.value,
                "angular_frequency_squared_range": range_of(mode.square),
                "energy": mode.energy,
                "shape": mode.shape.tolist(),
            }
            for mode in result.modes
        ],
        "links": {name: [value.value for value in values] for name, values in result.links.items()},
        "link_ranges": {name: [range_of(value) for value in values] for name, values in result.links.items()},
        "missing": result.missing,
    }
    count = f": {result.count or 'no'} natural vibration{'s' * (result.count != 1)}"
    parts: list[Part] = [Paragraph(count, lead=mechanism.name), Paragraph(NOTE)]
    if not result.count:
        parts.append(
            Paragraph(
                "Nothing can vibrate: all links are rigid, and drivers and joints hold them. See --released."
            )
        )
        return Document(parts, data=data)
    parts += [_mode_table(mechanism, result), *_link_paragraphs(result), *_mesh_cautions(result)]
    if result.unbalanced > UNBALANCED:
        unbalanced = (
            f"The start is not an equilibrium: {100.0 * result.unbalanced:.2g} % of weight and spring forces"
            " are unbalanced. These are the vibrations about the start as if it were at rest."
        )
        parts.append(Paragraph(unbalanced, style="caution"))
    return Document(parts, data=data)


def range_of(value: Measured) -> dict[str, float] | None:
    """Return the range of a number for JSON; None if its error was not estimated."""
    return {"low": value.low, "high": value.high} if value.estimated else None


def _mode_table(mechanism: Mechanism, result: Modes) -> Table:
    """Return the table of the vibrations: frequency, range, turns of the crank, and the body that moves
    most.
    """
    crank, rows = _turns_per_second(mechanism), []
    for number, mode in enumerate(result.modes, start=1):
        name, share = mode.leading
        order = [_digits(mode.frequency, crank)] if crank else []
        cells = (number, _frequency(mode), _frequency_range(mode), *order)
        rows.append((*cells, f"{name}, {100.0 * share:.0f} % of the energy"))
    heads = ("", "frequency", "range", *(["turns of the crank"] if crank else []), "moves most")
    return Table(heads, rows, numbers=range(len(heads) - 1))


def _link_paragraphs(result: Modes) -> Iterator[Paragraph]:
    """Yield the frequencies of each elastic link alone, with their ranges."""
    for name, values in result.links.items():
        listed = ", ".join(f"{_digits(value)} Hz ({_interval(value)})" for value in values)
        yield Paragraph(f"{name} alone, pinned at both ends: {listed}")


def _mesh_cautions(result: Modes) -> Iterator[Paragraph]:
    """Yield sentences on vibrations that the elements cannot show, and on errors that are not estimated."""
    if result.missing:
        last = f"{result.modes[-1].frequency.value:,.4g} Hz"
        yield Paragraph(
            f"Twice the elements have {counted(result.missing, 'more vibration')} below {last}, which these"
            " elements cannot represent: use more elements.",
            style="caution",
        )
    if not all(mode.frequency.estimated for mode in result.modes):
        yield Paragraph(UNKNOWN)


def _digits(value: Measured, unit: float = 1.0) -> str:
    """Return a number over its ``unit`` with at most five digits, and none finer than the second of its
    range; with three where that is not estimated.
    """
    scaled, width = value.value / unit, 0.1 * value.width / unit
    if not value.estimated or not scaled:
        return fixed_point(scaled, 2 - exponent(scaled)) if scaled else "0"
    places = min(4 - exponent(scaled), max(-exponent(width), -exponent(scaled)) if width > 0.0 else 4)
    return fixed_point(scaled, places)


def _interval(value: Measured) -> str:
    """Return the range of a frequency without its unit, or that it is not estimated."""
    if not value.estimated:
        return NOT_ESTIMATED
    return interval(value.low, value.high, "Hz", max(0.1 * value.width, 1e-4 * value.value), prefix=False)[
        :-3
    ]


def _turns_per_second(mechanism: Mechanism) -> float | None:
    """Return the speed of the first driver with constant speed (1/s)."""
    speeds = (driver.steady_speed for driver in mechanism.drivers.values() if driver.moves)
    return next((abs(speed) / (2.0 * math.pi) for speed in speeds if speed), None)


def _frequency(mode: Mode) -> str:
    """Return a frequency in words; an unstable mode by the time in which it grows e-fold."""
    if mode.square < 0.0:
        return f"unstable, e-fold in {1.0 / math.sqrt(-mode.square):.3g} s"
    return "0 Hz: moves freely" if mode.square == 0.0 else f"{_digits(mode.frequency)} Hz"


def _frequency_range(mode: Mode) -> str:
    """Return the range of a frequency; "" of a motion that does not vibrate."""
    if mode.square > 0.0:
        return f"{_interval(mode.frequency)}{' Hz' * mode.frequency.estimated}"
    return "" if mode.square.estimated else NOT_ESTIMATED
