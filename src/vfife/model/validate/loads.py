"""Checks of loads: a load acts at a pin of a body; its lists are alike."""

from __future__ import annotations

from .checks import Checks, known


def check_loads(checks: Checks) -> None:
    """Every load."""
    for name, load in known(checks.mechanism.loads):
        follows = "a load that follows the ground stays where it is, and moves nothing"
        checks.side(("load", name, "at"), load.at, ground=follows if load.follow is True else "a load on the ground moves nothing")
        if load.times is not None or load.factors is not None:
            checks.series(("load", name), ("factors", load.factors), ("times", load.times))
