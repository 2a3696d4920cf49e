"""What the fields of laws and nouns hold: unit, meaning, limits and default, said once, beside the field.

Whoever reads, checks, writes or describes a law or a noun asks its fields: model files, their JSON Schema,
the checks of what Python makes, the lists of defaults.
"""

from __future__ import annotations

from .described import (
    Field,
    Reading,
    described,
    described_fields,
    key_of,
    meaning_of,
    partial,
    quantity,
    required,
    value_of,
)
from .parts import LENGTH, PLACE, SCALAR, Chosen, Curve, Direction, Each, Entries, Inner, Many, Named, Names
from .values import Choice, Integer, Json, Measure, Switch, Text, Value

__all__ = [
    "LENGTH",
    "PLACE",
    "SCALAR",
    "Choice",
    "Chosen",
    "Curve",
    "Direction",
    "Each",
    "Entries",
    "Field",
    "Inner",
    "Integer",
    "Json",
    "Many",
    "Measure",
    "Named",
    "Names",
    "Reading",
    "Switch",
    "Text",
    "Value",
    "described",
    "described_fields",
    "key_of",
    "meaning_of",
    "partial",
    "quantity",
    "required",
    "value_of",
]
