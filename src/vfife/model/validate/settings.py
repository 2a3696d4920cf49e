"""Checks of settings: one length of the run, and turns only where something turns; a static analysis has none."""

from __future__ import annotations

from typing import Any

from .checks import Checks


def check_settings(checks: Checks) -> None:
    """What a run is asked for."""
    settings: Any = checks.mechanism.settings
    if settings is None:
        return
    if settings.analysis == "static":
        check_static(checks, settings)
        return
    check_settle(checks, settings)
    given = [getattr(settings, key) is not None or checks.told(("run", key)) for key in ("turns", "duration")]
    if all(given):
        checks.add(("run", "duration"), "turns and duration exclude each other", "remove one of the two")
        return
    # A driver of which nothing is known is told itself, and may be meant to turn something.
    drivers: dict[str, Any] = dict(checks.mechanism.drivers)
    idle = all(driver is not None and (driver.target != "body" or not driver.moves) for driver in drivers.values())
    if settings.turns is not None and idle:
        checks.add(("run", "turns"), "nothing is driven, so there are no turns to count", "give a duration instead")


def check_settle(checks: Checks, settings: Any) -> None:
    """Turns that are to repeat are those of a crank at constant speed."""
    drivers: dict[str, Any] = dict(checks.mechanism.drivers)  # of which some may not have been read
    moving = [driver for driver in drivers.values() if driver is not None and driver.moves]
    if settings.settle is None or checks.told(("run", "settle")):
        return
    if not any(driver.steady_speed for driver in moving) or any(driver.steady_speed is None for driver in moving):
        checks.add(("run", "settle"), "no crank turns at constant speed, so there are no turns that could repeat", "leave it out, and say how long")


def check_static(checks: Checks, settings: Any) -> None:
    """Load factors take the place of time, so nothing has a duration or a speed."""
    for key in ("turns", "duration", "settle"):
        if getattr(settings, key) is not None:
            remedy = "remove it; load_factors = [...] says for which loads equilibrium is sought"
            checks.add(("run", key), "a static analysis takes no time", remedy)
    if settings.load_factors is not None and len(settings.load_factors) == 0:
        checks.add(("run", "load_factors"), "there is no load factor to find equilibrium for", "give one at least, or leave the key out")
    for name, driver in checks.drivers.items():
        for key, remedy in (
            ("speed", "give a travel with a duration, or a table over times: the load factors take the place of time"),
            ("speeds", "give one torque or force, or a table over times"),
        ):
            if getattr(driver, key, None) is not None:
                checks.add(("driver", name, key), "nothing has a speed in a static analysis", remedy)
