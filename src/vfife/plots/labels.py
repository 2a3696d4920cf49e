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

MOST_DIFFERENCES = 6  # that a legend names; models with more are different ones, if they have names
SHORT = 3  # numbers of a list that a name in the legend has in full
SECTIONS = ("name", "run", "start")  # of a model that say nothing of the machine


def run_labels(runs: Sequence[RunData], names: Sequence[str] = ()) -> list[str]:
    """Return a label for each run: its name, if there are ``names`` or those of the mechanisms differ, and
    the parameters in which the models differ, those of several joints or bodies together: "worn: clearance
    big-end 80 µm, small-end 32 µm; crank.speed 2900 rpm".
    """
    mechanisms = [run.record.assembly.mechanism for run in runs]
    if not names and len({mechanism.name for mechanism in mechanisms}) == len(runs):
        names = [mechanism.name for mechanism in mechanisms]
    changes = differences(mechanisms)
    changes = [] if names and len(changes) > MOST_DIFFERENCES else changes
    labels = []
    for k in range(len(runs)):
        text = "; ".join(_grouped([(words, values[k]) for words, values in changes[:MOST_DIFFERENCES]]))
        text += f"; {left} more" if (left := len(changes) - MOST_DIFFERENCES) > 0 else ""
        labels.append(": ".join(part for part in (names[k] if names else "", text) if part))
    return (
        labels
        if len(set(labels)) == len(runs)
        else [f"{label} (run {k})".strip() for k, label in enumerate(labels, 1)]
    )


def _grouped(values: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield the values of a parameter of several joints or bodies after its name, other ones alone."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for words, value in values:
        owner, _, key = words.rpartition(".")
        groups.setdefault(key, []).append((owner, value))
    for key, entries in groups.items():
        if len(entries) > 1:
            yield f"{key} " + ", ".join(" ".join(filter(None, entry)) for entry in entries)
        else:
            yield " ".join(filter(None, (".".join(filter(None, (entries[0][0], key))), entries[0][1])))


def differences(
    mechanisms: Sequence[Mechanism], left_out: Sequence[str] = SECTIONS
) -> list[tuple[str, list[str]]]:
    """Return the parameters in which mechanisms differ, and the value of each: those that several joints or
    bodies share alike under one name. ``left_out``: sections of a model that do not count.
    """
    models = [dict(_flat(tables_of(mechanism))) for mechanism in mechanisms]
    changes: dict[str, list[Any]] = {}
    sizes: dict[str, float] = {}  # by the last key of a path: values that stand together share a unit
    for path in dict.fromkeys(path for values in models for path in values):
        values = [model.get(path) for model in models]
        if path.partition(".")[0] not in left_out and any(value != values[0] for value in values):
            changes[path], key = values, path.rpartition(".")[2]
            sizes[key] = min(size for size in (_size(values), sizes.get(key, np.inf)) if size > 0.0)
    groups: dict[tuple[Any, ...], list[str]] = {}
    for path, values in changes.items():
        owner = next(
            mechanism for mechanism, value in zip(mechanisms, values, strict=True) if value is not None
        )
        key = path.rpartition(".")[2]
        groups.setdefault((key, *_words(owner, path, values, sizes[key])), []).append(path)
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


def _size(values: Sequence[Any]) -> float:
    """Return the largest size of numbers, 0 if there is none."""
    return max((abs(value) for value in values if isinstance(value, int | float)), default=0.0)


def _words(mechanism: Mechanism, path: str, values: Sequence[Any], size: float) -> list[str]:
    """Return the values of a parameter in a unit that suits a ``size``; ``mechanism`` has the parameter."""
    try:
        unit = Parameter(mechanism, path).unit
    except Fault:
        unit = "1"
    factor = 1.0
    if unit == "rad/s":
        factor, unit = 30.0 / np.pi, "rpm"
    elif unit == "rad":
        factor, unit = 180.0 / np.pi, "°"
    elif np.isfinite(size) and (unit == "m" or unit in PREFIXED):
        factor, unit = scale_of(size, unit)
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
