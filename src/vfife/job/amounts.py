"""Times, sizes and counts as text."""

from __future__ import annotations

import math


def amount_of_bytes(count: float) -> str:
    """Return bytes with a prefix."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{float(f'{count:.3g}'):,g} TB"


def span(seconds: float) -> str:
    """Return a duration as text."""
    if not math.isfinite(seconds):
        return "unknown"
    if seconds < 60.0:
        return f"{seconds:.2g} s" if seconds < 9.5 else f"{seconds:.0f} s"
    minutes, full_seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours >= 100:
        return f"{hours / 24:,.0f} days"
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {full_seconds:02d} s"


def counted(count: int, noun: str) -> str:
    """Return a number of things as text."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"
