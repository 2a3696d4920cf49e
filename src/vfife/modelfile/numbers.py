"""The numbers of a model by their paths."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

from ..laws import MATERIALS

STEEL = "steel"
APART = ("run",)  # tables that say how it is calculated, not what it is


def numbers(text: str) -> Iterator[tuple[str, float]]:
    """Path and value (SI) of every number in a model's text as :func:`~vfife.modelfile.dump` writes it; counts and what is a text are none.

    Those of materials that it names, and of steel, which is what nothing else is said of, are among them.
    """
    raw = tomllib.loads(text)
    for key, value in raw.items():
        if key not in APART:
            yield from _within(key, value)
    for name in sorted({STEEL, *_texts(raw)} & MATERIALS.keys() - raw.get("material", {}).keys()):
        yield from _within(f"material.{name}", vars(MATERIALS[name]))


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from _texts(inner)


def _within(path: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, float):
        yield path, value
    elif isinstance(value, (dict, list)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _within(f"{path}.{key}", inner)
