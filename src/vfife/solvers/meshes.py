"""A static analysis repeated with twice the elements: the difference tells the error of its mesh."""

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
    elastic = [body for body in mechanism.bodies.values() if isinstance(body, Frame) or (isinstance(body, Link) and body.element_count)]
    return bool(elastic) and all(
        FINER * sum(member.elements for member in body.members) <= MOST_ELEMENTS
        if isinstance(body, Frame)
        else body.model == "elastic" and FINER * body.elements <= MOST_ELEMENTS
        for body in elastic
    )


def refined(mechanism: Mechanism) -> Mechanism:
    """The mechanism with twice the elements in each elastic body."""
    return dataclasses.replace(mechanism, bodies={name: _divided(body) for name, body in mechanism.bodies.items()})


def _divided(body: Body) -> Body:
    if isinstance(body, Frame):
        members = tuple(dataclasses.replace(member, elements=FINER * member.elements) for member in body.members)
        return dataclasses.replace(body, members=members)
    if isinstance(body, Link) and body.model == "elastic":
        return dataclasses.replace(body, elements=FINER * body.elements)
    return body


def iterations(assembly: Assembly) -> float:
    """Iterations that an equilibrium may take: those of slender frames go with the square of the elements in line."""
    least, each = STATIC_ITERATIONS
    bodies = assembly.bodies.values()
    longest = max((len(body.elements) for body in bodies), default=1)
    return min(least + each * longest**2 * len(bodies), float(assembly.mechanism.settings.iterations))


def worth(assembly: Assembly) -> bool:
    """Whether an analysis is short enough to be repeated by default."""
    return assembly.choice.outputs * iterations(assembly) * (len(assembly.topology.frame_nodes) + OVERHEAD) <= MOST_WORK


def finer_equilibria(record: Record, progress: Callable[[Progress], None] | None = None) -> Record | None:
    """The equilibria of a static analysis with twice the elements; None where they were not all found, or the finer mesh cannot be assembled."""
    if record.status != Status.COMPLETE:
        return None
    try:
        assembly = assemble(refined(record.assembly.mechanism))
    except (VfifeError, ValueError):
        return None

    def tell(now: Progress) -> None:
        if progress is not None:
            progress(dataclasses.replace(now, text=f"twice the elements, {now.text}"))

    found = equilibrium(assembly, loop=record.loop, progress=tell)
    return found if found.status == Status.COMPLETE else None
