"""``vfife modes``: natural frequencies of a mechanism about its start, and of its elastic links."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model
from .terminal import grid, output, print_json, row, sentences

if TYPE_CHECKING:
    from ..analysis.modes import Modes
    from ..model.mechanism import Mechanism

Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the lowest.")]
Released = Annotated[bool, typer.Option("--released", help="Without drivers, which otherwise hold what they drive.")]
NOTE = "About the start, at rest, joints with play taken as ideal, external contacts as open, loads left out; no damping."
UNBALANCED = 1e-3  # of all forces


def modes(
    model: ModelArgument,
    set_: SetOption = None,
    count: Count = 10,
    released: Released = False,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies and shapes about the start: of the whole mechanism, and of its elastic links by themselves.

    Shapes are in the JSON value: displacement (m, m, rad) of every particle, in the order of the particles of a result, the ground first.
    """
    with sentences(str(model)):
        mechanism = read_model(model, set_, laws)
        from ..analysis.modes import modes as found_modes

        found = found_modes(mechanism, count, released=released)
    if as_json:
        print_json(told(mechanism, found))
    else:
        show(mechanism, found)


def told(mechanism: Mechanism, found: Modes) -> dict[str, Any]:
    """Everything as texts and numbers."""
    return {
        "model": mechanism.name,
        "note": NOTE,
        "coordinates": found.count,
        "unbalanced": found.unbalanced,
        "modes": [
            {"frequency": one.frequency, "angular_frequency_squared": one.square, "energy": one.energy, "shape": one.shape.tolist()}
            for one in found.modes
        ],
        "links": {name: list(frequencies) for name, frequencies in found.links.items()},
    }


def turns_a_second(mechanism: Mechanism) -> float | None:
    """Speed of the first driver that turns at constant speed (1/s)."""
    speeds = (driver.steady_speed for driver in mechanism.drivers.values() if driver.moves)
    return next((abs(speed) / (2.0 * math.pi) for speed in speeds if speed), None)


def show(mechanism: Mechanism, found: Modes) -> None:
    """The same for people."""
    from rich.text import Text

    console, crank = output(), turns_a_second(mechanism)
    console.print(Text.assemble((mechanism.name, "bold"), f": {found.count or 'no'} natural vibration{'s' * (found.count != 1)}"))
    console.print(Text(NOTE))
    if not found.count:
        console.print(Text("Drivers and joints leave nothing that could vibrate: rigid links, and a drive that holds them. See --released."))
        return
    table = grid("", "frequency", *(["turns of the crank"] if crank else []), "moves most", right=(0, 1, 2) if crank else (0, 1))
    for number, mode in enumerate(found.modes, start=1):
        name, share = mode.leading
        order = [f"{mode.frequency / crank:.4g}"] if crank else []
        row(table, str(number), frequency(mode.frequency, mode.square), *order, f"{name}, {100.0 * share:.0f} % of the energy")
    console.print(table)
    for name, frequencies in found.links.items():
        console.print(Text(f"{name} alone, pinned at both ends: {', '.join(f'{one:.5g}' for one in frequencies)} Hz"))
    if found.unbalanced > UNBALANCED:
        console.print(
            Text(
                f"The start is no equilibrium: {100.0 * found.unbalanced:.2g} % of weight and springs set the mechanism in motion. These are the "
                "vibrations about it as if it stood still.",
                style="yellow",
            )
        )


def frequency(value: float, square: float) -> str:
    """A frequency in words; what is unstable by the time in which it grows e-fold."""
    if square < 0.0:
        return f"unstable, e-fold in {1.0 / math.sqrt(-square):.3g} s"
    return "0 Hz: moves freely" if square == 0.0 else f"{value:.5g} Hz"
