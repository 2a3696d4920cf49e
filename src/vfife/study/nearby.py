"""A model with one other number each, assembled side by side: the neighbours of a run in every direction that somebody asks for."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..assembly.assembled import Assembly
from ..assembly.together import Together
from ..fields.members import Differing, members
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from ..modelfile import loads
from .batches import TROUBLE, unforeseen
from .columns import Column, Unfit, column, together, varied

Change = tuple[str, float]  # a path, and the number (SI) there
FEW = 2


def nearby(text: str, known: Mapping[str, float], changes: Sequence[Change], base: Assembly) -> list[Assembly | None]:
    """The model of a text with each of ``changes``, assembled for as many steps as ``base``, each the same part of a turn.

    ``known`` has the numbers (SI) of the text by their paths.

    None stands for one that has to be assembled by itself: see :mod:`vfife.assembly.together`. What limits the step of each is not looked at.
    """
    raw, mechanism = tomllib.loads(text), loads(text)
    columns: dict[str, Column | None] = {}
    for path, _ in changes:
        if path not in columns:
            try:
                columns[path] = column(mechanism, raw, path)
            except Unfit:
                columns[path] = None
    found: list[Assembly | None] = [None] * len(changes)
    run: dict[str, Any] = {"outputs": base.mechanism.settings.outputs, "force_step": True}
    choice, met = base.choice, {}  # type: ignore[var-annotated]
    run |= {"duration": choice.step * choice.steps} if choice.turn is None else {"turns": choice.steps * choice.step / choice.turn}
    kit = Together(base, None, met, **run)
    contacts = dict.fromkeys(base.contacts, 1.0)

    def one_of(which: Sequence[int], k: int) -> Mechanism:
        path, value = changes[which[k]]
        where = columns[path]
        return mechanism if where is None else varied(mechanism, [(where, value)])

    def made(which: Sequence[int]) -> None:
        if len(which) < FEW:
            return
        try:
            paths = list(dict.fromkeys(changes[k][0] for k in which))
            values = np.array([[changes[k][1] if changes[k][0] == path else known[path] for path in paths] for k in which])
            model = together(mechanism, [one for path in paths if (one := columns[path]) is not None], values)[0]
            turn = turn_of(model)
            scale = 1.0 if turn is None or choice.turn is None else turn / choice.turn
            steps = members(np.broadcast_to(choice.step * np.asarray(scale), (len(which),)))
            for k, assembly in zip(which, kit.assembled(model, len(which), contacts, steps, partial(one_of, which)), strict=True):
                found[k] = assembly
            return
        except (Differing, *TROUBLE):
            pass
        except Exception as error:  # each made by itself is right whatever is wrong here
            unforeseen(error)
        middle = len(which) // 2
        made(which[:middle])
        made(which[middle:])

    made([k for k, (path, value) in enumerate(changes) if (one := columns[path]) is not None and one.held.allows(value)])
    return found
