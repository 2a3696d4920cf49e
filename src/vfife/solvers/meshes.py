"""A static analysis repeated with other numbers of elements: the differences tell the error of its mesh."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..model.bodies import MOST_ELEMENTS, Body, Frame, Link
from ..model.mechanism import Mechanism
from .progress import Progress
from .record import Record
from .statics import equilibrium
from .status import Status

HALF, TWICE, FOUR_TIMES = 0.5, 2.0, 4.0  # of the elements of a model
WORDS = {HALF: "half", TWICE: "twice", FOUR_TIMES: "four times"}
STATIC_ITERATIONS = 1000.0, 40.0  # of an equilibrium: at least, and for each element along a body, squared, and each body
OVERHEAD = 10.0  # elements that take the time of all else in an iteration
MOST_WORK = 5e7  # iterations times elements of an analysis that is repeated by default: two or three seconds, ten with the repetition


def refinable(mechanism: Mechanism) -> bool:
    """Whether there are elements, all of which can be halved. A link of two particles is one element by
    definition.
    """
    elastic = [body for body in mechanism.bodies.values() if counts(body)]
    return bool(elastic) and all(body.model != "two-particle" and TWICE * sum(counts(body)) <= MOST_ELEMENTS for body in elastic)


def meshed(mechanism: Mechanism, share: float) -> Mechanism | None:
    """The mechanism with another ``share`` of the elements in each elastic body; None where that is no
    whole number.
    """
    bodies: dict[str, Body] = {}
    for name, body in mechanism.bodies.items():
        if any(not (share * count).is_integer() for count in counts(body)):
            return None
        bodies[name] = body
        if isinstance(body, Frame):
            members = tuple(dataclasses.replace(member, elements=int(share * member.elements)) for member in body.members)
            bodies[name] = dataclasses.replace(body, members=members)
        elif isinstance(body, Link) and body.element_count:
            bodies[name] = dataclasses.replace(body, elements=int(share * body.elements))
    return dataclasses.replace(mechanism, bodies=bodies)


def counts(body: Body) -> list[int]:
    """Elements of each member of a frame, or of an elastic link."""
    if isinstance(body, Frame):
        return [member.elements for member in body.members]
    return [body.elements] if isinstance(body, Link) and body.element_count else []


def iterations(assembly: Assembly) -> float:
    """Iterations that an equilibrium may take: those of slender frames go with the square of the elements
    in line.
    """
    least, each = STATIC_ITERATIONS
    bodies = assembly.bodies.values()
    longest = max((len(body.elements) for body in bodies), default=1)
    return min(least + each * longest * longest * len(bodies), float(assembly.mechanism.settings.iterations))


def worth(assembly: Assembly) -> bool:
    """Whether an analysis is short enough to be repeated by default."""
    return assembly.choice.outputs * iterations(assembly) * (len(assembly.topology.frame_nodes) + OVERHEAD) <= MOST_WORK


def other_meshes(record: Record, progress: Callable[[Progress], None] | None = None) -> dict[float, Record]:
    """The equilibria of a static analysis on other meshes, by their share of its elements: with twice as
    many, and with half of them.

    Where an odd number cannot be halved, with four times as many instead, if that is short. Without those
    that were not all found.
    """
    found: dict[float, Record] = {}
    for share in (TWICE, HALF):
        found |= _on_mesh(record, share, progress)
    return found if HALF in found or TWICE not in found else found | _on_mesh(record, FOUR_TIMES, progress)


def _on_mesh(record: Record, share: float, progress: Callable[[Progress], None] | None) -> dict[float, Record]:
    """The same on one of them; nothing where there is no such mesh."""
    mechanism = meshed(record.assembly.mechanism, share) if record.status == Status.COMPLETE else None
    if mechanism is None:
        return {}
    try:
        assembly = assemble(mechanism)
    except (VfifeError, ValueError):
        return {}
    if share == FOUR_TIMES and not worth(assembly):
        return {}

    def tell(now: Progress) -> None:
        if progress is not None:
            progress(dataclasses.replace(now, text=f"{WORDS[share]} the elements, {now.text}"))

    found = equilibrium(assembly, loop=record.loop, progress=tell)
    return {share: found} if found.status == Status.COMPLETE else {}
