"""Files that a command writes: none is one that it reads, no two are one, and none is a folder; told before anything is computed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ..files import read_bytes

MOST = 8_000_000  # bytes of a model that are looked through


def refuse_inputs(targets: Iterable[tuple[str, Path | None]], inputs: Iterable[Path | None]) -> None:
    """Raises ValueError with all targets (option and file) that would be written over an input, over each other, or that are folders.

    Inputs are the files that are named and the CSV files that models among them name.
    """
    read = [path for one in inputs if one is not None for path in (one, *tables_of(one))]
    said: list[str] = []
    seen: list[tuple[str, Path]] = []
    for option, path in targets:
        if path is None:
            continue
        if path.is_dir():
            said.append(f"{option} {path}: this is a folder; name a file")
        elif any(same(path, one) for one in read):
            said.append(f"{option} {path}: this file is read, and would be written over; name another file")
        elif (other := next((word for word, one in seen if same(path, one)), None)) is not None:
            said.append(f"{option} {path}: {other} is written there too; name another file")
        seen.append((option, path))
    if said:
        raise ValueError("; ".join(said))


def same(one: Path, other: Path) -> bool:
    """Whether two names are of one file, by links too."""
    try:
        return one.samefile(other)
    except (OSError, ValueError):
        return one.absolute() == other.absolute()


def tables_of(model: Path) -> list[Path]:
    """The CSV files that a model names, as far as it can be read."""
    try:
        if model.suffix.lower() != ".toml" or model.stat().st_size > MOST:
            return []
        raw = tomllib.loads(read_bytes(model).decode("utf-8"))
        return [model.parent / text for text in texts(raw) if text.lower().endswith(".csv")]
    except (OSError, ValueError, RecursionError):  # told when the model is read
        return []


def texts(value: Any) -> Iterator[str]:
    """All texts in a table of TOML."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for one in value.values() if isinstance(value, dict) else value:
            yield from texts(one)
