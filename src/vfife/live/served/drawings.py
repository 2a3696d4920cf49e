"""Drawings of the gallery, made when they are looked at and kept while it lasts."""

from __future__ import annotations

from functools import lru_cache

from ... import gallery
from ...plots import at_start
from ...plots.notebook import lines


@lru_cache(maxsize=64)
def drawing(name: str) -> bytes:
    """A mechanism of the gallery at its start, as SVG; for one thread at a time. Raises LookupError for a name that it has not."""
    if name not in gallery.__all__:
        raise LookupError(name)
    return lines(at_start(getattr(gallery, name)()), name)
