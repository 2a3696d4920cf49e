"""The models to both sides of a number: what the derivative of a run by it begins with."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from ..assembly.assemble import assemble, refitted
from ..assembly.assembled import Assembly
from ..errors import VfifeError
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import loads
from ..modelfile.numbered import with_number
from ..solvers.tangents import Neighbours
from .nearby import Change, nearby

NEAR = 1e-5  # of a number, on both sides, at which its neighbours are assembled
NONE: Mapping[Change, Assembly | None] = {}


@dataclass(frozen=True)
class Way:
    """A number of the model, its value (SI) and the models to both sides."""

    path: str
    value: float
    near: Neighbours


def neighbours(text: str, chosen: Mapping[str, float], assembly: Assembly) -> tuple[list[Way], dict[str, str]]:
    """The models to both sides of each number; and of those that cannot be assembled, why."""
    ways, refused = [], {path: "zero, of which there is no small part" for path, value in chosen.items() if value == 0.0}
    changes = [(path, value + sign * NEAR * abs(value)) for path, value in chosen.items() if path not in refused for sign in (1.0, -1.0)]
    made = dict(zip(changes, nearby(text, chosen, changes, assembly), strict=True))
    for path, value in chosen.items():
        if path in refused:
            continue
        try:
            ways.append(Way(path, value, beside(text, path, value, assembly, made)))
        except VfifeError as error:
            refused[path] = str(error).strip().splitlines()[-1].strip()
    return ways, refused


def beside(
    text: str, path: str, value: float, assembly: Assembly, made: Mapping[Change, Assembly | None] = NONE, *, ideal: bool = False
) -> Neighbours:
    """A number a little larger and a little smaller; where only one of them is a mechanism, that and the model itself.

    ``made`` are known already. ``ideal``: of the mechanism without its play, which ``assembly`` is then of, while ``text`` has it.
    """
    models: list[tuple[float, Assembly]] = []
    trouble: VfifeError | None = None
    for sign in (1.0, -1.0):
        change = path, value + sign * NEAR * abs(value)
        try:
            models.append((sign, made.get(change) or placed(text, path, value, change[1], assembly, ideal=ideal)))
        except VfifeError as error:
            trouble = error
    if trouble is not None and not models:
        raise trouble
    if trouble is not None:
        models.append((0.0, assembly))
        models.sort(key=lambda one: -one[0])
    (above, up), (below, down) = models
    return Neighbours(up, down, (above - below) * NEAR * abs(value))


def placed(text: str, path: str, was: float, value: float, assembly: Assembly, *, ideal: bool = False) -> Assembly:
    """The model with another number, assembled for as many steps, each the same part of a turn."""
    mechanism = with_number(assembly.mechanism, path, was, value)
    if mechanism is None:
        mechanism = loads(text, set=[(path, value)])
        mechanism = mechanism.ideal() if ideal else mechanism
    elif path.startswith("joint.") and path.split(".")[1] in assembly.contacts:
        with suppress(ValueError):  # numbers of play reach the rows of their contact alone, in most mechanisms
            if all(name in mechanism.contacts for name in assembly.contacts):  # a block in a guide has four contacts with names of their own
                return refitted(assembly, {name: mechanism.contacts[name] for name in assembly.contacts})
    return alike(mechanism, assembly)


def alike(mechanism: Mechanism, assembly: Assembly) -> Assembly:
    """A mechanism assembled for as many steps as another one, each the same part of a turn."""
    choice, turn = assembly.choice, turn_of(mechanism)
    scale = turn / choice.turn if turn is not None and choice.turn is not None else 1.0
    length: dict[str, Any] = {"duration": choice.step * scale * choice.steps} if choice.turn is None else {
        "turns": choice.steps * choice.step / choice.turn
    }  # fmt: skip
    outputs = assembly.mechanism.settings.outputs
    found = assemble(mechanism, choice.step * scale, outputs=outputs, force_step=True, **length)
    return replace(found, layout=assembly.layout) if found.topology == assembly.topology else found
