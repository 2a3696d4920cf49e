"""Another number in a mechanism, without its file: what the path of a number leads to is replaced in the nouns themselves."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..model.mechanism import Mechanism

HOLDERS = {
    "ground": "points", "body": "bodies", "joint": "joints", "gear": "gears", "spring": "springs", "driver": "drivers", "load": "loads",
    "gravity": "gravity",
}  # fmt: skip


def with_number(mechanism: Mechanism, path: str, was: float, value: float) -> Mechanism | None:
    """The mechanism with ``value`` in the place of what it ``was`` (SI), at a path as :func:`~vfife.modelfile.numbers.numbers` says it.

    None where no noun holds that very number there: a number of a material, which several may share, or one that was read into others.
    Raises ValueError where the noun refuses the value.
    """
    section, *rest = path.split(".")
    if section not in HOLDERS:
        return None
    holder = HOLDERS[section]
    found = _changed(getattr(mechanism, holder), rest, was, value)
    return None if found is None else dataclasses.replace(mechanism, **{holder: found})


def _changed(held: Any, path: list[str], was: float, value: float) -> Any:
    """What is held with the number at a path replaced; None where that is another one."""
    if not path:
        return value if isinstance(held, float) and held == was else None
    key, *rest = path
    if isinstance(held, dict):
        inner = _changed(held.get(key), rest, was, value)
        return None if inner is None else {**held, key: inner}
    if isinstance(held, tuple):
        place = int(key) if key.isdigit() else len(held)
        inner = _changed(held[place], rest, was, value) if place < len(held) else None
        return None if inner is None else (*held[:place], inner, *held[place + 1 :])
    if dataclasses.is_dataclass(held) and not isinstance(held, type) and key in {one.name for one in dataclasses.fields(held)}:
        inner = _changed(getattr(held, key), rest, was, value)
        return None if inner is None else dataclasses.replace(held, **{key: inner})
    return None
