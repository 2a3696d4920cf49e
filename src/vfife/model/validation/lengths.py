"""Cautions about improbable lengths of links, joints, places of the ground and springs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from statistics import median
from typing import TYPE_CHECKING

from ...numerics.scalar import hypot
from ..bodies import Link, RigidBody

if TYPE_CHECKING:
    from ..mechanism import Mechanism

# A length this many times the median of the others is cautioned about; millimetres taken for metres: 1000.
OUT_OF_SCALE = 100.0
HUGE = 50.0  # m, longer than the links of machines
LONG = 5.0  # m, longer than the links of most machines
SLENDER = 300.0  # times a bearing's radius or the height of a block: links of machines are below 50


def _sizes(mechanism: Mechanism) -> dict[str, float]:
    """Return the lengths (m) of links, joints and places of the ground, by path."""
    sizes = {
        f"body.{name}.length": body.length
        for name, body in mechanism.bodies.items()
        if isinstance(body, Link)
    }
    sizes |= {
        f"joint.{name}.length": length
        for name, joint in mechanism.joints.items()
        if (length := getattr(joint, "length", None))
    }
    for name, (x, y) in mechanism.points.items():
        sizes |= {f"ground.{name}": hypot(x, y)} if x or y else {}
    return sizes


def suspect_spring_lengths(mechanism: Mechanism) -> Iterator[str]:
    """Caution about free lengths of springs a hundred times the other lengths, or longer than any machine; a
    short one, or none, is usual.
    """
    sizes = list(_sizes(mechanism).values())
    for body in mechanism.bodies.values():
        pins = body.pins.values() if isinstance(body, RigidBody) else ()
        sizes += [size for pin in pins if (size := hypot(*pin))]
    usual = median(sizes) if sizes else 0.0
    for name, spring in mechanism.springs.items():
        length = getattr(spring, "free_length", None) or 0.0
        if length > (OUT_OF_SCALE * usual or HUGE):
            ratio = f", {length / usual:,.0f} times the other lengths" if usual else ""
            yield (
                f"spring.{name}.free_length is {length:.6g} m{ratio}: is it {length:.6g} mm? Numbers without"
                " a unit are metres."
            )


def suspect_lengths(mechanism: Mechanism) -> Iterator[str]:
    """Caution about lengths a hundred times larger or smaller than the others, or larger than any machine."""
    sizes = _sizes(mechanism)
    if links_in_metres(mechanism):
        yield _in_metres({path: size for path, size in sizes.items() if size > LONG})
        return
    cautioned, lengths = False, sizes.values()
    # Medians take long: none is needed if no two lengths are so far apart.
    disparity = len(sizes) > 2 and not min(lengths) / max(lengths) >= 1.0 / OUT_OF_SCALE
    for path, size in sizes.items() if disparity else ():
        ratio = size / median(value for key, value in sizes.items() if key != path)
        if ratio > OUT_OF_SCALE:
            cautioned = True
            yield (
                f"{path} is {size:.6g} m, {ratio:,.0f} times the others: is it {size:.6g} mm? Numbers"
                " without a unit are metres."
            )
        elif ratio < 1.0 / OUT_OF_SCALE:
            cautioned = True
            yield (
                f"{path} is {1e3 * size:.4g} mm, {1.0 / ratio:,.0f} times smaller than the others: check its"
                " unit."
            )
    largest = max(sizes, key=lambda key: sizes[key], default="")
    if largest and not cautioned and sizes[largest] > HUGE and mechanism.settings.analysis != "static":
        yield (
            f"{largest} is {sizes[largest]:.6g} m long. Numbers without a unit are metres: is this meant, and"
            " not mm?"
        )


def links_in_metres(mechanism: Mechanism) -> dict[str, float]:
    """Return the lengths (m) of links that are probably in mm, by body: all links are longer than most
    machines, and they are whole numbers of metres or out of proportion to a bearing.
    """
    links = {name: body.length for name, body in mechanism.bodies.items() if isinstance(body, Link)}
    if not links or min(links.values()) <= LONG or mechanism.settings.analysis == "static":
        return {}
    radii = [getattr(joint, joint.extent[0], None) or 0.0 for joint in mechanism.contacts.values()]
    slender = any(0.0 < SLENDER * radius < min(links.values()) for radius in radii)
    return links if slender or all(length == round(length) for length in links.values()) else {}


def _in_metres(lengths: Mapping[str, float]) -> str:
    """Return a caution about ``lengths`` (m), by path, that are probably in mm."""
    told = ", ".join(f"{path} is {length:.6g} m" for path, length in lengths.items())
    meant = ", ".join(f"{length:.6g} mm" for length in lengths.values())
    verb = "is it" if len(lengths) == 1 else "are they"
    return f"{told}: {verb} {meant}? Numbers without a unit are metres."
