"""Laws from a Python file that a user names on the command line or in a script; a model file never names
code. Their code has a time limit.
"""

from __future__ import annotations

import importlib.util
import linecache
import os
import re
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from ..errors import LawError
from ..files import read_bytes
from ..options import with_faults
from .law import ContactLaw, FrictionLaw, Law, built_in
from .time_limit import SECONDS, Endless, limited

REGISTRIES = (ContactLaw.registry, FrictionLaw.registry)
LOADING = threading.RLock()  # one file at a time: the laws of a file are those that were not there before


@with_faults()
def load_laws(path: str | Path) -> list[type[Law]]:
    """Run a Python file and register the laws that it defines.

    The file may import installed packages, but no file beside it, because a run stores only its
    text.

    path: the Python file

    Returns the law classes, which models then name by their ``name``. Raises LawError with a sentence for a
    file that cannot be read or run, defines no law, or defines an unusable one; none of its laws is then
    registered.
    """
    from .check import faults_of_class  # loads the compiler, which the laws of the package do not need

    path = Path(path)
    text = read(path)
    with LOADING:
        former_registries = [dict(registry) for registry in REGISTRIES]
        try:
            module = executed(path, text)
            laws = [
                law
                for registry in REGISTRIES
                for law in registry.values()
                if law.__module__ == module.__name__
            ]
            if not laws:
                raise LawError(f"{path}: {no_law(module)}")
            for law in laws:
                for old in (registry.get(law.name) for registry in former_registries):
                    if old is not None and not built_in(old) and file_of(old) != str(path):
                        raise LawError(
                            f"{path}: there is a law {law.name!r} already, from {file_of(old)}; rename one of"
                            " them"
                        )
            faults = [fault for law in laws for fault in faults_of_class(law)]
            if faults:
                raise LawError("\n".join(faults))
        except BaseException:
            for registry, former in zip(REGISTRIES, former_registries, strict=True):
                forgotten(registry, former)
            raise
    return laws


def forgotten(registry: dict[str, type[Law]], former: dict[str, type[Law]]) -> None:
    """Restore a registry to its ``former`` state. Former entries are never missing in between, because other
    threads may read them.
    """
    registry.update(former)
    for name in [name for name in registry if name not in former]:
        del registry[name]


def read(path: Path) -> str:
    """Return the text of a file of laws. Raises LawError if it cannot be read."""
    try:
        return read_bytes(path).decode("utf-8-sig").replace("\r\n", "\n")
    except OSError as error:
        remedy = "check the name" if isinstance(error, FileNotFoundError) else "name a file that can be read"
        raise LawError(f"{path}: it cannot be read ({error.strerror}); {remedy}") from None
    except UnicodeDecodeError as error:
        raise LawError(f"{path}: byte {error.start} is not UTF-8; save the file in this encoding") from None


def executed(path: Path, text: str) -> ModuleType:
    """Execute a text as a module. It is compiled from the text that was read, so every change of the file is
    noticed.
    """
    name = f"own_laws_{re.sub(r'[^0-9A-Za-z]', '_', path.stem)}"
    spec = importlib.util.spec_from_file_location(name, path) or ModuleSpec(name, None, origin=str(path))
    module = importlib.util.module_from_spec(spec)
    module.__file__ = str(path)
    # Functions find their text here; without a time of change it stays as it was read.
    linecache.cache[str(path)] = (len(text), None, text.splitlines(keepends=True), str(path))
    sys.modules[name] = module  # dataclasses look their module up
    try:
        code = compile(text, str(path), "exec", dont_inherit=True)
        with watched():
            exec(code, module.__dict__)  # the user named this file to have it run
    except Endless:
        raise LawError(
            f"{path}: it has run for {SECONDS:g} s and does not end; a file of laws defines them, and"
            " computes nothing"
        ) from None
    except SyntaxError as error:
        line = f" in `{error.text.strip()}`" if error.text else ""
        raise LawError(
            f"{path}, line {error.lineno}: this is not valid Python: {error.msg}{line}; correct it"
        ) from None
    except ImportError as error:
        remedy = (
            "a file of laws may import what is installed, and nothing that lies beside it: write it into the"
            " file"
        )
        raise LawError(f"{path}, line {line_of(error, path)}: {error}; {remedy}") from None
    except (Exception, SystemExit) as error:
        message = str(error) or "nothing said"
        sentence = (
            f"{path}, line {line_of(error, path)}:"
            f" {message if isinstance(error, ValueError) else f'{type(error).__name__}: {message}'}"
        )
        raise LawError(sentence) from None
    return module


@contextmanager
def watched() -> Iterator[None]:
    """Limit the time of the code, and turn os._exit into an exception."""

    def leave(status: int) -> NoReturn:
        raise SystemExit(f"it ends the process (os._exit({status!r}))")

    ends = os._exit
    try:
        os._exit = leave
        with limited(SECONDS):
            yield
    finally:
        os._exit = ends


def line_of(error: BaseException, path: Path) -> int | str:
    """Return the line of the file at which its code failed."""
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
    ]
    return lines[-1] if lines and lines[-1] is not None else "?"


def no_law(module: ModuleType) -> str:
    """Return why a module defines no law."""
    for name, value in vars(module).items():
        if isinstance(value, type) and issubclass(value, Law) and value.__module__ == module.__name__:
            return f'{name} has no name that a model could use; give it name = "my-law"'
    return (
        "it defines no law; a law is a frozen dataclass that inherits from vfife.laws.ContactLaw or"
        " vfife.laws.FrictionLaw and has a name"
    )


def file_of(law: type[Law]) -> str:
    """Return the name of the file with a law's function."""
    return str(getattr(getattr(law, "force", None), "__code__", None) and law.force.__code__.co_filename)  # type: ignore[attr-defined]


def text_of(law: type[Law]) -> str | None:
    """Return the text of the file with a law's function; None without one, as for a law typed at a prompt."""
    lines = linecache.getlines(file_of(law))
    return "".join(lines) if lines else None
