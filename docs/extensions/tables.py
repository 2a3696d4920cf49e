"""Tables in Markdown, and lists that a checked-in page holds between two comments."""

from __future__ import annotations

import re
from collections.abc import Iterable

LIST = re.compile(r"(<!-- list: [^\n]*-->\n\n).*?(\n\n<!-- end of list -->)", re.S)


def with_lists(page: str, *lists: str) -> str:
    """Return a page with these texts between the comments of its lists, in their order. Raises ValueError for
    another number of lists.
    """
    texts, count = iter(lists), len(LIST.findall(page))
    if count != len(lists):
        raise ValueError(
            f"{count} lists between <!-- list: ... --> and <!-- end of list -->, not {len(lists)}"
        )
    return LIST.sub(lambda match: f"{match[1]}{next(texts)}{match[2]}", page)


def framed(page: str) -> str:
    """Return a page whose tables of keys and options stand upright on a phone: each in a container."""
    return re.sub(
        r"^\| (?:key|argument or option) \|.*\n(?:\|.*(?:\n|$))+",
        lambda match: f"::::{{container}} keys\n{match[0].rstrip()}\n::::\n",
        page,
        flags=re.M,
    )


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
