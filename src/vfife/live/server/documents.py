"""Models that are open in a session, their files, and the shelf of models that can be opened.

A shelf reaches the gallery and the model files of one folder; nothing else on the machine is read or written.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from ... import gallery
from ...errors import Fault, ModelError, VfifeError
from ...errors import Path as KeyPath
from ...files import read_bytes, write_text
from ...model.mechanism import Mechanism
from ...modelfile import dump, load, loads
from ...modelfile.paths import resolve
from ...modelfile.text import edited
from ...modelfile.write import value as toml_text
from ..page.page_model import model_of

LARGEST = 2_000_000  # bytes of a model file
MOST_UNDO = 200  # texts that can be had back
MOST_FILES = 200  # files of a folder that are looked at
NAME = re.compile(r"\w[\w .()+-]*\.toml")
# A model file has one of these tables
PARTS = frozenset(["body", "joint", "driver", "spring", "gear", "load", "ground"])
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
        """Take a sound text in place of the former one. Raises ModelError for another, Conflict where it was
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
        """Change values where they stand, all of them or none.

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
        """Go back to the text before."""
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

    # --------------------------------------------------------------------------------------------------- file

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
        """Write the text into its file, or a new one, which it is of from then on.

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

    # -------------------------------------------------------------------------------------------------- words

    def json(self) -> Json:
        """As a browser takes it."""
        return {
            "id": self.id, "name": self.name, "title": self.mechanism.name, "text": self.text,
            "version": self.version, "saved": self.saved,
            "file": self.path.name if self.path else None, "faults": list(self.faults),
            "undo": len(self.before),
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


# -------------------------------------------------------------------------------------------------- the shelf


class Shelf:
    """The documents of a session, by their identities, and what others can be opened: from the gallery, from
    ``folder``, or as a text.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.documents: dict[str, Document] = {}
        self._numbers = count(1)

    def __getitem__(self, which: str) -> Document:
        """A document that is open. Raises LookupError."""
        return self.documents[which]

    # ------------------------------------------------------------------------------------------ what there is

    def json(self) -> Json:
        """What can be chosen."""
        shown = [
            {"name": name, **about(mechanism)}
            for name, mechanism in ((name, getattr(gallery, name)()) for name in gallery.__all__)
        ]
        files = [{"name": name, "title": title_of(path)} for name, path in sorted(self.files().items())]
        texts = [
            {"id": one.id, "name": one.name}
            for one in self.documents.values()
            if one.path is None and not one.id.startswith("gallery-")
        ]
        return {"gallery": shown, "files": files, "folder": self.folder.name, "texts": texts}

    def files(self) -> dict[str, Path]:
        """Model files that may be opened: those of the folder, links that leave it not among them, and those
        that are open.
        """
        files = {one.path.name: one.path for one in self.documents.values() if one.path is not None}
        for path in sorted(self.folder.glob("*.toml"))[:MOST_FILES]:
            if path.name not in files and is_model(path, self.folder):
                files[path.name] = path
        return files

    # ------------------------------------------------------------------------------------------------ opening

    def from_gallery(self, name: str) -> Document:
        """A mechanism of the gallery. Raises LookupError for a name that it has not."""
        which = f"gallery-{name}"
        if which not in self.documents:
            if name not in gallery.__all__:
                raise LookupError(name)
            self.documents[which] = Document(which, name, gallery.path(name).read_text(encoding="utf-8"))
        return self.documents[which]

    def from_folder(self, name: str) -> Document:
        """A model file of the folder. Raises LookupError for another name, ModelError for a file with
        faults.
        """
        return self.from_file(self.files()[name])

    def from_file(self, path: Path, settings: list[tuple[str, str]] | None = None) -> Document:
        """A model file that the user has named, with values that were set. Raises ModelError with every
        fault.
        """
        path = path.resolve()
        for one in self.documents.values():
            if one.path == path:
                return one
        document = from_disk(f"file-{next(self._numbers)}", path)
        if settings:
            load(path, set=settings)  # which tells all that is wrong with them
            for where, value in settings:
                document.set([(resolve(tomllib.loads(document.text), where), value)])
        self.documents[document.id] = document
        return document

    def from_text(self, name: str, text: str) -> Document:
        """A text that a browser has read. Raises ModelError with every fault."""
        which = f"text-{next(self._numbers)}"
        self.documents[which] = Document(which, re.sub(r"[^\w .()+-]", "_", name)[:80] or "model.toml", text)
        return self.documents[which]

    def from_run(self, folder: Path, settings: list[tuple[str, str]] | None = None) -> Document:
        """The model of a run, and its step. Raises RunFileError, and ValueError for values that are set."""
        mechanism, step = model_of(folder, settings or [])
        which = f"run-{next(self._numbers)}"
        self.documents[which] = Document(which, folder.resolve().name, dump(mechanism), step=step)
        return self.documents[which]

    def place(self, name: str) -> Path:
        """Where a model of this name is written. Raises Conflict for what is no plain name of a model
        file.
        """
        file_name = name if name.endswith(".toml") else f"{name}.toml"
        if not NAME.fullmatch(file_name) or len(file_name) > 100:
            raise Conflict(
                "a name is letters, digits, spaces, - and _, such as my-linkage.toml; it is written into the"
                " folder of this session"
            )
        return self.folder / file_name


def from_disk(which: str, path: Path) -> Document:
    """A document of a file. Raises ModelError where it cannot be read or has faults."""
    try:
        text, status = read_bytes(path).decode("utf-8-sig"), path.stat()
    except (OSError, UnicodeDecodeError):
        load(path)  # which says why
        raise
    return Document(which, path.name, text, path, text, stamp=(status.st_mtime_ns, status.st_size))


def is_model(path: Path, folder: Path) -> bool:
    """Whether a file of a folder is a model file, as its tables tell."""
    try:
        if path.resolve().parent != folder or not path.is_file() or path.stat().st_size > LARGEST:
            return False
        return bool(PARTS & tomllib.loads(read_bytes(path, LARGEST).decode("utf-8")).keys())
    except (OSError, ValueError, RecursionError):
        return False


def title_of(path: Path) -> str:
    """What a model file says that it is called; nothing where it says nothing, or not in a text."""
    try:
        return str(tomllib.loads(read_bytes(path, LARGEST).decode("utf-8")).get("name", ""))
    except (OSError, ValueError, RecursionError):
        return ""


def about(mechanism: Mechanism) -> Json:
    """What a choice says of a mechanism."""
    return {
        "title": mechanism.name,
        "note": mechanism.note,
        "static": mechanism.settings.analysis == "static",
    }
