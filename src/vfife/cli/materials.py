"""``vfife materials``: the materials that a model may name."""

from __future__ import annotations

from .options import JsonOption
from .terminal import answer


def materials(as_json: JsonOption = False) -> None:
    """Materials that a model may name, with their numbers and where these are from."""
    from ..report import laws

    answer(laws.materials(), as_json)
