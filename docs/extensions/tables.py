"""Tables in Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable


def cell(text: str) -> str:
    """A text in a cell, where signs that mean something in Markdown are signs."""
    parts = re.split(r"(`[^`]+`)", text)
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<|\\$\[\]#])", r"\\\1", part) for part in parts
    ).replace("\n", " ")


def grid(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table; cells are Markdown."""
    head = list(head)
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *map(list, rows)))
