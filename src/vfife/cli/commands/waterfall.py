"""``vfife waterfall``: spectra of series over a number that changes from run to run, mostly over the speed of
the crank.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..options import FIGURE_FILE, flag, option, positive
from .map import MapOptions, number_range

if TYPE_CHECKING:
    from ...model.mechanism import Mechanism


class WaterfallOptions(MapOptions):
    """Options of ``vfife waterfall``."""

    over: str = option(
        ...,
        "The number, from and to, as in driver.crank.speed=500..3000rpm.",
        "PATH=LOW..HIGH",
        show_default=False,
    )
    count: int = option(50, "Values of it, a run each.", "N", min=2, max=10_000)
    turns: int = option(12, "Turns of each run.", "N", min=1, max=1_000_000)
    last: int | None = option(
        None,
        "So many of the last are transformed: orders are 1/N apart.",
        "N",
        min=1,
        show_default="4, or all of fewer turns",
    )
    of: list[str] | None = option(
        None, "Series, as C.force.", "SERIES", show_default="forces of joints with clearance"
    )
    outputs: int = option(
        1440, "Samples in a turn; what is faster than half of them is folded back.", "N", min=8
    )
    highest: float = option(50.0, "Highest order that is kept.", "ORDER")
    window: str = option("hann", "hann, hamming, blackman, flat-top or rectangular.", "NAME")
    hertz: bool = flag("--hertz", "Draw frequencies instead of orders.")
    step: str | None = option(None, "Time step.", "TIME", show_default="the finer automatic one of both ends")
    target: Path | None = option(
        None, "Where to keep it.", "FILE.waterfall", "-o", "--output", show_default="runs/MODEL.waterfall"
    )
    figure: Path | None = option(None, "The picture.", FIGURE_FILE, show_default="FILE-waterfall.png")


def waterfall(options: WaterfallOptions) -> None:
    """Waterfall: spectra over a number, mostly the crank's speed, by orders of the crank; a run each, side by
    side on all cores.

    Every run begins at the model's own start. After Ctrl-C or a kill the same command goes on with the runs
    that are missing.
    """

    def compute(mechanism: Mechanism, **job: Any) -> Any:
        from ...dynamics.waterfall import waterfall as waterfall_of

        path, low, high, _ = number_range(mechanism, options.over)
        shared = {
            name: getattr(options, name)
            for name in ("count", "turns", "last", "outputs", "highest", "window")
        }
        step = positive("--step", options.step, "s")
        return waterfall_of(mechanism, path, low, high, series=options.of or (), step=step, **shared, **job)

    options.make("waterfall", ".waterfall", "--count 20", compute, hertz=options.hertz)
