"""Descriptions of the fields of laws and model classes: unit, meaning, limits and default, stated once at the
field.

Everything that reads, checks, writes or documents a law or model class uses them: model files and their JSON
Schema, validation of objects made in Python, lists of defaults.
"""

from __future__ import annotations

from .described import (
    Field,
    Reader,
    contains_text,
    contains_unit,
    default_of,
    described,
    described_fields,
    key_of,
    meaning_of,
    partial,
    quantity,
    required,
    value_of,
)
from .parts import (
    A_TABLE,
    LENGTH,
    PLACE,
    SCALAR,
    Chosen,
    Curve,
    Direction,
    Entries,
    FixedList,
    FreeList,
    Inner,
    Named,
    Names,
)
from .values import Choice, Integer, Json, Measure, Share, Switch, Text, Value

__all__ = [
    "A_TABLE",
    "LENGTH",
    "PLACE",
    "SCALAR",
    "Choice",
    "Chosen",
    "Curve",
    "Direction",
    "Entries",
    "Field",
    "FixedList",
    "FreeList",
    "Inner",
    "Integer",
    "Json",
    "Measure",
    "Named",
    "Names",
    "Reader",
    "Share",
    "Switch",
    "Text",
    "Value",
    "contains_text",
    "contains_unit",
    "default_of",
    "described",
    "described_fields",
    "key_of",
    "meaning_of",
    "partial",
    "quantity",
    "required",
    "value_of",
]
