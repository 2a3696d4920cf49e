"""A cross section by its numbers or by one of its shapes, as a model file or a script gives it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import Path, article, shown
from ..fields import described_fields, partial, value_of
from .bodies import Section


def read_section(by: Any, path: Path, value: Mapping[str, Any]) -> Section:
    """The section of a table: ``area`` and ``second_moment``, or one shape; known in part where something is refused."""
    before, shapes = len(by.faults), [key for key in Section.shapes if key in value]
    both = {"area", "second_moment"} & set(value)
    if not ((len(shapes) == 1 and not both) or (not shapes and len(both) == 2)):
        what = "the section is described more than once" if shapes else "the section is not complete"
        limit = "area and second_moment together, or one of " + ", ".join(Section.shapes)
        by.refuse(path, what, shown(value), limit, "give one of these")
    fields = {field.name: field for field in described_fields(Section)}
    read: dict[str, Any] = {}
    for key, entry in value.items():
        held = Section.shapes[key][0] if key in shapes else value_of(fields[key]) if key in fields else None
        if held is None:
            by.unknown((*path, key), entry)
        else:
            read[key] = held.read(entry, (*path, key), by)
    if shapes and "extreme_fibre" in value:
        what = f"{article(shapes[0])} section knows its outermost fibre"
        by.refuse((*path, "extreme_fibre"), what, shown(value["extreme_fibre"]), "", "remove it")
    tube = read.get("tube")
    if tube is not None and tube[1] >= tube[0]:
        what, limit = "the inner diameter is not below the outer one: no wall is left", f"inner below outer = {tube[0]:g} m"
        by.refuse((*path, "tube"), what, shown(value["tube"]), limit, "give the outer diameter first")
    if len(by.faults) > before:
        found: Section = partial(Section, {} if shapes else read)
        return found
    if not shapes:
        return Section(**read)
    sizes = read[shapes[0]]
    made: Section = getattr(Section, shapes[0])(*(sizes if isinstance(sizes, tuple) else (sizes,)))
    return made
