"""Files that save the next process work: plain text and plain object code, in a folder that its owner alone can read and write.

A file is sealed with a hash of its name and content, and its name is a hash of all that decides the content, so a file that was cut short,
changed, renamed or left by another version is made anew. Nothing in it is unpickled. Object code is run: who can write to the folder can run
code as its owner, which is why a folder that others own or can write to is not used.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

MAGIC = b"vfife 1\n"


def cache_folder() -> Path:
    """Folder of compiled steps: ``VFIFE_CACHE``, else the user's cache folder. It holds nothing that changes a result."""
    chosen = os.environ.get("VFIFE_CACHE")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "vfife"


def private(folder: Path) -> bool:
    """Makes the folder, where it is missing, and says whether it is its owner's alone; False where it cannot be used."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode):
            return False
        if hasattr(os, "geteuid"):
            if found.st_uid != os.geteuid() or found.st_mode & 0o022:
                return False
            if found.st_mode & 0o077:
                folder.chmod(0o700)
    except OSError:
        return False
    return True


def sealed(name: str, content: bytes) -> bytes:
    """A file's bytes: the content behind a hash of it and of the file's name."""
    return MAGIC + hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode() + b"\n" + content


def read(name: str) -> bytes | None:
    """Content of a file of the cache, None where there is none that is whole."""
    folder = cache_folder()
    if not private(folder):
        return None
    try:
        found = (folder / name).read_bytes()
    except OSError:
        return None
    content = found[len(MAGIC) + 65 :]
    return content if found == sealed(name, content) else None


def keep(name: str, content: bytes) -> None:
    """Writes a file of the cache under another name and renames it; where that cannot be done, the next process does the work again."""
    folder = cache_folder()
    if not private(folder):
        return
    import tempfile

    with contextlib.suppress(OSError):
        handle, fresh = tempfile.mkstemp(prefix="new-", dir=folder)  # readable by its owner alone
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(sealed(name, content))
            os.replace(fresh, folder / name)
        except OSError:
            os.unlink(fresh)


def digest(parts: Iterable[bytes]) -> str:
    """Name made from all that decides a content."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "little") + part)
    return whole.hexdigest()[:40]


@lru_cache(maxsize=1)
def sources() -> bytes:
    """Hash of the package's own texts that a step is made from: kernels, laws and writers."""
    package = Path(__file__).parents[1]
    files = sorted([*package.glob("kernels/*.py"), *package.glob("codegen/*"), *package.glob("laws/**/*.py")])
    return digest(part for file in files if file.is_file() for part in (file.name.encode(), file.read_bytes())).encode()
