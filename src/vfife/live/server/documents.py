"""Open models of a session, their files, and the models that can be opened: the gallery and the model files
of one folder. Nothing else on the machine is read or written.
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
from ...modelfile.edits import edited
from ...modelfile.paths import resolve
from ...modelfile.write import value as toml_text
from ..page.page_model import model_of

LARGEST = 2_000_000  # bytes of a model file
MOST_UNDO = 200  # texts that undo() can restore
MOST_FILES = 200  # files of a folder that are listed
NAME = re.compile(r"\w[\w .()+-]*\.toml")
# A TOML file with one of these tables is taken for a model file.
PARTS = frozenset(["body", "joint", "driver", "spring", "gear", "load", "ground"])
Json = dict[str, Any]


class Conflict(ValueError):
    """A request that does not match the present state of a model or file."""


class Draft(VfifeError):
    """Changes that do not give a valid model yet: its faults, and the text it would have."""

    def __init__(self, error: ModelError, text: str) -> None:
        super().__init__(str(error))
        self.faults, self.text, self.values = error.faults, text, leaves(tomllib.loads(text))


class Look(NamedTuple):
    """Observation of a file: its path, its stamp (time of change and size) as known before and as observed,
    and its text, None if it is missing.
    """

    path: Path
    previous_stamp: tuple[int, int] | None
    stamp: tuple[int, int]
    text: str | None


@dataclass
class Document:
    """An open model: ``text``, its ``mechanism`` and a ``version`` that every change increments.

    ``path`` is its file or None, ``disk`` the last known content of that file. ``step`` (s) is that of the
    run from which the model was opened. ``faults`` are those of the file, if its present content is invalid.
    """

    id: str
    name: str
    text: str
    path: Path | None = None
    disk: str | None = None
    step: float | None = None
    version: int = 1
    faults: tuple[Json, ...] = ()
    undo_texts: list[str] = field(default_factory=list)
    redo_texts: list[str] = field(default_factory=list)
    stamp: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        self.mechanism = self.read(self.text)
        self.opened = self.text

    def read(self, text: str) -> Mechanism:
        """Return the mechanism of a text. Raises ModelError with all faults."""
        self.refuse_large(text)
        return loads(text, file=str(self.path) if self.path else self.name)

    def refuse_large(self, text: str) -> None:
        """Raise ModelError for a text that is larger than a model."""
        if len(text.encode("utf-8", "replace")) > LARGEST:
            fault = Fault(
                "file", f"the text has more than {LARGEST:,} bytes", remedy="edit it outside of the page"
            )
            raise ModelError([fault], self.name)

    @property
    def saved(self) -> bool:
        """Whether the file contains the text."""
        return self.disk == self.text

    def take(self, text: str, version: int | None = None) -> None:
        """Replace the text by a valid one. Raises ModelError for an invalid text, Conflict if it was not
        derived from the present ``version``.
        """
        if version is not None and version != self.version:
            raise Conflict(
                "the model was changed elsewhere meanwhile; the page now shows it as it is, so make the"
                " change again"
            )
        if text == self.text:
            return
        self.mechanism = self.read(text)
        self.undo_texts, self.redo_texts = [*self.undo_texts[-MOST_UNDO:], self.text], []
        self._set_text(text)

    def set(self, changes: Sequence[tuple[KeyPath, str | None]], version: int | None = None) -> None:
        """Change values in the text, all or none.

        ``changes`` are paths with new values, None to remove. Raises Draft if the result is no valid model,
        ModelError if a value cannot be changed by itself, Conflict as :meth:`take`.
        """
        text = self.text
        for path, value in changes:
            text = edited(text, path, value)
        try:
            self.take(text, version)
        except ModelError as error:
            raise Draft(error, text) from None

    def undo(self) -> None:
        """Restore the previous text."""
        self._restore(self.undo_texts, self.redo_texts)

    def redo(self) -> None:
        """Restore the text that the last undo took back."""
        self._restore(self.redo_texts, self.undo_texts)

    def _restore(self, source: list[str], target: list[str]) -> None:
        if source:
            self.mechanism = self.read(source[-1])
            target.append(self.text)
            self._set_text(source.pop())

    def _set_text(self, text: str) -> None:
        self.text, self.version, self.faults = text, self.version + 1, ()

    @property
    def its_step(self) -> float | None:
        """Step (s) of the run from which the model was opened, while its text is unchanged."""
        return self.step if self.text == self.opened else None

    # --------------------------------------------------------------------------------------------------- file

    def look(self) -> Look | None:
        """Read the file if its time of change or size differs from the last ones; None if not, or without
        file.
        """
        path, stamp = self.path, self.stamp
        if path is None:
            return None
        try:
            status = path.stat()
            present = (status.st_mtime_ns, status.st_size)
            return (
                None
                if present == stamp
                else Look(path, stamp, present, read_bytes(path, LARGEST).decode("utf-8-sig"))
            )
        except (OSError, UnicodeDecodeError):
            return Look(path, stamp, (0, 0), None)

    def follow(self, look: Look | None) -> str | None:
        """Apply an observation of the file; return "model" if its text was taken, "faults" if it is invalid,
        "gone", or None.

        An observation is ignored if the file was saved or observed again in the meantime.
        """
        if look is None or (look.path, look.previous_stamp) != (self.path, self.stamp):
            return None
        missing, self.stamp = look.stamp == (0, 0) != self.stamp, look.stamp
        if look.text is None:
            self.disk = None if missing else self.disk
            return "gone" if missing else None
        # A time of change may differ with equal content: touch, or an editor that saves twice.
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
        """Write the text into its file or a new one, which becomes its file.

        An existing file is replaced when the new one is complete. Raises Conflict if the file was changed
        since it was read, or if a new one exists already, and OSError if it cannot be written.
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
        # The file is checked immediately before it is written. A change by another program becomes the
        # present text, and the user's text the step before it for Undo, so that neither is lost.
        version = self.version
        if target == self.path and (self.follow(self.look()) == "faults" or self.version != version):
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
        """Return the document as browsers receive it."""
        return {
            "id": self.id, "name": self.name, "title": self.mechanism.name, "text": self.text,
            "version": self.version, "saved": self.saved,
            "file": self.path.name if self.path else None, "faults": list(self.faults),
            "undo": len(self.undo_texts), "redo": len(self.redo_texts),
            "values": leaves(tomllib.loads(self.text)),
        }  # fmt: skip


