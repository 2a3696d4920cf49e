"""Integrate both problems twice and independently, and write the digits on which both agree.

The first integration is the Runge-Kutta method of order eight of Dormand and Prince, the second the
extrapolation of Gragg, Bulirsch and Stoer in other coordinates. Both have double precision, but the second of
the slider-crank, which has 64 bits of mantissa (numpy.longdouble). Both stop at each onset and parting of a
contact and at each corner of the friction law, so that each integrates smooth pieces alone.

``python certify.py four_bar`` writes four_bar/reference.csv and four_bar/largest.csv; without a name both
problems are done. It needs numpy and scipy, and some minutes.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from equations import (
    V0,
    V1,
    FourBarAtCentres,
    FourBarAtPins,
    Mode,
    SliderCrankAtCentres,
    SliderCrankInComplexNumbers,
    band_of,
)
from scipy.integrate import DOP853

ROWS = 800  # of a table
LONG = np.longdouble
Path_ = Callable[[Any], Any]  # state at a time within a step


def modes_at(model: Any, t: Any, y: Any, touches: list[bool], approaches: list[Any]) -> list[Mode]:
    """Return the modes of the contacts for a state."""
    gaps = model.gaps(t, y)
    return [
        (touch, speed, band_of(gap[2])) for touch, speed, gap in zip(touches, approaches, gaps, strict=True)
    ]


def crossed(model: Any, t: Any, y: Any, modes: list[Mode]) -> list[tuple[int, str, Any]]:
    """List the changes since ``modes``: contact, kind, and the distance beyond the border."""
    result = []
    for k, ((depth, _, slide), (touches, _, band)) in enumerate(zip(model.gaps(t, y), modes, strict=True)):
        if (depth > 0.0) != touches:
            result.append((k, "gap", depth))
        if touches and band_of(slide) != band:
            size, now = abs(band), band_of(slide)
            outer = abs(now) > size if now * band >= 0 else False
            border = (V0, V1)[min(size, 1)] if outer else (V0, V1)[max(size - 1, 0)]
            sign = math.copysign(1.0, band if band else float(slide))
            result.append((k, "slide", slide - sign * border))
    return result


def border(model: Any, path: Path_, low: Any, high: Any, modes: list[Mode], least: float) -> Any:
    """Bisect the first time in a step at which a border is crossed, down to rounding."""
    for _ in range(120):
        middle = low + (high - low) / 2
        if middle in (low, high) or high - low < least:
            break
        if crossed(model, middle, path(middle), modes):
            high = middle
        else:
            low = middle
    return high


def rates(model: Any, t: Any, y: Any, modes: list[Mode]) -> Any:
    """Rates as an array; plain numbers of Python are several times faster than those of numpy."""
    return np.array(model.rates(t, y.tolist() if y.dtype == float else y, modes))


def dormand_prince(
    model: Any, t: float, y: Any, end: float, modes: list[Mode]
) -> Iterator[tuple[Any, Any, Path_]]:
    """Yield steps of order eight, each with its dense output."""
    solver = DOP853(
        lambda t, y: rates(model, t, y, modes), t, np.array(y), end, rtol=2.3e-14, atol=1e-16,
        first_step=min(1e-8, end - t),
    )  # fmt: skip
    while solver.status == "running":
        begin = solver.t
        solver.step()
        if solver.t == begin:
            raise RuntimeError(f"the step at {begin} s is too small")
        dense = solver.dense_output()
        yield solver.t, solver.y.copy(), dense


SEQUENCE = (2, 4, 6, 8, 10, 12)
# Error of a step over the size of the state (1), well above rounding.
TOLERANCE = {float: 5e-14, LONG: 1e-16}


def gragg(model: Any, t: Any, y: Any, h: Any, modes: list[Mode]) -> tuple[Any, Any]:
    """One extrapolated step of the modified midpoint rule, and an estimate of its error."""
    table: list[Any] = []
    f0 = rates(model, t, y, modes)
    previous = None
    for j, count in enumerate(SEQUENCE):
        s = h / count
        before, now = y, y + s * f0
        for k in range(1, count):
            before, now = now, before + 2 * s * rates(model, t + k * s, now, modes)
        row = [(before + now + s * rates(model, t + h, now, modes)) / 2]
        for m in range(1, j + 1):
            ratio = model.number(SEQUENCE[j]) ** 2 / model.number(SEQUENCE[j - m]) ** 2
            row.append(row[m - 1] + (row[m - 1] - table[m - 1]) / (ratio - 1))
        previous, table = table, row
    return table[-1], table[-1] - previous[-1]


def extrapolation(
    model: Any, t: Any, y: Any, end: Any, modes: list[Mode]
) -> Iterator[tuple[Any, Any, Path_]]:
    """Yield steps of order twelve. A state within a step is computed by a shorter step."""
    h = min(model.number(1e-6), end - t)
    scale = np.array([model.number(one) for one in model.sizes])
    while t < end:
        h = min(h, end - t)
        new, error = gragg(model, t, y, h, modes)
        size = float(np.max(np.abs(error) / scale)) / TOLERANCE[model.number]
        if size > 1.0 and h > 1e-13:  # below, only rounding is left of the estimate
            h *= max(0.3, 0.9 * size ** (-1 / 11))
            continue
        base, begin = y, t

        def path(time: Any, base: Any = base, begin: Any = begin) -> Any:
            return gragg(model, begin, base, time - begin, modes)[0] if time > begin else base

        t, y = (end if end - (t + h) < 1e-18 else t + h), new
        h *= 2.0 if size < 0.1 else 1.2
        yield t, y, path


class Peaks:
    """Largest absolute values within a window, refined around those ends of steps that are local peaks."""

    def __init__(self, model: Any) -> None:
        self.model, self.columns = model, [model.names.index(name) for name in model.largest]
        self.values = [0.0 for _ in self.columns]
        self.last: list[tuple[Any, ...]] = []  # two steps: begin, end, path, modes, values at both ends

    def take(self, begin: Any, end: Any, path: Path_, modes: list[Mode]) -> None:
        """Look at a step from begin to end."""
        if begin < self.model.window * (1.0 - 1e-12):
            return
        ends = [[abs(self.model.outputs(t, path(t), modes)[c]) for c in self.columns] for t in (begin, end)]
        self.last = [*self.last[-1:], (begin, end, path, modes, *ends)]
        for k, column in enumerate(self.columns):
            self.values[k] = max(self.values[k], ends[0][k], ends[1][k])
            middle = self.last[0][5][k]
            if len(self.last) == 2 and middle > max(0.99 * self.values[k], self.last[0][4][k], ends[1][k]):
                peaks = [self.refined(low, high, column, p, m) for low, high, p, m, *_ in self.last]
                self.values[k] = max(self.values[k], *peaks)

    def refined(self, low: Any, high: Any, column: int, path: Path_, modes: list[Mode]) -> Any:
        """Find the maximum between two times by golden section."""
        golden = (math.sqrt(5.0) - 1.0) / 2.0

        def size(t: Any) -> Any:
            return abs(self.model.outputs(t, path(t), modes)[column])

        left, right = high - golden * (high - low), low + golden * (high - low)
        f, g = size(left), size(right)
        for _ in range(24):
            if f < g:
                low, left, f = left, right, g
                right = low + golden * (high - low)
                g = size(right)
            else:
                high, right, g = right, left, f
                left = high - golden * (high - low)
                f = size(left)
        return max(f, g)


def integrate(model: Any, steps: Any, least: float) -> tuple[list[list[Any]], list[Any], list[list[Any]]]:
    """Rows of the table, largest values, and times of the onsets of each contact."""
    number = model.number
    t, y = number(0), np.array(model.start())
    touches, approaches = [False] * model.contacts, [number(1)] * model.contacts
    onsets: list[list[Any]] = [[] for _ in touches]
    rows, peaks = [[t, *model.outputs(t, y, modes_at(model, t, y, touches, approaches))]], Peaks(model)
    marks = [number(model.duration) * k / ROWS for k in range(ROWS + 1)]
    while len(rows) <= ROWS:
        modes, end = modes_at(model, t, y, touches, approaches), marks[len(rows)]
        begin = t
        for time, state, path in steps(model, t, y, end, modes):
            changed = crossed(model, time, state, modes)
            if changed:
                time = border(model, path, begin, time, modes, least)
                state = path(time)
                changed = crossed(model, time, state, modes)
            peaks.take(begin, time, path, modes)
            begin, t, y = time, time, state
            for k, kind, _ in changed:
                if kind == "gap":
                    touches[k] = not touches[k]
                    if touches[k]:
                        approaches[k] = model.gaps(t, y)[k][1]
                        onsets[k].append(t)
            if changed:
                break
        else:
            rows.append([t, *model.outputs(t, y, modes)])
            if len(rows) % 100 == 1:
                print(f"  {float(t):.4f} s", file=sys.stderr, flush=True)
    return rows, peaks.values, onsets


PROBLEMS = {
    "four_bar": (FourBarAtCentres(), FourBarAtPins()),
    "slider_crank": (SliderCrankAtCentres(), SliderCrankInComplexNumbers(LONG, np.cos, np.sin, np.sqrt)),
}


def certify(name: str, folder: Path) -> None:
    """Integrate a problem twice; write the second's numbers with the digits that both have."""
    first, second = PROBLEMS[name]
    print(name, "by Runge and Kutta", file=sys.stderr)
    one = integrate(first, dormand_prince, 1e-17)
    print(name, "by extrapolation", file=sys.stderr)
    two = integrate(second, extrapolation, 1e-20)
    a, b = np.array(one[0], float), np.array(two[0], float)
    scale = np.abs(b[:, 1:]).max(axis=0)
    apart = np.maximum.accumulate((np.abs(a - b)[:, 1:] / scale).max(axis=1))
    names = first.names
    with (folder / "reference.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["t", *names, "apart"])
        for row, distance in zip(two[0], apart, strict=True):
            writer.writerow(
                [f"{float(row[0]):.6g}", *(f"{float(x):.12g}" for x in row[1:]), f"{distance:.1e}"]
            )
    with (folder / "largest.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["quantity", "largest", "apart"])
        for label, x, z in zip(first.largest, one[1], two[1], strict=True):
            writer.writerow([label, f"{float(z):.10g}", f"{abs(float(x) / float(z) - 1.0):.1e}"])
    counts = [len(times) for times in two[2]]
    print(name, "apart at the end:", apart[-1], "onsets:", counts, [len(times) for times in one[2]])
    for digits in (8, 6, 4, 2):
        certain = a[:, 0][apart < 10.0**-digits]
        print(f"  {digits} digits until {certain[-1]:.4g} s")
    for label, x, z in zip(first.largest, one[1], two[1], strict=True):
        print(f"  {label}: {float(z):.12g}, apart {abs(float(x) / float(z) - 1.0):.1e}")


if __name__ == "__main__":
    for problem in sys.argv[1:] or PROBLEMS:
        certify(problem, Path(__file__).parent / problem)
