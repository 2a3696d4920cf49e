"""Compiled code: cache, loading, the loops and streams that call it."""

from __future__ import annotations

from collections.abc import Callable

# Listeners, called before something is compiled; here, because a progress line needs no compiler.
MISSED: list[Callable[[], None]] = []
