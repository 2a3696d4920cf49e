"""Files that save the next process work: plain text and plain object code, in a folder that its owner alone
can read and write.

A file is sealed with a hash of its name and content, and its name is a hash of all that decides the content,
so a file that was cut short, changed, renamed or left by another version is made anew. Nothing in it is
unpickled. Object code is run: who can write to the folder can run code as its owner, which is why a folder
that others own or can write to is not used.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
import re
import stat
import time
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path

from ...kernels.topology import Topology
from ..trace.source import data_driven

MAGIC = b"vfife 1\n"
MOST_BYTES = 500_000_000
ROOMY = 0.8  # of that is what is left when it was too much
KINDS = re.compile(r"(step|loop|text)-[0-9a-f]{40}\.(o|py|ptx)$|new-")  # names of files that are ours
_TROUBLE: list[str] = []
MISSED: list[Callable[[], None]] = []  # called where something has to be compiled, before it is


def cache_folder() -> Path:
    """Folder of compiled steps: ``VFIFE_CACHE``, else the user's cache folder.

    It holds nothing that changes a result.
    """
    chosen = os.environ.get("VFIFE_CACHE")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "vfife"


def private(folder: Path) -> bool:
    """Makes the folder, where it is missing, and says whether it is its owner's alone; where it cannot be
    used, :func:`trouble` says why.
    """
    try:
        fault = _fault(folder)
    except OSError as error:
        fault = error.strerror or str(error)
    _TROUBLE[:] = (
        [f"{folder}: {fault}; what is compiled is not kept, and the next run compiles it again"]
        if fault
        else []
    )
    return not fault


def _fault(folder: Path) -> str:
    """Why a folder cannot be used; empty where it can."""
    if (
        not folder.is_absolute()
    ):  # without a home, or so named: it would be another one in each working folder, and anybody's
        return "the folder of the cache has to have an absolute path (VFIFE_CACHE, XDG_CACHE_HOME or HOME)"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode):
        return "this is no folder"
    if hasattr(os, "geteuid"):
        if status.st_uid != os.geteuid():
            return "this folder belongs to another user"
        if status.st_mode & 0o022:
            return "others can write into this folder"
        if status.st_mode & 0o077:
            folder.chmod(0o700)
    return ""


def trouble() -> str:
    """Why nothing could be kept when that was last tried; empty where all is well."""
    return "".join(_TROUBLE)


def sealed(name: str, content: bytes) -> bytes:
    """A file's bytes: the content behind a hash of it and of the file's name."""
    return MAGIC + hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode() + b"\n" + content


def read(name: str) -> bytes | None:
    """Content of a file of the cache, None where there is none that is whole."""
    folder = cache_folder()
    if not private(folder):
        return None
    try:
        stored = (folder / name).read_bytes()
    except OSError:
        return None
    content = stored[len(MAGIC) + 65 :]
    if stored != sealed(name, content):
        return None
    with contextlib.suppress(OSError):
        os.utime(
            folder / name, ns=(time.time_ns(), (folder / name).stat().st_mtime_ns)
        )  # what is used stays when the cache is pruned
    return content


def missed() -> None:
    """Tells who wants to know that something is compiled now, which takes its time."""
    for listener in MISSED:
        listener()


def keep(name: str, content: bytes) -> None:
    """Writes a file of the cache under another name and renames it; where that cannot be done, the next
    process does the work again.

    What was not used for the longest time goes when all of it takes more than ``MOST_BYTES``.
    """
    folder = cache_folder()
    if not private(folder):
        return
    import tempfile

    try:
        handle, fresh = tempfile.mkstemp(prefix="new-", dir=folder)  # readable by its owner alone
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(sealed(name, content))
            os.replace(fresh, folder / name)
        except OSError:
            os.unlink(fresh)
            raise
        _prune(folder, folder / name)
    except OSError as error:
        _TROUBLE[:] = [
            f"{folder}: {error.strerror or error}; what is compiled is not kept, and the next run compiles it"
            " again"
        ]


def _prune(folder: Path, fresh: Path) -> None:
    """Removes files of the cache, those first that were not used for the longest time, until there is room
    again; never the one just made.
    """
    files = []
    for path in folder.iterdir():
        with contextlib.suppress(OSError):
            status = path.lstat()
            if stat.S_ISREG(status.st_mode):
                files.append((status.st_atime_ns, status.st_size, path))
    size = sum(one for _, one, _ in files)
    if size <= MOST_BYTES:
        return
    for _, one, path in sorted(files):
        if path != fresh and KINDS.match(path.name):
            with contextlib.suppress(OSError):
                path.unlink()
                size -= one
        if size <= ROOMY * MOST_BYTES:
            return


def digest(parts: Iterable[bytes]) -> str:
    """Name made from all that decides a content."""
    total = hashlib.sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "little") + part)
    return total.hexdigest()[:40]


@lru_cache(maxsize=1)
def sources() -> bytes:
    """Hash of the package's own texts that a step is made from: kernels, laws and writers."""
    package = Path(__file__).parents[2]
    files = sorted(
        [*package.glob("kernels/*.py"), *package.glob("compiler/**/*.py"), *package.glob("laws/**/*.py")]
    )
    return digest(
        part for file in files if file.is_file() for part in (file.name.encode(), file.read_bytes())
    ).encode()


def origin(topology: Topology) -> list[bytes]:
    """Return all that decides the text of a topology's step: package texts, topology, laws by name and, for
    laws outside the package, their text.
    """
    laws = topology.contact_laws + topology.friction_laws
    numbers = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    numbers |= {"contact_laws": "", "friction_laws": ""}
    own = not all(law.__module__.startswith("vfife.laws.") for law in laws)  # these may call anything
    names = "" if not own else data_driven(topology.contact_laws, topology.friction_laws)
    return [
        sources(),
        repr(numbers).encode(),
        repr([f"{law.__module__}.{law.__qualname__}" for law in laws]).encode(),
        names.encode(),
    ]
