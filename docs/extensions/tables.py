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
    """A table; cells are Markdown. A bar in a cell is no border, in code either."""
    head = list(head)
    lines = [[re.sub(r"(?<!\\)\|", r"\\|", one) for one in line] for line in (head, *map(list, rows))]
    lines.insert(1, ["---"] * len(head))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
