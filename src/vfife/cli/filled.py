"""Defaults of a model file that were filled in, found by comparing the file with the fields of its nouns."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files import read_bytes

if TYPE_CHECKING:
    from ..modelfile.tables import Table

Filled = dict[str, Any]


def filled_in(path: Path, items: Iterable[tuple[str, Any]]) -> list[Filled]:
    """Keys that neither a model file without faults nor ``--set`` gives, with the value that is taken instead."""
    from ..fields import Chosen
    from ..model.mechanism import Mechanism
    from ..modelfile.csvtables import expand
    from ..modelfile.paths import override
    from ..modelfile.reader import Written
    from ..modelfile.tables import Table

    raw = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    _, given = override(raw, items)
    expand(raw, str(path))
    reading = Written(raw, given)
    reading.mechanism()
    found = list(left_out("", Table(Mechanism), raw))
    for place, what, holder in sorted(reading.shapes, key=lambda shape: shape[0][0] not in ("run", "start")):
        if len(place) > 2:
            continue
        found += left_out(".".join(map(str, place)), what, holder)
        for key in what.fields:
            if isinstance(held := what.value(key), Chosen):
                found += law(".".join(map(str, (*place, key))), held.word, holder.get(key, {}))
    return found


def left_out(path: str, what: Table, holder: dict[str, Any]) -> Iterator[Filled]:
    """Keys with a default value that a table leaves out; empty tables and values that are derived are none."""
    from ..fields import meaning_of

    if what.tag and what.optional and what.tag not in holder:
        yield {"path": f"{path}.{what.tag}", "value": what.word, "unit": "1", "meaning": f"the {what.tag} of it"}
    for key, field in what.fields.items():
        default = getattr(field.default_factory, "name", field.default)  # of a material, its name
        if key not in holder and isinstance(default, str | float | int | tuple) and default not in ("", ()) and not what.idle(key, holder):
            unit = getattr(what.value(key), "unit", "1")
            yield {"path": f"{path}.{key}".lstrip("."), "value": default, "unit": unit, "meaning": meaning_of(field, what.along)}


def law(path: str, kind: str, given: dict[str, Any]) -> Iterator[Filled]:
    """The law and its parameters that a joint leaves out."""
    from ..fields import described_fields
    from ..model.reading import DEFAULTS, LAWS

    name = given.get("law", DEFAULTS[kind].name)
    if "law" not in given:
        yield {"path": f"{path}.law", "value": name, "unit": "1", "meaning": f"{kind} law"}
    for one in described_fields(LAWS[kind].known()[name]):
        if one.name not in given and isinstance(one.default, str | float | int):
            yield {"path": f"{path}.{one.name}", "value": one.default, **{key: one.metadata[key] for key in ("unit", "meaning")}}
