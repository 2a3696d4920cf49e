"""Sizes of one noun that do not go together, as it says itself."""

from __future__ import annotations

from typing import NamedTuple


class Conflict(NamedTuple):
    """What is wrong and what to do; ``key`` is the field ("" the whole noun), ``limit`` what is allowed."""

    key: str
    what: str
    remedy: str
    limit: str = ""
