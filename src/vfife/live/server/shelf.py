"""What can be looked at: the gallery, and the model files of one folder; nothing else on the machine is read
or written.
"""

from __future__ import annotations

import re
import tomllib
from itertools import count
from pathlib import Path

from ... import gallery
from ...files import read_bytes
from ...model.mechanism import Mechanism
from ...modelfile import dump, load
from ...modelfile.paths import resolve
from ..page.page_model import model_of
from .documents import LARGEST, Conflict, Document, Json

MOST = 200  # files of a folder that are looked at
NAME = re.compile(r"\w[\w .()+-]*\.toml")
PARTS = {
    "body",
    "joint",
    "driver",
    "spring",
    "gear",
    "load",
    "ground",
}  # a model file has one of these tables


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

    # --------------------------------------------------------------------------------------------------------- what there is

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
        for path in sorted(self.folder.glob("*.toml"))[:MOST]:
            if path.name not in files and is_model(path, self.folder):
                files[path.name] = path
        return files

    # ------------------------------------------------------------------------------------------------------------ opening

    def from_gallery(self, name: str) -> Document:
        """A mechanism of the gallery. Raises LookupError for a name that it has not."""
        which = f"gallery-{name}"
        if which not in self.documents:
            if name not in gallery.__all__:
                raise LookupError(name)
            self.documents[which] = Document(which, name, gallery.path(name).read_text(encoding="utf-8"))
        return self.documents[which]

    def from_folder(self, name: str) -> Document:
        """A model file of the folder. Raises LookupError for another name, ModelError for a file with faults."""
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
        """Where a model of this name is written. Raises Conflict for what is no plain name of a model file."""
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
