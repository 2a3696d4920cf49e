"""Fits of ISO 286-1: standard tolerance grades, positions of tolerance zones, and the clearance of a hole and
a shaft.

The tables are the normative ones of ISO 286-1 for sizes up to 500 mm, in µm. The formulae from which they
were once rounded (i = 0.45 D^(1/3) + 0.001 D and so on, D the geometric mean of a step) give some values
differently, 14 µm instead of 15 for IT7 at 8 mm; the tests compare both.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass

from ...errors import Fault

LEAST_SIZE, LARGEST_SIZE = 1e-3, 0.5  # m, the sizes for which the tables are meant
Row = tuple[float, ...]


def numbers(text: str) -> Row:
    """Return the numbers of a line."""
    return tuple(map(float, text.split()))


def by_letter(text: str) -> dict[str, Row]:
    """Return the numbers of each line by its first letter."""
    return {line.split()[0]: numbers(line.partition(" ")[2]) for line in text.strip().splitlines()}


STEPS = numbers("3 6 10 18 30 50 80 120 180 250 315 400 500")  # mm, each up to and including
FINE_STEPS = numbers("3 6 10 14 18 24 30 40 50 65 80 100 120 140 160 180 200 225 250 280 315 355 400 450 500")
# µm, IT1 to IT11 of each step, a line each; IT12 to IT18 are ten times the grade five before.
GRADES = tuple(map(numbers, """\
0.8 1.2 2 3 4 6 10 14 25 40 60
1 1.5 2.5 4 5 8 12 18 30 48 75
1 1.5 2.5 4 6 9 15 22 36 58 90
1.2 2 3 5 8 11 18 27 43 70 110
1.5 2.5 4 6 9 13 21 33 52 84 130
1.5 2.5 4 7 11 16 25 39 62 100 160
2 3 5 8 13 19 30 46 74 120 190
2.5 4 6 10 15 22 35 54 87 140 220
3.5 5 8 12 18 25 40 63 100 160 250
4.5 7 10 14 20 29 46 72 115 185 290
6 8 12 16 23 32 52 81 130 210 320
7 9 13 18 25 36 57 89 140 230 360
8 10 15 20 27 40 63 97 155 250 400
""".splitlines()))  # fmt: skip
# µm below the nominal size: the upper deviation of a shaft, and of a hole the lower one with its sign turned.
CLEAR = by_letter("""
d  20 30 40 50 65 80 100 120 145 170 190 210 230
e  14 20 25 32 40 50 60 72 85 100 110 125 135
f  6 10 13 16 20 25 30 36 43 50 56 62 68
g  2 4 5 6 7 9 10 12 14 15 17 18 20
h  0 0 0 0 0 0 0 0 0 0 0 0 0
""")
WIDE = by_letter("""
a  270 270 280 290 290 300 300 310 320 340 360 380 410 460 520 580 660 740 820 920 1050 1200 1350 1500 1650
b  140 140 150 150 150 160 160 170 180 190 200 220 240 260 280 310 340 380 420 480 540 600 680 760 840
c  60 70 80 95 95 110 110 120 130 140 150 170 180 200 210 230 240 260 280 300 330 360 400 440 480
""")
# µm above it: the lower deviation of a shaft; k of IT4 to IT7 only, else zero.
TIGHT = by_letter("""
k  0 1 1 1 2 2 2 3 3 4 4 4 5
m  2 4 6 7 8 9 11 13 15 17 20 21 23
n  4 8 10 12 15 17 20 23 27 31 34 37 40
p  6 12 15 18 22 26 32 37 43 50 56 62 68
""")
LETTERS = ("a", "b", "c", "d", "e", "f", "g", "h", "js", "k", "m", "n", "p")
ZONE = re.compile(r"([A-Za-z]{1,2})([0-9]{1,2})")


@dataclass(frozen=True)
class Zone:
    """A tolerance zone such as f7 at a size, with its deviations ``low`` and ``high`` (m)."""

    name: str
    low: float
    high: float

    @property
    def width(self) -> float:
        """The tolerance in m."""
        return self.high - self.low


@dataclass(frozen=True)
class Fit:
    """A hole and a shaft of one nominal ``diameter`` (m)."""

    hole: Zone
    shaft: Zone
    diameter: float

    @property
    def name(self) -> str:
        """The fit as written on drawings."""
        return f"{self.hole.name}/{self.shaft.name}"

    @property
    def least(self) -> float:
        """Least difference of the diameters in m; negative is interference."""
        return self.hole.low - self.shaft.high

    @property
    def most(self) -> float:
        """Greatest difference of the diameters in m."""
        return self.hole.high - self.shaft.low


def fit(text: str, diameter: float) -> Fit:
    """Return the fit of a text such as "H8/f7" at a nominal diameter (m).

    Raises Fault for a fit that neither ISO 286-1 nor these tables have.

    >>> one = fit("H8/f7", 0.02)
    >>> round(one.least * 1e6, 3), round(one.most * 1e6, 3)
    (20.0, 74.0)
    """
    parts = [part.strip() for part in text.split("/")]
    if len(parts) != 2 or not parts[0][:1].isupper() or not parts[1][:1].islower():
        limit = "the zone of a hole, a slash, the zone of a shaft"
        remedy = 'write it as in "H8/f7", the hole first'
        raise Fault("", "no fit", f'"{text}"', limit, remedy)
    return Fit(zone(parts[0], diameter), zone(parts[1], diameter), diameter)


def tolerance(grade: int, diameter: float) -> float:
    """Return the standard tolerance IT1 to IT18 (m) of a size (m). Raises Fault."""
    return in_micrometres(grade, step_of(diameter)) / 1e6


def zone(name: str, diameter: float) -> Zone:
    """Return the zone of a hole (a capital, as H8) or of a shaft (as f7) at a diameter (m). Raises Fault."""
    step = step_of(diameter)
    match = ZONE.fullmatch(name)
    letter = match[1].lower() if match else ""
    if match is None or letter not in LETTERS or match[1] not in (letter, letter.upper()):
        limit = f"{', '.join(LETTERS)} of shafts, in capitals of holes, with a grade"
        raise Fault("", "a zone that the tables do not have", f'"{name}"', limit, 'as in "H8"')
    grade = int(match[2])
    width = in_micrometres(grade, step)
    if letter == "js":
        return Zone(name, -0.5 * width / 1e6, 0.5 * width / 1e6)
    has_clearance = letter in CLEAR or letter in WIDE
    if match[1].isupper():
        low = (
            clear(letter, diameter)
            if has_clearance
            else upper_of_tight_hole(letter, grade, step, name) - width
        )
    else:
        low = -clear(letter, diameter) - width if has_clearance else tight(letter, grade, step)
    return Zone(name, low / 1e6, (low + width) / 1e6)


def step_of(diameter: float, steps: Row = STEPS) -> int:
    """Return the index of the step of a diameter (m). Raises Fault outside 1 to 500 mm."""
    if not LEAST_SIZE <= diameter <= LARGEST_SIZE:
        message, remedy = "a size beyond the tables of fits", "correct the diameter or its unit"
        raise Fault("", message, f"{1e3 * diameter:g} mm", "1 mm to 500 mm", remedy)
    return bisect_left(steps, round(1e3 * diameter, 9))


def in_micrometres(grade: int, step: int) -> float:
    """Return the tolerance of a grade in a step (µm). Raises Fault."""
    if not 1 <= grade <= 18:
        remedy = "choose one of these; running fits have 5 to 11"
        raise Fault("", "an unknown grade", f"IT{grade}", "IT1 to IT18", remedy)
    return GRADES[step][grade - 1] if grade <= 11 else 10.0 * in_micrometres(grade - 5, step)


def clear(letter: str, diameter: float) -> float:
    """Return how far below the nominal size a shaft of this letter begins (µm)."""
    return WIDE[letter][step_of(diameter, FINE_STEPS)] if letter in WIDE else CLEAR[letter][step_of(diameter)]


def tight(letter: str, grade: int, step: int) -> float:
    """Return the lower deviation of a shaft k to p (µm)."""
    return 0.0 if letter == "k" and not 4 <= grade <= 7 else TIGHT[letter][step]


def upper_of_tight_hole(letter: str, grade: int, step: int, name: str) -> float:
    """Return the upper deviation of a hole K to P (µm).

    It is that of the shaft with its sign turned; up to IT8 (P: IT7) the delta rule is added, by which a hole
    of a grade and a shaft of the next finer one have the interference of the two with exchanged letters.
    """
    if letter == "k" and grade > 8 and step:
        message, remedy = (
            "a zone that the standard does not have above 3 mm",
            "choose K8, or JS of this grade",
        )
        raise Fault("", message, f'"{name}"', "K up to grade 8", remedy)
    if letter == "n" and grade > 8 and step:
        return 0.0
    if letter == "m" and grade == 6 and STEPS[step] == 315:
        return -9.0  # an exception that the standard makes
    delta = 0.0
    if step and 3 <= grade <= (7 if letter == "p" else 8):
        delta = in_micrometres(grade, step) - in_micrometres(grade - 1, step)
    return delta - TIGHT[letter][step]
