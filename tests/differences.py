"""Derivatives by the tangent of the step beside central differences of whole runs that take the same steps.

A difference is itself known only as far as two of different width agree: rounding grows with one over the
width, and where an onset falls into another step between the two runs, neither is a derivative of the steps
that the run takes. Where a kink of friction lies in between, both are the mean of two derivatives, which is
seen by the difference of the two sides, in which it does not shrink with the width.
"""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

import vfife
from vfife.assembly.assemble import assemble
from vfife.measures.catalogue import PEAKS, over_turn
from vfife.measures.turns import last_turn
from vfife.modelfile import dump
from vfife.modelfile.parameter import numbers
from vfife.solvers.record import Record
from vfife.solvers.tangents import comparable, tangents
from vfife.solvers.transient import run
from vfife.studies.methods.finite_difference import Direction, Variants
from vfife.studies.methods.rounding import rounding

WIDTHS = 1e-5, 2e-5  # of a number, on both sides
MATTERS = 1e-2  # of the largest elasticity of a measure: smaller ones are compared with that


@dataclass(frozen=True)
class Compared:
    """Of largest values by numbers: how far derivatives and differences lie apart, as a share of them, and
    two differences of each.
    """

    names: list[tuple[str, str]]
    apart: np.ndarray
    unknown: np.ndarray

    @property
    def known(self) -> np.ndarray:
        """How far they lie apart where the differences themselves are known to 1e-4."""
        return self.apart[self.unknown < 1e-4]


def compared(mechanism: vfife.Mechanism, to: tuple[str, ...] = ("*",), **length: Any) -> Compared:
    """Largest values of the last turn by the numbers ``to``; ``length`` and ``step`` as ``assemble`` takes
    them.
    """
    text = dump(mechanism)
    assembly = assemble(mechanism, force_step=True, **length)
    chosen = {
        path: value for path, value in numbers(mechanism).items() if any(fnmatchcase(path, one) for one in to)
    }
    variants = Variants(text, assembly)
    ways = [way for way in variants.directions(chosen)[0] if comparable(assembly, way.neighbours)]

    own = largest(run(assembly))

    def sides(way: Direction, width: float) -> dict[str, np.ndarray]:
        """Differences per unit: over both sides, and of one side less the other."""
        size = width * abs(way.value)
        more, less = (
            largest(run(variants.with_number(way.path, way.value, way.value + sign * size)))
            for sign in (1.0, -1.0)
        )
        return {
            name: (
                np.array([more[name] - less[name], more[name] + less[name] - 2.0 * own[name]]) / (2.0 * size)
            )
            for name in own.keys() & more.keys() & less.keys()
        }

    found: dict[tuple[str, str], np.ndarray] = {}
    for way, pairs in zip(ways, tangents(assembly, [way.neighbours for way in ways]), strict=True):
        up, down = (largest(record) for record in pairs[0])
        near, wide = (sides(way, width) for width in WIDTHS)
        for name in up.keys() & down.keys() & near.keys() & wide.keys():
            slopes = (
                (up[name] - down[name]) / way.neighbours.distance,
                near[name][0],
                wide[name][0],
                2.0 * near[name][1] - wide[name][1],
            )
            found[name, way.path] = np.array(slopes) * way.value / own[name]
    most = {name: max(abs(one[1]) for (other, _), one in found.items() if other == name) for name, _ in found}
    scales = [max(abs(one[1]), MATTERS * most[name], 1e-3) for (name, _), one in found.items()]
    slopes = np.array(list(found.values())).T / scales
    return Compared(
        list(found), abs(slopes[0] - slopes[1]), np.maximum(abs(slopes[1] - slopes[2]), abs(slopes[3]))
    )


def largest(record: Record) -> dict[str, float]:
    """The largest values of the last turn, without those that are rounding beside the largest
    of their unit.
    """
    found = over_turn(record, last_turn(record), PEAKS)
    nothing = rounding(found)
    return {name: value for name, value in found.items() if name not in nothing}
