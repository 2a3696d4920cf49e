"""Quantities with units: a bare number is in SI units, a text has its unit, as in "0.2 mm" or "1500 rpm".

Angle is a dimension of its own, so that 25 Hz is not taken for 25 rad/s.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from .errors import Fault, kind_of, shown

IMPROBABLE = 100.0  # ratio of a bare number to the value that it limits: more is questioned
PREFIXED = {1e3: "k", 1e6: "M", 1e-3: "m", 1e-6: "u"}
# Exponents of m, kg, s and rad.
Exponents = tuple[Fraction, Fraction, Fraction, Fraction]


# Units by the exponents of m, kg, s and rad, with their exact factors to SI; factors of WITH_PI are times pi.
_TABLE: dict[tuple[int, int, int, int], dict[str, str]] = {
    (0, 0, 0, 0): {"1": "1", "%": "1/100"},
    (1, 0, 0, 0): {
        "m": "1",
        "km": "1000",
        "cm": "1/100",
        "mm": "1/1000",
        "um": "1e-6",
        "µm": "1e-6",
        "nm": "1e-9",
        "in": "0.0254",
        "ft": "0.3048",
    },
    (0, 1, 0, 0): {"kg": "1", "g": "1/1000", "t": "1000"},
    (0, 0, 1, 0): {"s": "1", "min": "60", "ms": "1/1000", "us": "1e-6", "µs": "1e-6", "ns": "1e-9"},
    (0, 0, -1, 0): {"Hz": "1", "kHz": "1000"},
    (0, 0, 0, 1): {"rad": "1", "deg": "1/180", "°": "1/180", "rev": "2", "turn": "2"},
    (0, 0, -1, 1): {"rpm": "1/30"},
    (1, 1, -2, 0): {"mN": "1/1000", "N": "1", "kN": "1000", "MN": "1e6"},
    (2, 1, -2, 0): {"J": "1", "Nm": "1"},
    (-1, 1, -2, 0): {"Pa": "1", "kPa": "1000", "MPa": "1e6", "GPa": "1e9", "bar": "1e5"},
}
WITH_PI = ("deg", "°", "rev", "turn", "rpm")
UNITS = {name: (factor, exponents) for exponents, units in _TABLE.items() for name, factor in units.items()}

# What a dimension is called, its SI unit and an example.
DIMENSIONS: tuple[tuple[str, str, str], ...] = (
    ("a number without a unit", "1", "0.9"),
    ("a length", "m", "0.5 mm"),
    ("a mass", "kg", "2 kg"),
    ("a time", "s", "20 ms"),
    ("an angle", "rad", "30 deg"),
    ("an angular velocity", "rad/s", "1500 rpm"),
    ("an angular acceleration", "rad/s^2", "100 rad/s^2"),
    ("a frequency", "1/s", "50 Hz"),
    ("a velocity", "m/s", "10 mm/s"),
    ("an acceleration", "m/s^2", "-9.81 m/s^2"),
    ("a force", "N", "2 kN"),
    ("a moment", "N m", "-5 N m"),
    ("a moment of inertia", "kg m^2", "12 kg mm^2"),
    ("an area", "m^2", "100 mm^2"),
    ("a second moment of area", "m^4", "8e3 mm^4"),
    ("a pressure", "Pa", "207 GPa"),
    ("a density", "kg/m^3", "7800 kg/m^3"),
    ("a mass per length", "kg/m", "7.8 kg/m"),
    ("a stiffness", "N/m", "2 kN/mm"),
    ("a damping coefficient", "N s/m", "5 N s/m"),
    ("a torsional stiffness", "N m/rad", "20 N m/rad"),
    ("a torsional damping", "N m s/rad", "0.1 N m s/rad"),
    ("a generalised stiffness", "N/m^1.5", "6.6e10 N/m^1.5"),
    ("a stiffness per unit of normal force", "1/m", "1e4 1/m"),
    ("a damping per unit of normal force", "s/m", "30 s/m"),
)

LENGTH_LIMIT = 100
_FACTOR = r"(?:[A-Za-zµ°%]+|1)(?:\^-?[0-9]{1,2}(?:\.[0-9]{1,6})?)?"
_SEPARATOR = r"(?: ?[*·/] ?| )"
_ITEM = rf"(?:{_FACTOR}|\({_FACTOR}(?:{_SEPARATOR}{_FACTOR})*\))"
_UNIT = re.compile(rf"/?{_ITEM}(?:{_SEPARATOR}{_ITEM})*")
_TOKEN = re.compile(r"([A-Za-zµ°%]+|1)(?:\^(-?[0-9.]+))?|([/()*·])")
_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]")
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?) ?(.*)")


def number(value: Any, dimension: str) -> float:
    """Return the SI value of a bare number (taken as SI) or of a text with a unit.

    ``dimension`` is an SI unit ("m", "rad/s", "N/m^1.5", "1" for none) or the name of a quantity ("length",
    "angular velocity"). Raises Fault for another dimension, for anything that is no number, and for nan and
    inf.

    >>> number("0.5 mm", "m")
    0.0005
    """
    unit = _unit_of_dimension(dimension)
    limit, example = dimension_of(unit)
    remedy = f'for example "{example}"' if unit != "1" else f"for example {example}"
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        if hasattr(value, "magnitude"):  # of pint
            remedy = f'give str(...) of it, or .to("{unit}").magnitude'
        raise Fault("", kind_of(value), shown(value), limit, remedy)
    try:
        result = _text(value, unit) if isinstance(value, str) else float(value)
    except Fault as fault:
        if fault.what == "a frequency" and unit == "rad/s":
            remedy = f'"{60.0 * _text(value, "1/s"):.10g} rpm" if turns are meant'
        raise Fault("", fault.what, shown(value), limit, remedy) from None
    except OverflowError:
        raise Fault("", "a number too large to calculate with", shown(value), limit, remedy) from None
    if not math.isfinite(result):
        raise Fault("", "not a finite number", shown(value), limit, remedy)
    return result


def unit_factor(unit: str, dimension: str) -> float:
    """Return the factor from a unit to the SI unit of a ``dimension``. Raises Fault, whose words follow the
    name of what has the unit.
    """
    try:
        return number(f"1 {unit}", dimension)
    except Fault as error:
        reason = error.what.removeprefix("a text whose ")
        message = f"its {reason}" if reason != error.what else f"its unit is that of {reason}"
        raise Fault("", message, shown(unit), error.limit) from None


def quantity_in_si(digits: str, unit: str) -> float:
    """Return the SI value of a number in any unit. Raises ValueError for an unknown unit.

    >>> quantity_in_si("2.5", "kN")
    2500.0
    """
    if not _UNIT.fullmatch(" ".join(unit.split())):
        raise ValueError(f'the unit "{unit}" cannot be read')
    (exact, rough, pi), _ = _measure(" ".join(unit.split()))
    return float(Fraction(digits) * exact) * rough * _raised(Fraction(math.pi), Fraction(pi))


def ends_of(text: str) -> tuple[str, str] | None:
    """Return both ends of a range ``LOW..HIGH`` as texts, the lower one in the unit of the upper one if it
    has none; None for any other text.

    >>> ends_of("0.1..1 mm")
    ('0.1 mm', '1 mm')
    """
    low, dots, high = (part.strip() for part in text.partition(".."))
    if not (dots and low and high):
        return None
    lower, upper = _NUMBER.fullmatch(low), _NUMBER.fullmatch(high)
    return (f"{low} {upper[2]}" if lower and upper and upper[2] and not lower[2] else low), high


def assignments(
    option: str, texts: Iterable[str] | None, example: str, form: str = "not PATH=VALUE"
) -> Iterator[tuple[str, str]]:
    """Yield names and values of texts NAME=VALUE. Raises ValueError with the name of the ``option``, the
    ``form`` that a text has not, and an ``example``.
    """
    for text in texts or ():
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (sign and name):
            raise ValueError(f"{option} {text}: this is {form}; write it as in {option} {example}")
        yield name, value


class NumberRange(NamedTuple):
    """A number by its ``path``, with its range and unit (SI)."""

    path: str
    low: float
    high: float
    unit: str


def number_range(text: str, unit_of: Callable[[str], str], option: str, example: str) -> NumberRange:
    """Return the range of a text PATH=LOW..HIGH; ``unit_of`` returns the unit of the number at a path. Raises
    ValueError with the name of the ``option`` and an ``example``.
    """
    path, sign, span = (part.strip() for part in text.partition("="))
    ends = ends_of(span)
    if not (sign and path and ends):
        raise ValueError(f"{option} {text}: this is not PATH=LOW..HIGH; write it as in {option} {example}")
    try:
        unit = unit_of(path)
        low, high = (number(end, unit) for end in ends)
    except ValueError as error:
        raise ValueError(f"{option} {text}: {error}") from None
    if not low < high:
        raise ValueError(f"{option} {text}: the range is empty; write its lower end first")
    return NumberRange(path, low, high, unit)


def unit_written(values: Iterable[Any], unit: str) -> str:
    """Return the unit of the first text that has one of the dimension of ``unit``; "" without any.

    >>> unit_written([1.0, "1500 rpm"], "rad/s")
    'rpm'
    """
    for value in values:
        match = _NUMBER.fullmatch(" ".join(value.split())) if isinstance(value, str) else None
        if match is None or not match[2]:
            continue
        try:
            number(value, unit)
        except Fault:
            continue
        return str(match[2])
    return ""


def is_bare(text: str) -> bool:
    """Return whether a text is a number without a unit."""
    match = _NUMBER.fullmatch(text.strip())
    return match is not None and not match[2]


def unit_fault(place: str, text: Any, unit: str, size: float | None, origin: str) -> Fault | None:
    """Return the fault of a bare number whose unit was probably forgotten: the value (SI) that it limits has
    a ``size`` that is a hundred times larger or smaller. None for a text with a unit, and for a number that
    is no text. ``origin``: the value that has this size.
    """
    if not isinstance(text, str) or not is_bare(text) or unit == "1" or not size:
        return None
    ratio = abs(number(text, unit) / size)
    if not ratio or 1.0 / IMPROBABLE < ratio < IMPROBABLE:
        return None
    factor = next((factor for factor in PREFIXED if 0.1 < factor * ratio < 10.0), 1.0)
    likely_unit = f"{PREFIXED.get(factor, '')}{unit}"
    reason = (
        f"a unit is probably missing: numbers without a unit are in {unit}, and {origin} is {size:.4g} {unit}"
    )
    remedy = f'write "{text.strip()} {likely_unit}"'
    if likely_unit != unit:
        remedy += f', or "{text.strip()} {unit}" if that is meant'
    return Fault(place, reason, text, "", remedy)


def in_rpm(speed: float) -> str:
    """Return a rotational speed (rad/s) in revolutions per minute, to six digits.

    >>> in_rpm(100.0 * math.pi)
    '3,000 rpm'
    """
    return f"{float(f'{30.0 * speed / math.pi:.6g}'):,g} rpm".replace("e+", "e")


@functools.lru_cache(maxsize=1024)
def dimension_of(unit: str) -> tuple[str, str]:
    """Return the name of the quantity that a unit measures, and an example."""
    exponents = _measure(unit)[1]
    for words, si, example in DIMENSIONS:
        if _measure(si)[1] == exponents:
            return words, example
    return f"a quantity in {unit}", f"1 {unit}"


@functools.lru_cache(maxsize=256)
def _unit_of_dimension(dimension: str) -> str:
    for words, si, _ in DIMENSIONS:
        if words.partition(" ")[2] == dimension:
            return si
    return dimension


@functools.lru_cache(maxsize=4096)
def _text(text: str, unit: str) -> float:
    """SI value of a text; the arithmetic is exact until the last rounding, so "0.2 mm" is 2e-4 to the bit."""
    tidy = " ".join(text.replace("**", "^").replace("μ", "µ").replace("²", "^2").replace("³", "^3").split())
    if len(text) > LENGTH_LIMIT or _COMMA.match(tidy) or not (match := _NUMBER.fullmatch(tidy)):
        raise Fault("", _no_number(tidy))
    digits, written = Fraction(match[1]), match[2] or unit
    if not _UNIT.fullmatch(written):
        raise Fault(
            "", f'a text whose unit "{written}" cannot be read (write units as in "N/m^1.5" or "kg m^2")'
        )
    (exact, rough, pi), exponents = _measure(written)
    if exponents != _measure(unit)[1]:
        raise Fault("", dimension_of(written)[0])
    # The viscosity of oils has this unit, times a second; no pressure of a machine does.
    if exponents == PRESSURE and any(name == "mPa" for name, _ in _factors(written)):
        raise Fault("", 'a text whose unit "mPa" is easily mistaken (did you mean "MPa"?)')
    return float(digits * exact) * rough * _raised(Fraction(math.pi), Fraction(pi))


def _no_number(tidy: str) -> str:
    if re.match(r"[+-]?(nan|inf)", tidy, re.IGNORECASE):
        return "not a finite number"
    if _COMMA.match(tidy):
        return "a text with a comma (write a decimal point)"
    return (
        "a text that does not begin with a number"
        if len(tidy) <= LENGTH_LIMIT
        else "a text too long for a quantity"
    )


@functools.lru_cache(maxsize=256)
def _measure(unit: str) -> tuple[tuple[Fraction, float, int], Exponents]:
    """Factor to SI of a unit expression (exact part, rounded part, power of pi), and its dimension."""
    exact, rough, pi = Fraction(1), 1.0, Fraction(0)
    total = [Fraction(0)] * 4
    for name, power in _factors(unit):
        (factor, inexact, circle), exponents = _named(name)
        if power.denominator == 1:
            exact *= factor ** int(power)
        else:
            rough *= _raised(factor, power)
        rough *= _raised(Fraction(inexact), power)
        pi += circle * power
        total = [have + power * exponent for have, exponent in zip(total, exponents, strict=True)]
    if pi.denominator != 1:
        rough, pi = rough * _raised(Fraction(math.pi), pi), Fraction(0)
    return (exact, rough, int(pi)), (total[0], total[1], total[2], total[3])


def _raised(factor: Fraction, power: Fraction) -> float:
    """Return a power of a unit's factor, rounded from exact numbers or forty digits, because the C library's
    power depends on the machine.
    """
    if power.denominator == 1:
        return float(factor ** int(power))
    if power.denominator == 2:
        return math.sqrt(float(factor ** int(2 * power)))
    from decimal import Decimal, localcontext

    with localcontext() as context:
        context.prec = 40
        base = Decimal(factor.numerator) / Decimal(factor.denominator)
        return float(base ** (Decimal(power.numerator) / Decimal(power.denominator)))


def _factors(unit: str) -> list[tuple[str, Fraction]]:
    """Names and exponents of a unit expression; after a slash it goes on in the numerator, as in pint."""
    factors, sign, outer = [], 1, 1
    for name, power, mark in _TOKEN.findall(unit):
        if name:
            factors.append((name, outer * sign * Fraction(power or 1)))
            sign = 1
        elif mark == "/":
            sign = -1
        elif mark == "(":
            sign, outer = 1, sign
        elif mark == ")":
            outer = 1
    return factors


def _named(name: str) -> tuple[tuple[Fraction, float, int], tuple[Fraction, ...]]:
    if name in UNITS:
        factor, exponents = UNITS[name]
        return (Fraction(factor), 1.0, int(name in WITH_PI)), tuple(map(Fraction, exponents))
    return _through_pint(name)


# Names that people write out, all of them known to pint.
SPELT = [
    "meter",
    "metre",
    "millimeter",
    "millimetre",
    "micrometer",
    "micrometre",
    "centimeter",
    "centimetre",
    "inch",
    "kilogram",
    "gram",
    "second",
    "millisecond",
    "microsecond",
    "radian",
    "degree",
    "newton",
    "kilonewton",
    "pascal",
    "megapascal",
    "gigapascal",
    "hertz",
    "watt",
    "joule",
]


@functools.lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # takes 0.3 s, and everyday units do without

    return pint.UnitRegistry()


# Texts that are no unit here, and what to write.
GAUGE = "gauge pressures are 1.013 bar below absolute ones: write absolute values, or set ambient to 0 bar"
TURNS = 'write revolutions per minute as "rpm"'
ADVICE = {"barg": GAUGE, "bar(g)": GAUGE, "psig": GAUGE, "U": TURNS, "upm": TURNS, "Upm": TURNS}

# Units that users mistake for others, and what to write: grains for grams, short tons for tonnes, gradians
# for degrees (German Grad), angular mils for thousandths of an inch, years, and capitals for small letters.
MISTAKABLE = {
    "gr": 'did you mean "g"? Grains are written "grain"',
    "grs": 'did you mean "g"? Grains are written "grain"',
    "ton": 'did you mean "t", 1000 kg? A short ton is "2000 lb"',
    "tons": 'did you mean "t", 1000 kg? A short ton is "2000 lb"',
    "grad": 'did you mean "deg"? Gradians are written "gon"',
    "mil": 'did you mean "thou", a thousandth of an inch?',
    "mils": 'did you mean "thou", a thousandth of an inch?',
    "pt": 'did you mean "point", 1/72 in?',
    "Mm": 'did you mean "mm"?',
    "Mg": 'did you mean "mg"? 1000 kg are written "t"',
    "Ms": 'did you mean "ms"?',
    "Min": 'did you mean "min"?',
    "pa": 'did you mean "Pa"?',
    "a": 'a year is written "year"',
    "u": 'did you mean "um"? An atomic mass is no mass of a body',
    "c": 'did you mean "cm"?',
    "b": 'did you mean "bar"?',
}
# Moments as catalogues write them, without a space between force and length: no unit is named like that.
MOMENT = re.compile(r"([mkM]?N)(mm|cm|m)")
PRESSURE: Exponents = (Fraction(-1), Fraction(1), Fraction(-2), Fraction(0))


@functools.lru_cache(maxsize=256)
def _through_pint(name: str) -> tuple[tuple[Fraction, float, int], tuple[Fraction, ...]]:
    """Look a unit up in pint by its bare name; pint never evaluates an expression."""
    import difflib

    if name in ADVICE:
        raise Fault("", f'a text whose unit "{name}" is unknown ({ADVICE[name]})')
    if moment := MOMENT.fullmatch(name):
        remedy = f'write it with a space, "{moment[1]} {moment[2]}"'
        raise Fault("", f'a text whose unit "{name}" is unknown ({remedy})')
    if name in MISTAKABLE:
        raise Fault("", f'a text whose unit "{name}" is easily mistaken ({MISTAKABLE[name]})')
    try:
        base = (1.0 * _registry().parse_units(name)).to_base_units()
        units = dict(base.unit_items())
    except Exception:  # pint raises what its tokenizer or its arithmetic happens to raise
        similar = (
            [unit for unit in (name.lower(),) if unit in UNITS]
            or difflib.get_close_matches(name, SPELT, 1, 0.8)
            or difflib.get_close_matches(name, UNITS, 1, 0.4)
        )
        hint = f' (did you mean "{similar[0]}"?)' if similar else ""
        raise Fault("", f'a text whose unit "{name}" is unknown{hint}') from None
    exponents = tuple(Fraction(units.pop(key, 0)) for key in ("meter", "kilogram", "second", "radian"))
    if units:
        raise Fault("", f'a text whose unit "{name}" measures no length, mass, time or angle')
    return (Fraction(1), float(base.magnitude), 0), exponents
