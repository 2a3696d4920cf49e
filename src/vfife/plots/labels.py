"""Names of runs in a legend: what they are called, and the parameters in which their models differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import Fault
from ..model.mechanism import Mechanism
from ..modelfile.parameter import Parameter
from ..modelfile.write import tables_of
from ..results.run_data import RunData
from .style import PREFIXED, scale_of

NAMED = 2  # differences of a run that its name in the legend mentions
MOST_DIFFERENCES = 6  # differences from which on the models are different ones
SHORT = 3  # numbers of a list that a name in the legend has in full
SECTIONS = ("name", "run", "start")  # of a model that say nothing of the machine


def run_labels(runs: Sequence[RunData], names: Sequence[str] = ()) -> list[str]:
    """Return a label for each run: its name, if there are ``names`` or those of the mechanisms differ, and
    the parameters in which the models differ.
    """
    mechanisms = [run.record.assembly.mechanism for run in runs]
    if not names and len({mechanism.name for mechanism in mechanisms}) == len(runs):
        names = [mechanism.name for mechanism in mechanisms]
    changes = differences(mechanisms)
    changes = [] if names and len(changes) > MOST_DIFFERENCES else changes
    labels = []
    for k in range(len(runs)):
        parts = [f"{words} {values[k]}".rstrip() for words, values in changes[:NAMED]]
        text = ", ".join([*parts, "…"] if len(changes) > NAMED else parts)
        labels.append(": ".join(part for part in (names[k] if names else "", text) if part))
    return (
        labels
        if len(set(labels)) == len(runs)
        else [f"{label} (run {k})".strip() for k, label in enumerate(labels, 1)]
    )


def differences(mechanisms: Sequence[Mechanism]) -> list[tuple[str, list[str]]]:
    """Return the parameters in which mechanisms differ, and the value of each: those that several joints or
    bodies share alike under one name.
    """
    models = [dict(_flat(tables_of(mechanism))) for mechanism in mechanisms]
    groups: dict[tuple[Any, ...], list[str]] = {}
    for path in dict.fromkeys(path for values in models for path in values):
        values = [model.get(path) for model in models]
        if path.partition(".")[0] not in SECTIONS and any(value != values[0] for value in values):
            owner = next(
                mechanism for mechanism, value in zip(mechanisms, values, strict=True) if value is not None
            )
            words = _words(owner, path, values)
            groups.setdefault((path.rpartition(".")[2], *words), []).append(path)
    return [
        (paths[0].partition(".")[2] or paths[0] if len(paths) == 1 else key, values)
        for (key, *values), paths in groups.items()
    ]


def _flat(tables: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in tables.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{path}{name}.")
        else:
            yield f"{path}{name}", value


def _words(mechanism: Mechanism, path: str, values: Sequence[Any]) -> list[str]:
    """Return the values of a parameter in a unit that reads well; ``mechanism`` has the parameter."""
    sizes = [abs(value) for value in values if isinstance(value, int | float)]
    try:
        unit = Parameter(mechanism, path).unit
    except Fault:
        unit = "1"
    factor = 1.0
    if unit == "rad/s":
        factor, unit = 30.0 / np.pi, "rpm"
    elif unit == "rad":
        factor, unit = 180.0 / np.pi, "°"
    elif sizes and (unit == "m" or unit in PREFIXED):
        factor, unit = scale_of(max(sizes), unit)
    return [_word(value, factor, "" if unit == "1" else f" {unit}") for value in values]


def _word(value: Any, factor: float, unit: str) -> str:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return f"{factor * value:.4g}{unit}"
    if (
        isinstance(value, list)
        and len(value) <= SHORT
        and all(isinstance(number, int | float) for number in value)
    ):
        return f"({', '.join(f'{factor * number:.4g}' for number in value)}){unit}"
    return "without" if value is None else str(value) if isinstance(value, str | bool) else "changed"
