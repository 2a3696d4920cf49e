"""Contacts at rotational stops, as the outputs of a run show them.

A stop is a spring. The state has no count of its contacts, as it has of those in joints. A contact that
begins and ends between two outputs is therefore not seen, and the answer states the interval of the outputs.
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


def output_interval(record: Record) -> float:
    """Return the interval (s) of the outputs of a run."""
    choice = record.assembly.choice
    return choice.step * choice.outputs_every


def stop_sentence(stops: Mapping[str, int], interval: float | None = None) -> str:
    """Return a sentence that contacts at stops are no impacts, with their number at the outputs and the
    ``interval`` (s) of these if known; "" without stops.
    """
    if not stops:
        return ""
    spacing = "" if interval is None else f", {number(1e3 * interval)} ms apart,"
    return (
        f"Contacts at stops ({', '.join(stops)}) are not listed as impacts; the outputs{spacing} show"
        f" {sum(stops.values()):,} of them, and miss those that begin and end between two outputs: with more"
        " outputs they miss fewer."
    )


def number(value: float) -> str:
    """Return a number with three digits, without an exponent below a million."""
    return f"{value:.3g}" if value < 1e3 else f"{value:,.0f}"
