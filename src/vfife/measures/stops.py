"""Contacts at rotational stops, as the outputs of a run show them.

A stop is a spring, and the step keeps no count of its onsets. A contact that begins and ends between two
outputs is therefore not seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..kernels.topology import STOP
from ..solvers.record import Record


def stop_contacts(record: Record) -> dict[str, int]:
    """Return how many contacts began at each stop of a dynamic run, by name: the outputs beyond a limit whose
    predecessor is not beyond the same limit. Empty without stops, or without the angles of bodies.
    """
    assembly, counts = record.assembly, dict[str, int]()
    topology = assembly.topology
    if record.static or STOP not in topology.spring_kind or not record.keeps("particle_theta"):
        return counts
    angles = record.block("particle_theta")
    for k, name in enumerate(assembly.springs):
        if topology.spring_kind[k] == STOP:
            stop: Any = assembly.mechanism.springs[name]
            angle = angles[:, topology.spring_second[k]] - angles[:, topology.spring_first[k]]
            side = np.where(angle < stop.low, -1, np.where(angle > stop.high, 1, 0))
            counts[name] = int(np.count_nonzero((side[1:] != side[:-1]) & (side[1:] != 0)))
    return counts


def stop_sentence(stops: Mapping[str, int]) -> str:
    """Return a sentence that contacts at stops are no impacts, with their number at the outputs; "" without
    stops.
    """
    if not stops:
        return ""
    return (
        f"Contacts at stops ({', '.join(stops)}) are not listed as impacts; the outputs show"
        f" {sum(stops.values()):,} of them, and miss those between two outputs."
    )
