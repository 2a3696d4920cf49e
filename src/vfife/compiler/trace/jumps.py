"""Jumps of forces in the derivative of a step: the saltation matrix of contacts and stops.

A step is differentiated as it was taken, in which a contact begins at the same step for every neighbouring
motion. If the force is zero where a contact begins, nothing is missing. If it jumps (a damper that acts at
once: ``kelvin-voigt``, a stop with damping), a neighbour that touches earlier feels the jump earlier. Its
impulse decides whether the two motions approach each other, and a step without it does not contain it.

In the full step, where contacts begin and end, the kernels pass each such force through a function that
returns it unchanged. Here these functions record the operation :data:`~vfife.compiler.trace.tape.JUMP`: its
value is the first operand, and its slope is that of the first plus the second operand times the slope of the
third. Laws whose force does not jump have zero, or 1e-300 times a parameter, as second operand.

Loops that follow a small difference use it, and derivatives by the numbers of a model where a force jumps
(``solvers/tangents.py``). Only velocities get the impulse (:func:`~.tangent.tangent_with_jumps`): forces,
accelerations and their extremes would contain a jump divided by the step.
"""

from __future__ import annotations

from typing import Any

from ...kernels import jumps, spring
from ...kernels.arrays import CONTACT, CONTACT_INDEX
from .tape import JUMP, Symbol, Tape
from .traceable import Traceable


def give_jumps(traceable: Traceable, tape: Tape, full: bool) -> None:
    """Let forces that jump record their jumps, in a ``full`` step; a fast step is not taken where a stop ends
    to push.
    """

    def with_slope(force: Any, weight: Any, place: Any) -> Any:
        moves = isinstance(weight, Symbol) or weight != 0.0
        return tape.emit(JUMP, force, weight, place) if moves and isinstance(place, Symbol) else force

    def of_contact(elastic: Any, S: Any, I: Any, r: int, depth: Any, stretch: Any, central: Any) -> Any:
        last_slowness = tape.load(I[r + CONTACT_INDEX.row] + CONTACT.slowness)
        weight = traceable(jumps.contact_jump)(S, I, r, depth, last_slowness, stretch, central)
        return with_slope(elastic, weight, depth)

    def of_stop(moment: Any, S: Any, g: int, x: Any, rate: Any, inverse: Any, central: Any) -> Any:
        force = traceable(spring.stop_with_jump)(moment, S, g, x, rate, inverse, central)
        share = traceable(jumps.stop_share)(S, g, x, moment, rate, central)
        if not full:
            tape.rare.append(share != 0.0)
            return force
        force = with_slope(force, traceable(jumps.stop_jump)(S, g, x, inverse, central), x)
        return with_slope(force, share, moment)

    traceable.given |= {"stop_with_jump": of_stop}
    if full:
        traceable.given |= {"contact_with_jump": of_contact}
