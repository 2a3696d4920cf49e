"""On which body a pair of gears turns: as its noun says, or as the pins of its wheels show."""

from __future__ import annotations

from collections.abc import Iterator

from .joints import Gear
from .mechanism import Mechanism

Place = tuple[str, str]


def carrier_of(mechanism: Mechanism, gear: Gear) -> str:
    """The body on which both wheels of a gear turn, ``"ground"`` where they do so on the ground.

    A body carries a wheel that is pinned to it, and one that turns on the ground about the very point about which the carrier does: the sun of a
    planetary train, or its ring. Nothing carries a wheel that it is.
    """
    if gear.carrier is not None:
        return gear.carrier
    pins = list(_pins(mechanism))
    carried = [_carriers(pins, wheel) for wheel in (gear.first, gear.second)]
    found = [body for body in carried[0] if body in carried[1] and body not in (gear.first, gear.second, "ground")]
    return found[0] if found and not all("ground" in one for one in carried) else "ground"


def _pins(mechanism: Mechanism) -> Iterator[tuple[Place, Place]]:
    """The two sides of each revolute, with play or without; points of the ground by where they are."""
    for joint in mechanism.joints.values():
        if joint.revolves:
            one, two = (("ground", f"{mechanism.points[pin]}") if body == "ground" else (body, pin) for body, pin in joint.sides)
            yield one, two


def _carriers(pins: list[tuple[Place, Place]], wheel: str) -> list[str]:
    """Bodies that carry a wheel."""
    own = [other for side, other in _both(pins) if side[0] == wheel]
    found = [body for body, _ in own]
    axes = [place for place in own if place[0] == "ground"]
    if wheel == "ground":  # a ring that stands: whatever turns on the ground may carry its planets
        return [body for (here, _), (body, _) in _both(pins) if here == "ground"]
    return found + [side[0] for side, other in _both(pins) if other in axes and side[0] != wheel]


def _both(pins: list[tuple[Place, Place]]) -> Iterator[tuple[Place, Place]]:
    """Each pin from either side."""
    for one, other in pins:
        yield one, other
        yield other, one
