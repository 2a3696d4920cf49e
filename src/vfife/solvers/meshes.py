"""A static analysis repeated with twice and with half the elements: the differences tell the error of its mesh."""

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

FINER = 2  # elements in the place of one
STATIC_ITERATIONS = 1000.0, 40.0  # of an equilibrium: at least, and for each element along a body, squared, and each body
OVERHEAD = 10.0  # elements that take the time of all else in an iteration
MOST_WORK = 5e7  # iterations times elements of an analysis that is repeated by default: two or three seconds, ten with the repetition


def refinable(mechanism: Mechanism) -> bool:
    """Whether there are elements, all of which can be halved. A link of two particles is one element by definition."""
    elastic = [body for body in mechanism.bodies.values() if counts(body)]
    return bool(elastic) and all(body.model != "two-particle" and FINER * sum(counts(body)) <= MOST_ELEMENTS for body in elastic)


def meshed(mechanism: Mechanism, finer: bool) -> Mechanism | None:
    """The mechanism with twice the elements in each elastic body, or with half of them; None where a number of them is odd."""

    def number(elements: int) -> int:
        return FINER * elements if finer else elements // FINER

    bodies: dict[str, Body] = {}
    for name, body in mechanism.bodies.items():
        bodies[name] = body
        if isinstance(body, Frame):
            bodies[name] = dataclasses.replace(
                body, members=tuple(dataclasses.replace(member, elements=number(member.elements)) for member in body.members)
            )
        elif isinstance(body, Link) and body.element_count:
            bodies[name] = dataclasses.replace(body, elements=number(body.elements))
    odd = any(count % FINER for body in mechanism.bodies.values() for count in counts(body))
    return None if odd and not finer else dataclasses.replace(mechanism, bodies=bodies)


def counts(body: Body) -> list[int]:
    """Elements of each member of a frame, or of an elastic link."""
    if isinstance(body, Frame):
        return [member.elements for member in body.members]
    return [body.elements] if isinstance(body, Link) and body.element_count else []


def iterations(assembly: Assembly) -> float:
    """Iterations that an equilibrium may take: those of slender frames go with the square of the elements in line."""
    least, each = STATIC_ITERATIONS
    bodies = assembly.bodies.values()
    longest = max((len(body.elements) for body in bodies), default=1)
    return min(least + each * longest * longest * len(bodies), float(assembly.mechanism.settings.iterations))


def worth(assembly: Assembly) -> bool:
    """Whether an analysis is short enough to be repeated by default."""
    return assembly.choice.outputs * iterations(assembly) * (len(assembly.topology.frame_nodes) + OVERHEAD) <= MOST_WORK


def equilibria_again(record: Record, finer: bool, progress: Callable[[Progress], None] | None = None) -> Record | None:
    """The equilibria of a static analysis with twice or half the elements; None where they were not all found, or there is no such mesh."""
    mechanism = meshed(record.assembly.mechanism, finer) if record.status == Status.COMPLETE else None
    if mechanism is None:
        return None
    try:
        assembly = assemble(mechanism)
    except (VfifeError, ValueError):
        return None

    def tell(now: Progress) -> None:
        if progress is not None:
            progress(dataclasses.replace(now, text=f"{'twice' if finer else 'half'} the elements, {now.text}"))

    found = equilibrium(assembly, loop=record.loop, progress=tell)
    return found if found.status == Status.COMPLETE else None
