"""Checks of drivers and loads: what they act on, keys that go together, drivers that fight."""

from __future__ import annotations

import math

from ..errors import Path
from .checks import EFFORTS, MOTIONS, Checks, body_of, moves, shown_name, sides
from .schema import driver_kind, joint_kind
from .tables import Raw, amounts, entries, text

# What goes with a speed, a travel, an amplitude, places over time, or a torque or force; what is needed first.
NEEDS = {"speed": (), "travel": ("duration",), "amplitude": ("frequency",)}
BESIDE = {"speed": ("ramp",), "travel": ("duration", "begin"), "amplitude": ("frequency", "phase")}
COMPANIONS = ("ramp", "duration", "begin", "frequency", "phase", "times", "speeds")
UNITS = {"<body>": ("rad", "rad/s"), "<slider>": ("m", "m/s"), "<point>": ("m", "m/s")}


def check_drivers(checks: Checks) -> None:
    """Every driver, and which of them fight."""
    for name, driver in checks.drivers.items():
        check_target(checks, ("driver", name), name, driver)
        check_keys(checks, ("driver", name), driver)
    check_fights(checks)


def check_target(checks: Checks, path: Path, name: str, driver: Raw) -> None:
    """What is driven exists, and can be driven so."""
    kind = driver_kind(driver)
    if kind == "<slider>":
        check_slider(checks, (*path, "slider"), driver["slider"])
        return
    if kind == "<point>":
        checks.side((*path, "point"), driver["point"], ground="a driver of the ground moves nothing")
        checks.direction(path, driver)
        return
    body, against = body_of(name, driver), text(driver, "against", "ground")
    if body not in checks.bodies:
        advice = "name the table after the body that it drives, or give body, slider or point"
        remedy = checks.near(body, checks.bodies, advice)
        checks.add((*path, "body" if "body" in driver else ""), f"there is no body {shown_name(body)} to drive", remedy)
        return
    if checks.body((*path, "against"), against) and against == body:
        checks.add((*path, "against"), "a body has no angle against itself", "name another body, or leave it out for the ground")
        return
    if moves(driver):
        check_angle(checks, path, body, against)


def check_angle(checks: Checks, path: Path, body: str, against: str) -> None:
    """The body is free to turn, about one ideal joint where it turns against the ground."""
    for joint in checks.joints.values():
        held = {side.partition(".")[0] for side in sides(joint)} == {body, against}
        if held and (joint.get("kind") == "weld" or (joint.get("kind") == "slider" and joint.get("turning") is not True)):
            name = next(key for key, one in checks.joints.items() if one is joint)
            remedy = "drive the slider itself, with slider = ..., or set turning = true" if joint["kind"] == "slider" else "remove one of the two"
            checks.add((*path, ""), f"the {joint['kind']} {name} keeps the angle that is to be driven", remedy)
            return
    pivots = checks.pivots.get(body, [])
    if against == "ground" and len(pivots) != 1 and not dangling(checks):
        found = " and ".join(pivots) or "none"
        remedy = 'hold the body by one joint of kind "ideal" whose other side is a point of the ground'
        checks.add((*path, ""), f"a driven body turns about one ideal joint to the ground; here: {found}", remedy)


def dangling(checks: Checks) -> bool:
    """Whether a joint names a body that does not exist: which bodies it holds is not known then."""
    known = {"ground", *checks.bodies}
    return any(side.partition(".")[0] not in known for joint in checks.joints.values() for side in sides(joint))


def check_slider(checks: Checks, path: Path, slider: object) -> None:
    """The joint exists and is a slider."""
    if not isinstance(slider, str):
        return
    sliders = [name for name, joint in checks.joints.items() if joint_kind(joint) == "<slider>"]
    if slider in sliders:
        return
    if slider in checks.joints:
        what = f"joint {slider} is of kind {joint_kind(checks.joints[slider]).strip('<>')}, which has no travel to drive"
        remedy = f'name a joint of kind "slider": {", ".join(sliders[:12])}' if sliders else 'set its kind = "slider"'
        checks.add(path, what, remedy)
    else:
        checks.add(path, f"there is no joint {shown_name(slider)}", checks.near(slider, sliders, 'name a joint of kind "slider"'))


