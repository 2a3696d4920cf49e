"""The cache of compiled code: plain text and object code, in a folder that only its owner can read and write.

The name of a file is a hash of all that decides its content, and the file is sealed with a hash of name and
content. A file that was truncated, changed, renamed, or written by another version is therefore not used but
made again. Nothing in it is unpickled. Object code is executed: whoever can write to the folder can run code
as its owner. For that reason a folder that others own or can write to is not used.
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
from . import MISSED

MAGIC = b"vfife 1\n"
MOST_BYTES = 500_000_000
ROOMY = 0.8  # share of MOST_BYTES that remains after pruning
KINDS = re.compile(r"(step|loop|text)-[0-9a-f]{40}\.(o|py|ptx)$|new-")  # names of the cache's files
_TROUBLE: list[str] = []


def cache_folder() -> Path:
    """Return the folder of compiled steps: ``VFIFE_CACHE``, else the user's cache folder.

    It contains nothing that changes a result.
    """
    chosen = os.environ.get("VFIFE_CACHE")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "vfife"


def private(folder: Path) -> bool:
    """Create the folder if it is missing; return whether only its owner can write to it. If it cannot be
    used, :func:`trouble` returns the reason.
    """
    try:
        fault = _fault(folder)
    except OSError as error:
        fault = error.strerror or str(error)
    _TROUBLE[:] = [_storage_fault(folder, fault)] if fault else []
    return not fault


def _storage_fault(folder: Path, fault: object) -> str:
    return f"{folder}: {fault}; what is compiled is not kept, and the next run compiles it again"


def _fault(folder: Path) -> str:
    """Return why a folder cannot be used; empty if it can."""
    # A relative folder would be a different one in each working folder, and possibly somebody else's.
    if not folder.is_absolute():
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
    """Return why the last attempt to store something failed; empty if it did not."""
    return "".join(_TROUBLE)


def sealed(name: str, content: bytes) -> bytes:
    """Return the bytes of a file: a hash of its name and content, and the content."""
    return MAGIC + hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode() + b"\n" + content


def read(name: str) -> bytes | None:
    """Return the content of a file of the cache, None if there is no valid one."""
    folder = cache_folder()
    if not private(folder):
        return None
    try:
        raw = (folder / name).read_bytes()
    except OSError:
        return None
    content = raw[len(MAGIC) + 65 :]
    if raw != sealed(name, content):
        return None
    # Pruning goes by the time of access, which many file systems do not record by themselves.
    with contextlib.suppress(OSError):
        os.utime(folder / name, ns=(time.time_ns(), (folder / name).stat().st_mtime_ns))
    return content


def stored(name: str, make: Callable[[], bytes]) -> bytes:
    """Return the content of a file of the cache; without one, call the listeners, make and keep it."""
    content = read(name)
    if content is None:
        for listener in MISSED:
            listener()
        content = make()
        keep(name, content)
    return content


def keep(name: str, content: bytes) -> None:
    """Write a file of the cache, under another name first and renamed when it is complete. If that fails, the
    next process compiles again.

    If the cache exceeds ``MOST_BYTES``, the files that were not used for the longest time are removed.
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
        _TROUBLE[:] = [_storage_fault(folder, error.strerror or error)]


def _prune(folder: Path, fresh: Path) -> None:
    """Remove files of the cache, the least recently used first, until it has its size; never the ``fresh``
    one.
    """
    files = []
    for path in folder.iterdir():
        with contextlib.suppress(OSError):
            status = path.lstat()
            if stat.S_ISREG(status.st_mode):
                files.append((status.st_atime_ns, status.st_size, path))
    size = sum(length for _, length, _ in files)
    if size <= MOST_BYTES:
        return
    for _, length, path in sorted(files):
        if path != fresh and KINDS.match(path.name):
            with contextlib.suppress(OSError):
                path.unlink()
                size -= length
        if size <= ROOMY * MOST_BYTES:
            return


def digest(parts: Iterable[bytes]) -> str:
    """Return a name made from all that decides a content."""
    # Each part behind its length: otherwise two lists of parts could have the same bytes.
    total = hashlib.sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "little") + part)
    return total.hexdigest()[:40]


@lru_cache(maxsize=1)
def sources() -> bytes:
    """Return a hash of the package's texts from which steps are made: kernels, laws and compiler."""
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
    foreign = not all(law.__module__.startswith("vfife.laws.") for law in laws)  # these may call anything
    names = "" if not foreign else data_driven(topology.contact_laws, topology.friction_laws)
    return [
        sources(),
        repr(numbers).encode(),
        repr([f"{law.__module__}.{law.__qualname__}" for law in laws]).encode(),
        names.encode(),
    ]
