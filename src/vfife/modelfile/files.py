"""Model files on disk: read as a mechanism, written from one."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import Fault, ModelError
from ..model.mechanism import Mechanism
from .read import load
from .write import dump


def load_model(path: str | Path, set: Iterable[tuple[str, Any]] = ()) -> Mechanism:
    """The mechanism of a model file.

    ``set`` holds (path, value) pairs that replace or add values before anything is checked, as in ("joint.C.clearance", "0.5 mm").
    Raises ModelError with every fault of the file.
    """
    return load(path, set)


def save_model(mechanism: Mechanism, path: str | Path) -> None:
    """Writes a model file that :func:`load_model` reads as an equal mechanism; one that is there gives way when the new one is whole.

    Raises ModelError for a mechanism that no model file can hold, and where the file cannot be written.
    """
    path = Path(path)
    part = path.with_name(f"{path.name}.part")
    try:
        text = dump(mechanism)
    except (TypeError, ValueError) as error:
        raise ModelError([Fault("mechanism", f"no model file can hold it: {error}")], str(path)) from None
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        remedy = "name a file in a folder that is there and can be written to"
        raise ModelError([Fault("file", f"it cannot be written ({error.strerror})", remedy=remedy)], str(path)) from None
