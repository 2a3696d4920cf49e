"""From text to a callable: compiled and cached on disk, or interpreted.

A text is written to a file in a folder named by its hash, numba version and processor, and compiled from there with numba's disk cache. Files
are written under another name and renamed; whatever is wrong with a cached file, it is thrown away and compiled again.
"""

from __future__ import annotations

import hashlib
import importlib.util
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .cache import cache_folder, private

HEADER = '''"""Written by vfife; compiled from its physics. Safe to delete."""
import math
import numba

lean = dict(error_model="numpy", no_rewrites=True, no_cfunc_wrapper=True, _nrt=False)
jit = numba.njit(forceinline=True, no_cpython_wrapper=True, **lean)
entry = numba.njit(cache=True, nogil=True, **lean)

'''


def key(text: str) -> str:
    """Hash of everything that decides the machine code."""
    import llvmlite
    import numba

    parts = (text, numba.__version__, llvmlite.__version__, sys.version, platform.machine())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:24]


def location(text: str) -> Path:
    """File that the cache holds for a text."""
    name = key(text)
    return cache_folder() / name / f"step_{name}.py"


def place(text: str) -> Path:
    """Writes the text where the cache holds it, or to a folder of this process's own if the cache cannot be written."""
    path = location(text)
    if private(cache_folder()) and path.exists():
        if path.read_bytes() == text.encode():
            return path
        shutil.rmtree(path.parent, ignore_errors=True)  # cut short by a crash or a full disk
    try:
        if not private(cache_folder()):
            raise OSError
        fresh = Path(tempfile.mkdtemp(prefix="new-", dir=cache_folder()))
    except OSError:
        own = Path(tempfile.mkdtemp(prefix="vfife-")) / path.name
        own.write_text(text)
        return own
    (fresh / path.name).write_text(text)
    try:
        fresh.rename(path.parent)
    except OSError:  # another process was first
        shutil.rmtree(fresh, ignore_errors=True)
    return path


def load(path: Path) -> Any:
    """The module at ``path``."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def compiled(body: str, name: str) -> Callable[..., Any]:
    """The function ``name`` of the text, compiled at its first call or read from the cache."""
    text = HEADER + named(body, name)
    return _Recovering(place(text), name, text)


def named(body: str, name: str) -> str:
    """The text with the function ``name`` as the one that is called from outside."""
    return body.replace(f"@jit\ndef {name}(", f"@entry\ndef {name}(")


def interpreted(body: str, name: str) -> Callable[..., Any]:
    """The same function run as plain Python: slow, and the same bits."""
    import math

    space: dict[str, Any] = {"math": math, "jit": lambda f: f}
    exec(compile(body, f"<vfife {name}>", "exec"), space)  # the text is our own and the user's laws, never a model file's
    function: Callable[..., Any] = space[name]
    return function


class _Recovering:
    """Calls a cached function; a cache that cannot be read is deleted and the function compiled anew, once."""

    def __init__(self, path: Path, name: str, text: str) -> None:
        self.path, self.name, self.text = path, name, text
        self.function = getattr(load(path), name)
        self.sound = False

    def __call__(self, *arguments: Any) -> Any:
        if self.sound:
            return self.function(*arguments)
        try:
            self.function.compile(tuple(_type(a) for a in arguments))
        except Exception:
            shutil.rmtree(self.path.parent / "__pycache__", ignore_errors=True)
            self.path = place(self.text)
            self.function = getattr(load(self.path), self.name)
        self.sound = True
        return self.function(*arguments)


def _type(value: Any) -> Any:
    import numba

    return numba.typeof(value)
