"""Checks of drivers: their targets and tables, and drivers that contradict each other."""

from __future__ import annotations

from typing import Any

from ...errors import Path
from ...numerics.scalar import hypot
from ..rows import AcrossGuide, turn_row
from .checks import Checks, bodies_of, rows_of, shown_name


def check_drivers(checks: Checks) -> None:
    """Check every driver, and pairs that contradict each other."""
    for name, driver in checks.drivers.items():
        path: Path = ("driver", name)
        check_target(checks, path, name, driver)
        check_tables(checks, path, driver)
    check_fights(checks)


def check_target(checks: Checks, path: Path, name: str, driver: Any) -> None:
    """Check that the target exists and that the driver can act on it."""
    targets = [target for target in ("body", "slider", "point") if getattr(driver, target)]
    if len(targets) > 1:
        remedy = "name one of them, or write a driver for each"
        if targets[0] == "body" and driver.body not in checks.mechanism.bodies:
            kind = targets[1]
            remedy = (
                f"name one of them: there is no body {shown_name(driver.body)}. In a script the first"
                f" argument is the driven body, and the driver of a {kind} takes its name from the {kind}"
            )
        checks.add((*path, targets[1]), f"it drives a {' and a '.join(targets)}", remedy)
    elif driver.target not in driver.drives:
        checks.add(
            (*path, driver.target),
            f"a {driver.lead_key} does not act on a {driver.target}",
            f"name a {' or a '.join(driver.drives)}",
        )
    elif driver.target == "slider":
        check_slider(checks, (*path, "slider"), driver.slider)
    elif driver.target == "point":
        checks.side((*path, "point"), driver.point, ground="a driver of the ground moves nothing")
    elif driver.body is not None:
        check_body(checks, path, name, driver)


def check_body(checks: Checks, path: Path, name: str, driver: Any) -> None:
    """Check that the body exists and is not driven relative to itself."""
    body, against = driver.body, driver.against
    if body not in checks.bodies:
        remedy = checks.name_hint(
            body, checks.bodies, "name the table after the body that it drives, or give body, slider or point"
        )
        checks.add(
            (*path, "body" if body != name else ""), f"there is no body {shown_name(body)} to drive", remedy
        )
    elif checks.body((*path, "against"), against) and against == body:
        checks.add(
            (*path, "against"),
            "a body has no angle against itself",
            "name another body, or leave it out for the ground",
        )
    elif driver.moves and against is not None:
        check_angle(checks, path, body, against)


def check_angle(checks: Checks, path: Path, body: str, against: str) -> None:
    """Check that the body can turn, and that it turns about one ideal joint if relative to the ground."""
    for name, joint in checks.joints.items():
        rows = rows_of(joint)
        if bodies_of(joint) == {body, against} and turn_row(rows) is not None:
            slides = any(isinstance(row, AcrossGuide) for row in rows)
            remedy = (
                "drive the slider itself, with slider = ..., or set turning = true"
                if slides
                else "remove one of the two"
            )
            checks.add((*path, ""), f"the {joint.kind} {name} keeps the angle that is to be driven", remedy)
            return
    pivots = checks.pivots.get(body, [])
    if against == "ground" and len(pivots) != 1 and not dangling(checks):
        listed = " and ".join(pivots) or "none"
        remedy = 'hold the body by one joint of kind "ideal" whose other side is a point of the ground'
        sides = {body, "ground"}
        loose = (name for name, contact in checks.mechanism.contacts.items() if bodies_of(contact) == sides)
        if (joint := next(loose, None)) is not None:
            remedy = (
                f"make {joint} ideal; or, with clearance there, let a torque accelerate the body, as in"
                ' torque = ["50 N m", 0], speeds = [0, "1500 rpm"], and give a duration in place of turns'
            )
        checks.add(
            (*path, ""),
            f"a driven body needs one ideal joint to the ground to turn about; here: {listed}",
            remedy,
        )


