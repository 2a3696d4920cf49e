"""The numbers of a model by their paths."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

APART = ("run",)  # tables that say how it is calculated, not what it is


def numbers(text: str) -> Iterator[tuple[str, float]]:
    """Path and value (SI) of every number in a model's text as :func:`~vfife.modelfile.dump` writes it; counts and what is a text are none."""
    for key, value in tomllib.loads(text).items():
        if key not in APART:
            yield from _within(key, value)


def _within(path: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, float):
        yield path, value
    elif isinstance(value, (dict, list)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _within(f"{path}.{key}", inner)
