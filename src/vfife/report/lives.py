"""Lives in words: turns and hours with two digits, and the range by the scatter of wear coefficients."""

from __future__ import annotations

from ..numerics.outward import DOWN, NEAREST, UP, exponent, rounded

LARGE = ((1e9, "thousand million"), (1e6, "million"), (1.0, ""))


def life_words(turns: float, turn: float | None, scatter: float | None = None) -> str:
    """Return a life, as in "about 14 million turns (80 h at 3,000 rpm)", with its range.

    ``turn`` (s) is the duration of a turn; None where turns have none. Depths grow with coefficient times
    turns, so that all lives are divided by the factor by which the coefficients are larger: ``scatter`` to
    either side, None where it is unknown.
    """
    (number,), word = large_numbers(turns)
    text = f"about {number}{f' {word}' if word else ''} turns"
    if turn:
        hours = turns * turn / 3600.0
        text += f" ({rounded(hours, 1 - exponent(hours)):,.{max(0, 1 - exponent(hours))}f} h"
        text += f" at {float(f'{60.0 / turn:.3g}'):,g} rpm)"
    if scatter is None:
        return text
    (low, high), word = large_numbers(turns / scatter, turns * scatter)
    return f"{text}; {low} to {high}{f' {word}' if word else ''} with the scatter of the wear coefficient"


def large_numbers(*values: float) -> tuple[list[str], str]:
    """Return numbers with two digits and the word of the largest power of 1,000 that suits the first of them;
    the ends of a range, rounded outwards.
    """
    factor, word = next(one for one in LARGE if values[-1] >= one[0] or one[0] == 1.0)
    ways = (DOWN, UP) if len(values) > 1 else (NEAREST,)
    shown = (
        rounded(value, 1 - exponent(value), way) / factor for value, way in zip(values, ways, strict=True)
    )
    return [f"{float(f'{value:.6g}'):,g}" for value in shown], word
