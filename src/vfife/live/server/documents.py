"""Models that are looked at: their text, which is always that of a sound model, the file that they are of,
and what was before.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ...errors import Fault, ModelError, VfifeError
from ...errors import Path as KeyPath
from ...files import read_bytes, write_text
from ...model.mechanism import Mechanism
from ...modelfile import loads
from ...modelfile.text import edited
from ...modelfile.write import value as toml_text

LARGEST = 2_000_000  # bytes of a model file
MOST_UNDO = 200  # texts that can be had back
Json = dict[str, Any]


class Conflict(ValueError):
    """What is asked does not fit what has happened meanwhile."""


class Draft(VfifeError):
    """Changes that do not give a sound model yet: its faults, and what the text would be."""

    def __init__(self, error: ModelError, text: str) -> None:
        super().__init__(str(error))
        self.faults, self.text, self.values = error.faults, text, leaves(tomllib.loads(text))


class Look(NamedTuple):
    """What a look at a file saw: its name, the stamp that was known before and the one of ``now``, and its
    text, None where it is gone.
    """

    path: Path
    before: tuple[int, int] | None
    now: tuple[int, int]
    text: str | None


@dataclass
class Document:
    """A model: ``text`` and the ``mechanism`` that it says, of ``version``; ``path`` is its file or None,
    ``disk`` what that was last seen to hold.

    ``step`` (s) is that of the run that it came from. ``faults`` are those of the file as it is now, where it
    is not sound.
    """

    id: str
    name: str
    text: str
    path: Path | None = None
    disk: str | None = None
    step: float | None = None
    version: int = 1
    faults: tuple[Json, ...] = ()
    before: list[str] = field(default_factory=list)
    stamp: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        self.mechanism = self.read(self.text)
        self.opened = self.text

    def read(self, text: str) -> Mechanism:
        """What a text says. Raises ModelError with every fault."""
        if len(text.encode("utf-8", "replace")) > LARGEST:
            raise ModelError(
                [
                    Fault(
                        "file",
                        f"the text has more than {LARGEST:,} bytes",
                        "",
                        "",
                        "edit it outside of the page",
                    )
                ],
                self.name,
            )
        return loads(text, file=str(self.path) if self.path else self.name)

    @property
    def saved(self) -> bool:
        """Whether the file holds the text."""
        return self.disk == self.text

    def take(self, text: str, version: int | None = None) -> None:
        """Takes a sound text in place of the former one. Raises ModelError for another, Conflict where it was
        not made from the last one.
        """
        if version is not None and version != self.version:
            raise Conflict(
                "the model was changed elsewhere meanwhile; the page now shows it as it is, so make the"
                " change again"
            )
        if text == self.text:
            return
        self.mechanism = self.read(text)
        self.before = [*self.before[-MOST_UNDO:], self.text]
        self._now(text)

    def set(self, changes: Sequence[tuple[KeyPath, str | None]], version: int | None = None) -> None:
        """Changes values where they stand, all of them or none.

        Raises Draft where that gives no sound model, ModelError where a value cannot be changed alone,
        Conflict as :meth:`take` does.
        """
        text = self.text
        for path, value in changes:
            text = edited(text, path, value)
        try:
            self.take(text, version)
        except ModelError as error:
            raise Draft(error, text) from None

    def undo(self) -> None:
        """Goes back to the text before."""
        if self.before:
            text = self.before.pop()
            self.mechanism = self.read(text)
            self._now(text)

    def _now(self, text: str) -> None:
        self.text, self.version, self.faults = text, self.version + 1, ()

    @property
    def its_step(self) -> float | None:
        """The step (s) of the run that it came from, as long as its text is what that ran."""
        return self.step if self.text == self.opened else None

    # ------------------------------------------------------------------------------------------------------------ file

    def look(self) -> Look | None:
        """Read the file where it has another time of change or size than before; None where it has not, or
        there is no file.
        """
        path, stamp = self.path, self.stamp
        if path is None:
            return None
        try:
            status = path.stat()
            now = (status.st_mtime_ns, status.st_size)
            return (
                None
                if now == stamp
                else Look(path, stamp, now, read_bytes(path, LARGEST).decode("utf-8-sig"))
            )
        except (OSError, UnicodeDecodeError):
            return Look(path, stamp, (0, 0), None)

    def follow(self, look: Look | None) -> str | None:
        """Take what a look at the file has seen: "model" where the text was taken, "faults" where it is not
        sound, "gone", or None.

        A look counts for nothing where the file was saved or looked at meanwhile.
        """
        if look is None or (look.path, look.before) != (self.path, self.stamp):
            return None
        missing, self.stamp = look.now == (0, 0) != self.stamp, look.now
        if look.text is None:
            self.disk = None if missing else self.disk
            return "gone" if missing else None
        disk = look.text
        if disk == self.disk:
            return None
        self.disk = disk
        try:
            self.take(disk)
        except ModelError as error:
            self.faults = fault_list(error)
            return "faults"
        self.faults = ()
        return "model"

    def save(self, path: Path | None = None) -> None:
        """Writes the text into its file, or a new one, which it is of from then on.

        The text has been read as a sound model before; what was there gives way when the new file is whole.
        Raises Conflict where a file has changed since it was read, or there is one already, and OSError where
        it cannot be written.
        """
        target = path or self.path
        if target is None:
            raise Conflict("this model has no file yet; give it a name")
        if path is not None and path != self.path and path.exists():
            raise Conflict(f"there is a file {path.name} already; choose another name")
        if target.exists() and not target.is_file():
            raise Conflict(
                f"{target.name} is no regular file any more (a pipe, a device or a folder); choose another"
                " name"
            )
        before = self.version
        if target == self.path and (self.follow(self.look()) == "faults" or self.version != before):
            raise Conflict(
                f"{target.name} was changed by another program meanwhile; it is shown now, and Undo brings"
                " back what was here"
            )
        write_text(target, self.text)
        self.path, self.name, self.disk, self.faults = target, target.name, self.text, ()
        status = target.stat()
        self.stamp = (status.st_mtime_ns, status.st_size)

    # ------------------------------------------------------------------------------------------------------------ words

    def json(self) -> Json:
        """As a browser takes it."""
        return {
            "id": self.id, "name": self.name, "title": self.mechanism.name, "text": self.text, "version": self.version, "saved": self.saved,
            "file": self.path.name if self.path else None, "faults": list(self.faults), "undo": len(self.before),
            "values": leaves(tomllib.loads(self.text)),
        }  # fmt: skip


def text_in(body: Json, key: str) -> str:
    """A text that was sent. Raises TypeError for anything else."""
    value = body[key]
    if not isinstance(value, str):
        raise TypeError(f"{key} is to be a text, and was sent as {type(value).__name__}")
    return value


def fault_list(error: Exception) -> tuple[Json, ...]:
    """The faults of an error, each with its place and its sentence."""
    faults = getattr(error, "faults", ())
    return tuple({"where": one.where, "said": str(one)} for one in faults) or (
        {"where": "", "said": str(error)},
    )


def leaves(values: Any) -> Any:
    """Tables of texts: each value as it is typed, texts without their quotes."""
    if isinstance(values, dict):
        return {name: leaves(one) for name, one in values.items()}
    return values if isinstance(values, str) else toml_text(values)