def text_in(body: Json, key: str) -> str:
    """Return a text of a request. Raises TypeError for any other type."""
    value = body[key]
    if not isinstance(value, str):
        raise TypeError(f"{key} is to be a text, and was sent as {type(value).__name__}")
    return value


def fault_list(error: Exception) -> tuple[Json, ...]:
    """Return the faults of an error, each with place and sentence."""
    faults = getattr(error, "faults", ())
    return tuple({"where": fault.where, "said": str(fault)} for fault in faults) or (
        {"where": "", "said": str(error)},
    )


def leaves(values: Any) -> Any:
    """Return nested tables with each value as typed in a model file, texts without quotes."""
    if isinstance(values, dict):
        return {name: leaves(entry) for name, entry in values.items()}
    return values if isinstance(values, str) else toml_text(values)


# -------------------------------------------------------------------------------------------------- the shelf


class Shelf:
    """The open documents of a session, by identity, and the models that can be opened: from the gallery, from
    ``folder``, or as a text.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.documents: dict[str, Document] = {}
        self._numbers = count(1)

    def __getitem__(self, identity: str) -> Document:
        """Return an open document. Raises LookupError."""
        return self.documents[identity]

    # ------------------------------------------------------------------------------------------ what there is

    def json(self) -> Json:
        """Return the models that can be chosen."""
        shown = [
            {"name": name, **heading(mechanism)}
            for name, mechanism in ((name, getattr(gallery, name)()) for name in gallery.__all__)
        ]
        files = [{"name": name, "title": title_of(path)} for name, path in sorted(self.files().items())]
        texts = [
            {"id": document.id, "name": document.name}
            for document in self.documents.values()
            if document.path is None and not document.id.startswith("gallery-")
        ]
        return {"gallery": shown, "files": files, "folder": self.folder.name, "texts": texts}

    def files(self) -> dict[str, Path]:
        """Return the model files that may be opened: open ones and those of the folder, except links that
        leave it.
        """
        files = {
            document.path.name: document.path
            for document in self.documents.values()
            if document.path is not None
        }
        for path in sorted(self.folder.glob("*.toml"))[:MOST_FILES]:
            if path.name not in files and is_model(path, self.folder):
                files[path.name] = path
        return files

    # ------------------------------------------------------------------------------------------------ opening

    def from_gallery(self, name: str) -> Document:
        """Return a mechanism of the gallery. Raises LookupError for an unknown name."""
        identity = f"gallery-{name}"
        if identity not in self.documents:
            if name not in gallery.__all__:
                raise LookupError(name)
            self.documents[identity] = Document(
                identity, name, gallery.path(name).read_text(encoding="utf-8")
            )
        return self.documents[identity]

    def from_folder(self, name: str) -> Document:
        """Return a model file of the folder. Raises LookupError for an unknown name, ModelError for an
        invalid file.
        """
        return self.from_file(self.files()[name])

    def from_file(self, path: Path, settings: list[tuple[str, str]] | None = None) -> Document:
        """Return a model file named by the user, with ``settings`` (path and value) applied. Raises
        ModelError with all faults.
        """
        path = path.resolve()
        for document in self.documents.values():
            if document.path == path:
                return document
        document = from_disk(f"file-{next(self._numbers)}", path)
        if settings:
            load(path, set=settings)  # raises with the faults of all settings
            for path_text, value in settings:
                document.set([(resolve(tomllib.loads(document.text), path_text), value)])
        self.documents[document.id] = document
        return document

    def from_text(self, name: str, text: str) -> Document:
        """Return a model that a browser has read from a file. Raises ModelError with all faults."""
        identity = f"text-{next(self._numbers)}"
        self.documents[identity] = Document(
            identity, re.sub(r"[^\w .()+-]", "_", name)[:80] or "model.toml", text
        )
        return self.documents[identity]

    def from_run(self, folder: Path, settings: list[tuple[str, str]] | None = None) -> Document:
        """Return the model of a run, with its step. Raises RunFileError, and ValueError for ``settings``."""
        mechanism, step = model_of(folder, settings or [])
        identity = f"run-{next(self._numbers)}"
        self.documents[identity] = Document(identity, folder.resolve().name, dump(mechanism), step=step)
        return self.documents[identity]

    def place(self, name: str) -> Path:
        """Return the path under which a model of this name is saved. Raises Conflict for an invalid file
        name.
        """
        file_name = name if name.endswith(".toml") else f"{name}.toml"
        if not NAME.fullmatch(file_name) or len(file_name) > 100:
            raise Conflict(
                "a name is letters, digits, spaces, - and _, such as my-linkage.toml; it is written into the"
                " folder of this session"
            )
        return self.folder / file_name


def from_disk(identity: str, path: Path) -> Document:
    """Return the document of a file. Raises ModelError if it cannot be read or is invalid."""
    try:
        text, status = read_bytes(path).decode("utf-8-sig"), path.stat()
    except (OSError, UnicodeDecodeError):
        load(path)  # raises with the reason
        raise
    return Document(identity, path.name, text, path, text, stamp=(status.st_mtime_ns, status.st_size))


def is_model(path: Path, folder: Path) -> bool:
    """Return whether a file of a folder is a model file, judged by its tables."""
    try:
        inside = path.resolve().parent == folder and path.is_file() and path.stat().st_size <= LARGEST
    except (OSError, ValueError, RecursionError):
        return False
    return inside and bool(PARTS & tables_of(path).keys())


def title_of(path: Path) -> str:
    """Return the name that a model file gives itself; "" if it gives none."""
    return str(tables_of(path).get("name", ""))


def tables_of(path: Path) -> Json:
    """Return the tables of a TOML file; none of a file that cannot be read."""
    try:
        return tomllib.loads(read_bytes(path, LARGEST).decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}


def heading(mechanism: Mechanism) -> Json:
    """Return title, note and type of analysis of a mechanism."""
    return {
        "title": mechanism.name,
        "note": mechanism.note,
        "static": mechanism.settings.analysis == "static",
    }
