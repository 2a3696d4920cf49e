"""Sensitivities beside finite differences with a step ten times smaller, each model read, changed and
assembled by itself.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Any

import vfife
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.errors import VfifeError
from vfife.measures.catalogue import PEAKS, over_turn
from vfife.measures.turns import last_turn
from vfife.model.functions import turn_of
from vfife.modelfile import dump, loads
from vfife.modelfile.parameter import numbers
from vfife.solvers.companions import measured_rows
from vfife.solvers.ensemble import measures_of

FINER = 10.0
SHARES = 0.01, -0.01, 0.001, -0.001
# Per cent of a measure for one per cent of a number: what differences of 0.1 % leave of rounding, and what no
# table shows.
ROUNDING = 1e-4


@dataclass
class Outside:
    """How many derivatives and changes were shown without a question mark, how many with one, and which
    did not hold the truth.
    """

    derivatives: int = 0
    changes: int = 0
    unknown: int = 0
    wrong: list[str] = field(default_factory=list)

    @property
    def shown(self) -> int:
        """Without a question mark."""
        return self.derivatives + self.changes


def outside(mechanism: vfife.Mechanism, count: int, *, seed: int = 0, **length: Any) -> Outside:
    """Compare what is shown by ``count`` numbers, drawn from those of a model, with the truth."""
    text = dump(mechanism)
    known = {path: value for path, value in numbers(mechanism).items() if value}
    paths = random.Random(seed).sample(list(known), min(count, len(known)))
    found = vfife.sensitivity(mechanism, None, paths, **length)
    base = vfife.simulate(mechanism, reference=False, **length).record.assembly
    truth = _Truth(text, base, [one.path for one in found.derivatives], known)
    said = Outside()
    for measure in found.measures:
        for one in found.derivatives:
            if measure not in one.values:
                continue
            effect = found.effect(measure, one.path)
            if effect.kind == "unknown":
                said.unknown += 1
                continue
            if effect.kind == "derivative":
                said.derivatives += 1
                true = [truth.central(measure, one.path, share) for share in (0.01, 0.001)]
            else:
                said.changes += 1
                true = [truth.central(measure, one.path, 0.01)]
            scale = one.value / found.measures[measure]
            values = [slope * scale for slope in true if slope is not None]
            said.wrong += [
                f"{measure} by {one.path}: {effect.kind} {effect.value:.4g} ({effect.low:.4g} to "
                f"{effect.high:.4g}), truth {value:.4g}"
                for value in values
                if not effect.low - ROUNDING <= value <= effect.high + ROUNDING
            ]
    return said


class _Truth:
    """Measures of a model and of its variants with a finer step."""

    def __init__(self, text: str, base: Assembly, paths: list[str], known: dict[str, float]) -> None:
        self.known, self.turn = known, turn_of(base.mechanism)
        own = self._assembled(text, base, None)
        variants: dict[tuple[str, float], Assembly] = {}
        for path in paths:
            for share in SHARES:
                try:
                    variants[path, share] = self._assembled(
                        text, base, (path, known[path] + share * abs(known[path]))
                    )
                except VfifeError:  # beyond what the number may be
                    continue
        rows = measured_rows(own)
        found = measures_of(
            [
                (one, rows, lambda record: over_turn(record, last_turn(record), PEAKS))
                for one in (own, *variants.values())
            ]
        )
        self.own, self.values = found[0] or {}, dict(zip(variants, found[1:], strict=True))

    def _assembled(self, text: str, base: Assembly, change: tuple[str, float] | None) -> Assembly:
        mechanism, choice = loads(text, set=[] if change is None else [change]), base.choice
        turn = turn_of(mechanism)
        scale = turn / choice.turn if turn and choice.turn else 1.0
        length = (
            {"turns": choice.step * choice.steps / choice.turn}
            if choice.turn
            else {"duration": choice.step * choice.steps}
        )
        return assemble(
            mechanism,
            choice.step * scale / FINER,
            outputs=mechanism.settings.outputs,
            force_step=True,
            **length,
        )

    def central(self, measure: str, path: str, share: float) -> float | None:
        """The central difference quotient, or that to one side where the number may go to one side only."""
        ends = {sign: (self.values.get((path, sign * share)) or {}).get(measure) for sign in (1.0, -1.0)}
        own, size = self.own.get(measure), share * abs(self.known[path])
        if own is None or all(end is None for end in ends.values()):
            return None
        up, down = ends[1.0], ends[-1.0]
        if up is None or down is None:
            return (up - own) / size if up is not None else (own - (down or 0.0)) / size
        return (up - down) / (2.0 * size)
