"""Model files for readers: numbers rounded, long lists and tables as their first and last lines."""

from __future__ import annotations

import re

LONG_NUMBER = re.compile(r"-?\d+\.\d{6,}(?:e[-+]?\d+)?")
# A list of numbers with more than this many is shown by its ends.
MOST_NUMBERS = 24
LIST = re.compile(r"\[(-?[\d.][^\[\]\"]*)\]")
ENDS = 4  # numbers at each end of a long list
MOST_LINES = 40  # of a table that is shown as a whole
FIRST, LAST = 12, 4  # lines of a longer one


def rounded(text: str) -> str:
    """Round the numbers of a text to six digits."""
    return LONG_NUMBER.sub(lambda number: f"{float(number[0]):.6g}", text)


def with_short_lists(text: str) -> str:
    """Return a text in which each list of more than :data:`MOST_NUMBERS` numbers has its ends and the count
    of the others.
    """
    return LIST.sub(_shortened, text)


def _shortened(match: re.Match[str]) -> str:
    numbers = [number.strip() for number in match[1].split(",") if number.strip()]
    if len(numbers) <= MOST_NUMBERS:
        return match[0]
    left = f"… {len(numbers) - 2 * ENDS:,} more …"
    return f"[{', '.join([*numbers[:ENDS], left, *numbers[-ENDS:]])}]"


def table_excerpt(text: str) -> tuple[str, str]:
    """Return a table in text with the middle of a long one left out, and a sentence that says so ("" of a
    short one).
    """
    lines = text.splitlines()
    left = len(lines) - FIRST - LAST
    if len(lines) <= MOST_LINES:
        return text, ""
    shown = [*lines[:FIRST], f"… {left:,} lines more …", *lines[-LAST:]]
    return "\n".join(shown), f"{len(lines):,} lines, of which {FIRST + LAST} are shown."