def dangling(checks: Checks) -> bool:
    """Return whether some joint is unknown or names a body that does not exist, so that connections are
    uncertain.
    """
    among = {"ground", *checks.bodies}
    return len(checks.joints) < len(checks.mechanism.joints) or any(
        bodies_of(joint) - among for joint in checks.joints.values()
    )


def check_slider(checks: Checks, path: Path, slider: str) -> None:
    """Check that the joint exists and is a slider."""
    sliders = [
        name
        for name, joint in checks.joints.items()
        if any(isinstance(row, AcrossGuide) for row in rows_of(joint))
    ]
    if slider in sliders or slider in checks.mechanism.joints.keys() - checks.joints.keys():
        return
    if slider in checks.joints:
        problem = f"joint {slider} is of kind {checks.joints[slider].kind}, which has no travel to drive"
        remedy = (
            f'name a joint of kind "slider": {", ".join(sliders[:12])}'
            if sliders
            else 'set its kind = "slider"'
        )
        checks.add(path, problem, remedy)
    else:
        checks.add(
            path,
            f"there is no joint {shown_name(slider)}",
            checks.name_hint(slider, sliders, 'name a joint of kind "slider"'),
        )


def check_tables(checks: Checks, path: Path, driver: Any) -> None:
    """Check the tables of a driver."""
    places = "travels" if driver.is_linear else "angles"
    if driver.lead == "values" and None not in (driver.times, driver.values):
        checks.series(path, (places, driver.values), ("times", driver.times))
    if not driver.moves:
        check_effort(checks, path, driver, places)


def check_effort(checks: Checks, path: Path, driver: Any, places: str) -> None:
    """Check that a torque or force is a number, or a table over one argument."""
    effort, axes = driver.lead_key, {"times": driver.times, "speeds": driver.speeds, places: driver.angles}
    arguments = [key for key, value in axes.items() if value is not None]
    if len(arguments) > 1:
        checks.add(
            (*path, arguments[-1]),
            f"a {effort} is a table over one of {' and '.join(arguments)}, not over all",
            "keep one of them",
        )
    elif (arguments or isinstance(driver.value, tuple | list)) and not any(
        checks.fails((*path, key)) for key in axes
    ):
        axis = arguments[0] if arguments else "times"
        checks.series(path, (effort, driver.value), (axis, axes[axis]))


def check_fights(checks: Checks) -> None:
    """Check that no two drivers prescribe the same motion."""
    motions: dict[object, str] = {}
    points: dict[str, list[tuple[str, Any]]] = {}
    for name, driver in checks.drivers.items():
        if not driver.moves:
            continue
        if driver.target == "point":
            if driver.direction is None:
                continue
            drives = points.setdefault(driver.point, [])
            rival = next(
                (driver_name for driver_name, direction in drives if parallel(driver.direction, direction)),
                drives[0][0] if len(drives) > 1 else "",
            )
            drives.append((name, driver.direction))
            parallel_problem = f"driver {rival} moves {driver.point} along this direction already"
            problem = parallel_problem if len(drives) < 3 else f"{driver.point} has two drivers already"
        else:
            slider, thing = driver.slider, frozenset((driver.body, driver.against))
            if not slider and driver.body not in checks.bodies:
                continue
            rival = motions.setdefault(("slider", slider) if slider else thing, name)
            rival = "" if rival == name else rival
            problem = (
                f"driver {rival} drives {f'the slider {slider}' if slider else driver.body} already: the two"
                " contradict each other"
            )
        if rival:
            checks.add(
                ("driver", name, ""), problem, "remove one of the two, or make one a torque or a force"
            )


def parallel(first: tuple[float, ...], second: tuple[float, ...]) -> bool:
    """Return whether two directions are parallel or antiparallel."""
    return abs(first[0] * second[1] - first[1] * second[0]) <= 1e-9 * hypot(*first) * hypot(*second)