def check_keys(checks: Checks, path: Path, driver: Raw) -> None:
    """One kind of driver, with what goes with it and nothing else; its lists alike."""
    kind = driver_kind(driver)
    effort = {"<body>": "torque", "<point>": "force"}.get(kind, "force")
    places, unit = ("angles" if kind == "<body>" else "travels"), UNITS[kind][0]
    efforts = [key for key in EFFORTS if key in driver]
    told = [*(key for key in MOTIONS if key in driver and not (efforts and key == places)), *efforts]
    if len(told) != 1:
        what = f"{' and '.join(told)} exclude each other" if told else "nothing says what the driver does"
        limit = f"speed (with ramp), travel with duration, amplitude with frequency, {places} with times"
        limit += "" if kind == "<slider>" else f", or {effort} (with times, speeds or {places})"
        checks.add((*path, ""), what, "give one of these", limit)
        return
    does = told[0]
    over = [key for key in ("times", "speeds", places) if key in driver and key != does]
    beside = BESIDE.get(does, ("times", "speeds") if does in EFFORTS else ("times",))
    for key in COMPANIONS:
        if key in driver and key not in beside:
            owners = [owner for owner, mine in BESIDE.items() if key in mine] or ([places, effort] if key == "times" else [effort])
            checks.add((*path, key), f"{key} goes with {' or '.join(owners)}, not with {does}", "remove it")
    for key in NEEDS.get(does, ()):
        if key not in driver:
            checks.add((*path, key), f"{does} needs a {key}, which is missing", "add it")
    if does in EFFORTS and len(over) > 1:
        checks.add((*path, over[-1]), f"a {does} is a table over one of {' and '.join(over)}, not over all", "keep one of them")
    elif does in EFFORTS and (over or isinstance(driver.get(does), list)):
        axis = over[0] if over else "times"
        checks.series(path, driver, does, axis, {"times": "s", "speeds": UNITS[kind][1]}.get(axis, unit))
    elif does == places:
        checks.series(path, driver, does)


def check_fights(checks: Checks) -> None:
    """No two drivers prescribe the same thing."""
    held: dict[object, str] = {}
    points: dict[str, list[tuple[str, tuple[float, ...]]]] = {}
    for name, driver in checks.drivers.items():
        if not moves(driver):
            continue
        kind, path = driver_kind(driver), ("driver", name, "")
        if kind == "<point>":
            point, way = text(driver, "point"), amounts(driver.get("direction", [1, 0]), ("1", "1"))
            if way is None:
                continue
            before = points.setdefault(point, [])
            rival = next((one for one, other in before if parallel(way, other)), before[0][0] if len(before) > 1 else "")
            before.append((name, way))
            what = f"driver {rival} moves {point} along this direction already" if len(before) < 3 else f"{point} has two drivers already"
        else:
            slider = text(driver, "slider")
            body, against = body_of(name, driver), text(driver, "against", "ground")
            if (slider if kind == "<slider>" else body in checks.bodies) in ("", False):
                continue
            thing: object = ("slider", slider) if kind == "<slider>" else frozenset((body, against))
            rival = held.setdefault(thing, name)
            rival = "" if rival == name else rival
            what = f"driver {rival} drives {f'the slider {slider}' if kind == '<slider>' else body} already: the two fight"
        if rival:
            checks.add(path, what, "remove one of the two, or make one a torque or a force")


def parallel(one: tuple[float, ...], two: tuple[float, ...]) -> bool:
    """Whether two directions are alike but for their sign."""
    return abs(one[0] * two[1] - one[1] * two[0]) <= 1e-9 * math.hypot(*one) * math.hypot(*two)


def check_loads(checks: Checks) -> None:
    """A load acts at a pin of a body; its lists are alike."""
    for name, load in entries(checks.raw, "load"):
        why = (
            "a load that follows the ground stays where it is, and moves nothing"
            if load.get("follow") is True
            else "a load on the ground moves nothing"
        )
        checks.side(("load", name, "at"), load.get("at"), ground=why)
        if "times" in load or "factors" in load:
            checks.series(("load", name), load, "factors")
