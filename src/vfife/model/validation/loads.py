"""Checks of loads: where they act, the guide or crank that they depend on, and their tables; cautions about
tables of loads and drivers that look like those of another unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ...errors import Fault, Path
from ...units import in_rpm
from ..bodies import PointMass
from ..functions import turn_of, turning_speed
from ..geometry.expression import VARIABLES, parse
from ..geometry.tabulated import ApproximationError, closes, sampled
from ..loads.load import ARGUMENTS
from ..rows import AcrossGuide, place_row, turn_row
from .checks import Checks, readable, rows_of, shown_name
from .magnitudes import FASTEST

if TYPE_CHECKING:
    from ..mechanism import Mechanism

FULL_TURN = 2.0 * math.pi
MANY_TURNS = 10.0  # of a table over angles
LATE = 100.0  # times the run, the extent of a table over time; milliseconds taken for seconds: 1000
RETURN = 0.25  # of the range of angles, by which a motion that swings back may miss its begin
# rad/s; a larger speed without decimals may be meant in revolutions per minute. 500 rad/s are 4,775 rpm.
FAST = 500.0
REPEATS = ("times", "angles")


def check_loads(checks: Checks) -> None:
    """Check every load."""
    for name, load in readable(checks.mechanism.loads):
        path: Path = ("load", name)
        if load.on_guide:
            check_guide(checks, path, load.slider)
            check_straight(checks, path, load)
        elif load.at is not None:
            follows = "a load that follows the ground stays where it is, and moves nothing"
            checks.side(
                (*path, "at"),
                load.at,
                ground=follows if load.follow is True else "a load on the ground moves nothing",
            )
        check_alone(checks, path, load)
        if load.axis == "angles":
            check_crank(checks, path, load)
        if load.axis in ("travels", "speeds") and not load.on_guide:
            check_guide(checks, path, load.slider)


def check_alone(checks: Checks, path: Path, load: Any) -> None:
    """Check what does not depend on the rest of the mechanism."""
    if not checks.fails(path):
        checks.conflicts(path, load)
    if load.expression:
        check_expression(checks, path, load)
    else:
        check_table(checks, path, load)


def check_expression(checks: Checks, path: Path, load: Any) -> None:
    """Check that an expression can be parsed, has a range, can be approximated there, and alone determines
    the load.
    """
    value, back = load.keys
    for key in (value, back):
        if getattr(load, key) is not None:
            checks.add((*path, key), f"an expression and {key} exclude each other", "keep one of them")
            return
    for key in ("expression", "expression_back"):
        text = getattr(load, key)
        if not text or checks.fails((*path, key)):
            continue
        try:
            variable = parse(text).variable
        except Fault as error:
            checks.add((*path, key), f"{error.where}: {error.what}", error.remedy)
            return
        if key == "expression_back" and (variable not in ("", "x") or load.axis != "travels"):
            checks.add(
                (*path, key),
                "only an expression of x has a way back",
                "remove it, or make both expressions of the travel x",
            )
        elif ranged(checks, path, load, variable or load.variable):
            follow(checks, path, load, key)


def ranged(checks: Checks, path: Path, load: Any, variable: str) -> bool:
    """Return whether an expression has a valid range of its variable; add a fault if not."""
    axis = VARIABLES.get(variable, "")
    excluded = [key for key in ARGUMENTS if getattr(load, key) is not None and key != axis]
    if excluded:
        problem = (
            f"an expression of {variable} goes over {axis}"
            if axis
            else "a constant expression goes over nothing"
        )
        checks.add(
            (*path, excluded[0]),
            f"{problem}, not over {excluded[0]}",
            f"give {axis} = [first, last]" if axis else "remove it",
        )
    elif axis and not load.places:
        problem = f"an expression of {variable} needs the range over which it is meant"
        checks.add(
            (*path, axis), problem, f"give {axis} = [first, last]; beyond them it keeps its end values"
        )
    elif axis and (len(load.places) != 2 or load.places[1] <= load.places[0]):
        checks.add(
            (*path, axis),
            "the range of an expression is its first and its last place",
            f"give {axis} = [first, last]",
        )
    else:
        return bool(axis) and not any(checks.fails((*path, key)) for key in ARGUMENTS)
    return False


def follow(checks: Checks, path: Path, load: Any, key: str) -> None:
    """Check that polynomials can approximate an expression over its range."""
    try:
        pieces = sampled(getattr(load, key), load.places[0], load.places[1])
    except ApproximationError as error:
        period = " (of a function that repeats to one period, with repeat = true)" * (load.axis in REPEATS)
        remedy = f"narrow the range{period}, or keep it from that place, with min or max"
        checks.add((*path, key), str(error), remedy)
        return
    if load.repeat is True and load.axis not in REPEATS:
        checks.add((*path, "repeat"), "only a function of times or angles can repeat", "remove it")
    elif load.repeat is True and not pieces.closes:
        first, last = pieces.ends
        problem = f"an expression that repeats itself begins at {first:g} and ends at {last:g}"
        checks.add((*path, key), problem, "let its range be a whole number of its periods, or remove repeat")


def check_table(checks: Checks, path: Path, load: Any) -> None:
    """Check that a table has one argument, lists of equal length and, if periodic, equal ends."""
    axes = [key for key in ARGUMENTS if getattr(load, key) is not None]
    value, back = load.keys
    if len(axes) > 1:
        checks.add(
            (*path, axes[-1]),
            f"a load is a table over one of {' and '.join(axes)}, not over all",
            "keep one of them",
        )
        return
    if any(checks.fails((*path, key)) for key in (*ARGUMENTS, value, back)):
        return
    if load.expression_back:
        checks.add(
            (*path, "expression_back"),
            "a way back as an expression goes with an expression",
            "give both, or neither",
        )
    axis = axes[0] if axes else "times"
    values = getattr(load, value)
    if axes or isinstance(values, tuple | list):
        checks.series(path, (value, values), (axis, getattr(load, axis)))
        if getattr(load, back) is not None:
            checks.series(path, (back, getattr(load, back)), (axis, getattr(load, axis)))
    if getattr(load, back) is not None and axis != "travels":
        checks.add(
            (*path, back), "only a table over travels has a way back", "remove it, or give the table travels"
        )
    check_repeat(checks, path, load, axis if axes else "", value)


def check_crank(checks: Checks, path: Path, load: Any) -> None:
    """Check that the crank exists, or that a driver turns a body."""
    turned = [
        name for name, driver in checks.drivers.items() if driver.moves and driver.revolves and turns(driver)
    ]
    if load.crank:
        checks.body((*path, "crank"), load.crank)
    elif load.crank == "" and not turned and len(checks.drivers) == len(checks.mechanism.drivers):
        remedy = 'name the body whose angle it depends on, as in crank = "crank"'
        checks.add((*path, "crank"), "a table over angles needs a crank, and no driver turns a body", remedy)


def turns(driver: Any) -> bool:
    """Return whether a driver turns a body; True if it is not fully known."""
    try:
        return turning_speed(driver) > 0.0
    except TypeError:
        return True


def check_guide(checks: Checks, path: Path, slider: Any) -> None:
    """Check that the joint exists and has a straight guide."""
    if slider is None or checks.fails((*path, "slider")):
        return
    guided = [
        name
        for name, joint in checks.joints.items()
        if isinstance(place_row(rows_without_clearance(joint)), AcrossGuide)
    ]
    if slider in guided or slider in checks.mechanism.joints.keys() - checks.joints.keys():
        return
    listed = (
        f"name a joint with a guide: {', '.join(guided[:12])}" if guided else 'add a joint of kind "slider"'
    )
    if slider in checks.joints:
        checks.add(
            (*path, "slider"),
            f"joint {slider} is of kind {checks.joints[slider].kind}, which has no guide",
            listed,
        )
    elif not slider:
        checks.add((*path, "slider"), "a table over travels or speeds needs a joint with a guide", listed)
    else:
        checks.add(
            (*path, "slider"),
            f"there is no joint {shown_name(slider)}",
            checks.name_hint(slider, guided, listed),
        )


def rows_without_clearance(joint: Any) -> Any:
    """Return the rows of a joint or of its ideal joint; none for invalid sizes, which have their
    own fault.
    """
    try:
        return tuple(joint.rows())
    except (TypeError, ValueError, AttributeError):
        return ()


def check_straight(checks: Checks, path: Path, load: Any) -> None:
    """Check that the journal of a moving guide turns with it."""
    joint = checks.joints.get(load.slider)
    if joint is None or not joint.bearing or not joint.journal or joint.sides[0][0] == "ground":
        return
    turning = turn_row(rows_without_clearance(joint)) is None and bool(rows_of(joint))
    body = checks.bodies.get(joint.sides[1][0])
    if turning or (isinstance(body, PointMass) and not body.inertia):
        problem = f"the guide of {load.slider} moves, and what slides in it does not turn with it"
        checks.add(
            (*path, "slider"), problem, "let the guide be on the ground, or hold the turn (turning = false)"
        )


def check_repeat(checks: Checks, path: Path, load: Any, axis: str, value: str) -> None:
    """Check that a periodic table ends with its first value."""
    values = getattr(load, value)
    if load.repeat is not True:
        return
    if axis not in REPEATS:
        checks.add((*path, "repeat"), "only a table over times or angles repeats itself", "remove it")
    elif isinstance(values, tuple | list) and len(values) > 1 and None not in values and not closes(values):
        problem = f"a table that repeats itself begins at {values[0]:g} and ends at {values[-1]:g}"
        checks.add((*path, value), problem, "give its last place the value of the first, or remove repeat")


# ---------------------------------------------------------------------------------- tables in other units


def suspect_tables(mechanism: Mechanism) -> Iterator[str]:
    """Caution about speeds, angles and times of tables that look like those of another unit."""
    length = _length_of_run(mechanism)
    for section, entries in (("driver", mechanism.drivers), ("load", mechanism.loads)):
        for name, entry in entries.items():
            path = f"{section}.{name}"
            linear = section == "load" or getattr(entry, "is_linear", False)
            yield from _table_speeds(f"{path}.speeds", getattr(entry, "speeds", None) or (), linear)
            if not (section == "driver" and linear):
                yield from _table_angles(f"{path}.angles", getattr(entry, "angles", None) or (), rises=True)
                if section == "driver":
                    values = getattr(entry, "values", None) or ()
                    yield from _table_angles(f"{path}.angles", values, rises=False)
            times = getattr(entry, "times", None) or ()
            if length and times and times[-1] - times[0] > LATE * length:
                yield (
                    f"{path}.times cover {times[-1] - times[0]:.6g} s, {(times[-1] - times[0]) / length:,.0f}"
                    f" times the run of {length:.4g} s: are they in ms? Numbers without a unit are seconds."
                )


def _length_of_run(mechanism: Mechanism) -> float:
    """Return the length (s) of a run as the model states it; 0 for a static analysis or without any."""
    settings, turn = mechanism.settings, turn_of(mechanism)
    if settings.analysis == "static":
        return 0.0
    return settings.duration or (settings.turns or 0.0) * (turn or 0.0)


def _table_speeds(path: str, speeds: tuple[float, ...], linear: bool) -> Iterator[str]:
    """Caution about ``speeds`` (rad/s; linear: m/s) that may be in rpm or mm/s."""
    highest = max(map(abs, speeds), default=0.0)
    if linear and highest > FASTEST:
        yield (
            f"{path} reach {highest:.6g} m/s, faster than the parts of most machines: are they in mm/s?"
            " Numbers without a unit are m/s."
        )
    if not linear and highest >= FAST and all(speed == round(speed) for speed in speeds):
        yield (
            f"{path} reach {highest:,.0f} rad/s, which is {in_rpm(highest)}: are they in rpm? Numbers"
            " without a unit are rad/s."
        )


def _table_angles(path: str, angles: tuple[float, ...], rises: bool) -> Iterator[str]:
    """Caution about ``angles`` (rad) of more than a turn that may be in degrees: whole numbers, those of a
    motion that swings back, or, where a table ``rises`` with them, many turns.
    """
    extent = max(angles, default=0.0) - min(angles, default=0.0)
    integers = all(angle == round(angle) for angle in angles)
    swings = not rises and bool(angles) and abs(angles[-1] - angles[0]) <= RETURN * extent
    if extent > FULL_TURN and (integers or swings or (rises and extent > MANY_TURNS * FULL_TURN)):
        yield (
            f"{path} cover {extent:.6g} rad, {extent / FULL_TURN:.3g} turns: are they in degrees? Numbers"
            " without a unit are radians."
        )
