"""Checks of run settings, names and laws."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ...errors import Fault, Path, place, shown
from ...laws import Law, Pair
from ...laws.law import LAWS, law_kind
from ...laws.materials import EXAMPLE_COEFFICIENT, coefficient
from ..functions import NO_CRANK
from ..surfaces import surfaces
from ..wear import Wear
from .checks import NAME_LIMIT, Checks, entries_of, readable

if TYPE_CHECKING:
    from ..mechanism import Mechanism


def check_settings(checks: Checks) -> None:
    """Check length and analysis of the run."""
    settings: Any = checks.mechanism.settings
    if settings is None:
        return
    if settings.analysis == "static":
        check_static(checks, settings)
        return
    check_settle(checks, settings)
    lengths = [
        getattr(settings, key) is not None or checks.fails(("run", key)) for key in ("turns", "duration")
    ]
    if all(lengths):
        checks.add(("run", "duration"), "turns and duration exclude each other", "remove one of the two")
        return
    # An unreadable driver has its own fault, and may turn a body.
    drivers: dict[str, Any] = dict(checks.mechanism.drivers)
    idle = all(
        driver is not None and (driver.target != "body" or not driver.moves) for driver in drivers.values()
    )
    if settings.turns is not None and idle:
        checks.add(
            ("run", "turns"), "nothing is driven, so there are no turns to count", "give a duration instead"
        )


def check_settle(checks: Checks, settings: Any) -> None:
    """Check that ``settle`` has turns to compare: a crank with constant speed."""
    drivers: dict[str, Any] = dict(checks.mechanism.drivers)  # of which some may not have been read
    moving = [driver for driver in drivers.values() if driver is not None and driver.moves]
    if settings.settle is None or checks.fails(("run", "settle")):
        return
    if not any(driver.steady_speed for driver in moving) or any(
        driver.steady_speed is None for driver in moving
    ):
        checks.add(
            ("run", "settle"),
            f"{NO_CRANK}, so there are no turns that could repeat",
            "leave it out, and give a duration",
        )


def check_static(checks: Checks, settings: Any) -> None:
    """Check that a static analysis has load factors, and no duration or speed."""
    for key in ("turns", "duration", "settle"):
        if getattr(settings, key) is not None:
            remedy = "remove it; load_factors = [...] selects the loads of the equilibria"
            checks.add(("run", key), "a static analysis takes no time", remedy)
    if settings.load_factors is not None and len(settings.load_factors) == 0:
        checks.add(
            ("run", "load_factors"),
            "there is no load factor to find equilibrium for",
            "give one at least, or leave the key out",
        )
    for name, driver in checks.drivers.items():
        for key, remedy in (
            (
                "speed",
                (
                    "give a travel with a duration, or a table over times: the load factors take the place of"
                    " time"
                ),
            ),
            ("speeds", "give one torque or force, or a table over times"),
        ):
            if getattr(driver, key, None) is not None:
                checks.add(("driver", name, key), "nothing has a speed in a static analysis", remedy)


def check_laws(mechanism: Mechanism) -> list[Fault]:
    """Return the faults of the laws of all joints with clearance, for a mechanism that is otherwise valid."""
    faults = []
    for name, joint in mechanism.contacts.items():
        pair = surfaces(mechanism, joint)
        for kind in LAWS:
            problem = unsuitable(getattr(joint, kind), pair)
            if problem:
                size = f" (clearance {pair.clearance:g} m)" if pair.clearance else ""
                remedy = "check clearance, bearing_radius, axial_length and materials, or take another law"
                faults.append(Fault(place(("joint", name, kind)), problem + size, remedy=remedy))
        faults += [] if joint.wear is None else unknown_hardness(name, joint.wear, pair)
    return faults


def unknown_hardness(name: str, wear: Wear, pair: Pair) -> list[Fault]:
    """Return a fault for each surface whose wear coefficient needs a hardness that its material lacks."""
    faults = []
    for side in ("bearing", "journal"):
        named, material = getattr(wear, side), getattr(pair, side)
        if coefficient(named, material) is None:
            problem = (
                f"the coefficient of this pair is over the hardness of the {side}, and that of"
                f" {material.name} is not known"
            )
            remedy = (
                f"give the material of the {side} its hardness, or the coefficient itself, as in"
                f' "{EXAMPLE_COEFFICIENT}"'
            )
            faults.append(Fault(place(("joint", name, "wear", side)), problem, shown(named), "", remedy))
    return faults


def unsuitable(law: Law, pair: Pair) -> str:
    """Return why a law cannot be used for two surfaces; "" if its parameters are real and finite."""
    try:
        values = [float(value) for value in law.parameters(pair)]
    except ValueError as error:  # the law's own sentence, if it has one
        if law.name in str(error):
            return str(error)
        values = [float("nan")]
    except (ArithmeticError, TypeError):
        values = [float("nan")]
    if all(abs(value) < float("inf") for value in values):
        return ""
    return f'the {law_kind(type(law))} law "{law.name}" gives no finite numbers for these surfaces'


TITLE_LIMIT = 300  # characters of a mechanism's name
SECTIONS = {"body": "bodies", "joint": "joints", "gear": "gears", "spring": "springs", "load": "loads"}


def check_names(checks: Checks) -> None:
    """Check that there are bodies, and all names."""
    if not checks.bodies:
        checks.add(("body",), "the model has no body", "add a table such as [body.crank]")
    for key, allowed in (("name", ""), ("note", "\n\t")):
        text = getattr(checks.mechanism, key)
        if isinstance(text, str) and not all(sign.isprintable() or sign in allowed for sign in text):
            checks.add((key,), "it contains characters that cannot be printed", "leave them out")
    if len(str(checks.mechanism.name)) > TITLE_LIMIT:
        checks.add(
            ("name",),
            f"it has {len(checks.mechanism.name):,} characters",
            f"use at most {TITLE_LIMIT}; a note may be longer",
        )
    for path in named_paths(checks):
        check_name(checks, path)
    for section, field in SECTIONS.items():
        for key, item in readable(getattr(checks.mechanism, field)):
            if item.name != key:
                problem = f"the {section} {shown(key)} has another name, {shown(item.name)}"
                checks.add((section, key, "name"), problem, "use the same name for both")


def check_name(checks: Checks, path: Path) -> None:
    """Check that a name can be part of a path."""
    name = path[-1]
    if not (
        isinstance(name, str)
        and 0 < len(name) <= NAME_LIMIT
        and name.isprintable()
        and name == name.strip()
        and "." not in name
    ):
        remedy = f"choose a name of 1 to {NAME_LIMIT} printable characters without dots"
        checks.add((*path[:-1], ""), f"the name {shown(name)} cannot be part of a path", remedy)


def named_paths(checks: Checks) -> Iterator[Path]:
    """Yield the paths of everything that the user names."""
    model = checks.mechanism
    yield from (("ground", name) for name in model.points or ())
    for section, field in SECTIONS.items():
        yield from ((section, name) for name in getattr(model, field))
    # The name of a driver is checked as that of its body, unless it differs.
    yield from (
        ("driver", name)
        for name, driver in readable(model.drivers)
        if driver.target != "body" or driver.body != name
    )
    for name, body in readable(checks.bodies):
        for key in ("pins", "nodes"):
            yield from (("body", name, key, pin) for pin in entries_of(body, key))
