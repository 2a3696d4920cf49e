"""Model files on disk: read as a mechanism, written from one."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..errors import Fault, ModelError, kind_of, shown
from ..files import replacement
from ..model.mechanism import Mechanism
from .read import load as read_file
from .write import dump


def load(path: str | Path, overrides: Mapping[str, Any] | None = None) -> Mechanism:
    """The mechanism of a model file, with some of its values replaced or added before anything is checked.

    >>> m = load("machine.toml", {"joint.C.clearance": "0.5 mm", "run.turns": 3})  # doctest: +SKIP

    ``overrides``: values by their paths, as ``vfife run --set`` takes them. Raises ModelError with every
    fault of the file and of the values.
    """
    if not isinstance(path, str | os.PathLike):
        raise ModelError(
            [Fault("path", f"this is {kind_of(path)}", shown(path), "the name of a model file", "name one")],
            "load()",
        )
    given: Any = {} if overrides is None else overrides
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        remedy = 'give them as in {"joint.C.clearance": "0.5 mm"}'
        raise ModelError(
            [Fault("overrides", f"this is {kind_of(overrides)}", shown(overrides), "values by path", remedy)],
            "load()",
        )
    return read_file(path, list(given.items()))


def load_model(path: str | Path, set: Iterable[tuple[str, Any]] = ()) -> Mechanism:
    """The mechanism of a model file.

    ``set`` holds (path, value) pairs that replace or add values before anything is checked, as in
    ("joint.C.clearance", "0.5 mm").
    :func:`load` takes them as a mapping. Raises ModelError with every fault of the file.
    """
    return read_file(path, set)


def save_model(mechanism: Mechanism, path: str | Path) -> None:
    """Writes a model file that :func:`load_model` reads as an equal mechanism; one that is there gives way
    when the new one is whole.

    Raises ModelError for a mechanism that no model file can hold, and where the file cannot be written.
    """
    path = Path(path)
    try:
        text = dump(mechanism)
    except (TypeError, ValueError) as error:
        raise ModelError([Fault("mechanism", f"no model file can hold it: {error}")], str(path)) from None
    try:
        with replacement(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    except OSError as error:
        remedy = "name a file in a folder that is there and can be written to"
        raise ModelError(
            [Fault("file", f"it cannot be written ({error.strerror})", remedy=remedy)], str(path)
        ) from None
