"""Errors of the package and how they are reported: place, fault, value, limit and remedy.

Every error of this package is a :class:`VfifeError`, which is a ``ValueError``.
"""

from __future__ import annotations

import difflib
import json
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Any, TypeVar

Path = tuple[str | int, ...]
Class = TypeVar("Class", bound=type)
MOST_FAULTS = 100  # further faults are counted, but not listed
LEAST_BEGINNING = 3  # letters of a name that may be the beginning of another
ENTRY = re.compile(r"(?<=[\w\]])\[(\d+)\]")  # the index of an entry of a list, counted from 0
MOST_NAMES = 1000  # names looked through for one that looks alike


class VfifeError(ValueError):
    """Base of all errors that this package raises on purpose."""


class LawError(VfifeError):
    """A law that cannot be used: which law, which parameter (``faults``) or which file and line, why, and the
    remedy.
    """

    def __init__(self, message: str, faults: Sequence[Fault] = ()) -> None:
        super().__init__(message)
        self.faults = tuple(faults)


class SourceError(VfifeError):
    """A law's function uses something that cannot be compiled into the step."""


class AssemblyError(VfifeError):
    """No position or motion satisfies the joints and drives.

    `joints` are the names of the joints that fail; `gaps` are their open distances in m (empty for a motion).
    """

    def __init__(self, message: str, joints: Sequence[str] = (), gaps: Sequence[float] = ()) -> None:
        super().__init__(message)
        self.joints = tuple(joints)
        self.gaps = tuple(gaps)


class StepError(VfifeError):
    """A step that is larger than the stable one."""


class RunFileError(VfifeError):
    """A run file that cannot be read or written: cause, place and remedy."""


class DamageWarning(UserWarning):
    """Parts of a file are damaged or missing; the rest is used."""


class HeldError(VfifeError):
    """A run folder that another process is writing to."""


class ResumeError(VfifeError):
    """A run that cannot be continued, because it is complete, has diverged, or its file is damaged."""


class DeviceError(VfifeError):
    """A graphics card that cannot be used, or not for this amount of work: operation, cause and remedy."""


class StorageError(RunFileError):
    """A file that cannot be read or written because of the disk, its permissions or another writer: space
    needed and free, and what remains.
    """


class Fault(VfifeError):
    """One fault: its place, what is wrong, the value as written, the limit and the remedy.

    ``where`` is a text, or a path of keys, which is stored as ``path``; ``line`` is that of the file. A fault
    is raised where a single value is read, and collected in a :class:`ModelError` where a whole file is read.
    """

    line: int | None = None

    def __init__(
        self, where: str | Path, what: str, value: str = "", limit: str = "", remedy: str = ""
    ) -> None:
        self.path = where if isinstance(where, tuple) else ()
        self.where = place(where) if isinstance(where, tuple) and where else str(where or "")
        self.what, self.value, self.limit, self.remedy = what, value, limit, remedy
        super().__init__(self.where, what, value, limit, remedy)

    def at(self, location: str | Path, overrides: Iterable[Path] = (), *, value: str = "") -> Fault:
        """Return the same fault at another place, with ``value`` if it has none. A path among ``overrides``,
        which do not stand in the file, is marked.
        """
        fault = Fault(location, self.what, self.value or value, self.limit, self.remedy)
        if isinstance(location, tuple):
            fault.where = place(location, overrides)
        return fault

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Fault) and self._parts == other._parts

    def __hash__(self) -> int:
        return hash(self._parts)

    @property
    def _parts(self) -> tuple[str, ...]:
        return self.where, self.what, self.value, self.limit, self.remedy

    def __repr__(self) -> str:
        return f"Fault{self._parts}"

    def __str__(self) -> str:
        value = f" = {self.value}" if self.value and self.where else self.value
        limit = f"; allowed: {self.limit}" if self.limit else ""
        remedy = f". {self.remedy[0].upper()}{self.remedy[1:]}" if self.remedy else ""
        end = "" if f"{self.what}{limit}{remedy}".endswith(("?", ".", "!")) else "."
        begin = f"{self.where}{value}{entry_number(self.where)}: " if self.where or value else ""
        return printable(f"{begin}{self.what}{limit}{remedy}{end}")


def entry_number(where: str) -> str:
    """Return the entry of a list at a place, counted from 1: " (entry 4)" of "values[3]"; "" of others."""
    numbers = [str(int(index) + 1) for index in ENTRY.findall(where)]
    return f" (entry {', in it '.join(numbers)})" if numbers else ""


def article(word: Any) -> str:
    """Return a word with its indefinite article."""
    return f"{'an' if str(word)[:1] in 'aeiou' else 'a'} {word}"


def printable(text: str) -> str:
    """Return a text with control characters and direction marks escaped."""
    return "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text)


class ModelError(VfifeError):
    """All faults of a model file; ``file`` is its name as the user knows it."""

    def __init__(self, faults: Sequence[Fault], file: str = "model") -> None:
        self.faults, self.file = list(faults), file
        count = len(self.faults)
        lines = [
            f"{file}, {f'line {fault.line}, ' if fault.line else ''}{fault}"
            for fault in self.faults[:MOST_FAULTS]
        ]
        if count > 1:
            lines = [f"{file} has {count} faults:", *(f"  {k}. {line}" for k, line in enumerate(lines, 1))]
        if count > MOST_FAULTS:
            lines.append(f"  ... and {count - MOST_FAULTS} more")
        super().__init__("\n".join(lines))


class ArgumentError(ModelError, TypeError):
    """Unknown or missing arguments of a function, such as a misspelt keyword."""


def place(path: Path, overrides: Iterable[Path] = ()) -> str:
    """Return table and key of a path: ("joint", "C", "clearance") is "[joint.C] clearance".

    An empty last part denotes the table itself. A value of ``overrides``, which does not stand in the file,
    is marked.
    """
    parts = list(path)
    first = next((k for k, part in enumerate(parts) if isinstance(part, int) and k), len(parts))
    inside = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts[first:]).rstrip(
        "."
    )
    key = f"{parts[first - 1]}{inside}" if parts else "file"
    table = f"[{'.'.join(map(str, parts[: first - 1]))}]" if first > 1 else ""
    mark = " (given by set)" if any(path[: len(start)] == start for start in overrides) else ""
    return f"{table} {key}".strip() + mark


def suggestion(name: object, candidates: Iterable[str], advice: str) -> str:
    """Return "did you mean" with similar names, else the advice and some of the existing names."""
    names = list(dict.fromkeys(map(str, islice(candidates, MOST_NAMES))))
    word = str(name)[:100]
    similar = difflib.get_close_matches(word, names, 3, 0.55)
    if not similar and len(word) >= LEAST_BEGINNING:
        similar = [candidate for candidate in names if candidate.startswith(word)][:3]
    if similar:
        return "did you mean " + " or ".join(map(shown, similar)) + "?"
    if not names:
        return advice
    listed = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
    return f"{advice}; there is {listed}" if len(names) == 1 else f"{advice}; there are {listed}"


def shown(value: Any) -> str:
    """Return a value as a model file shows it, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{key} = ..." for key in list(value)[:3])
            + (", ..." if len(value) > 3 else "")
            + "}"
        )
    if isinstance(value, list | tuple):
        flat = ["[...]" if isinstance(entry, list | tuple) else shown(entry) for entry in value[:4]]
        return "[" + ", ".join(flat) + (", ..." if len(value) > 4 else "") + "]"
    try:
        text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    except ValueError:  # Python writes no integers of more than some thousand digits
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def kind_of(value: Any) -> str:
    """Return the type of a TOML value in words."""
    for kind, words in _KINDS:
        if isinstance(value, kind):
            return words
    return "a date or time" if type(value).__module__ == "datetime" else f"a {type(value).__name__}"


def value_fault(value: Any, limit: str, remedy: str, problem: str = "") -> Fault:
    """Return the fault of a value that is ``problem``, by default of another type than allowed."""
    return Fault("", f"this is {problem or kind_of(value)}", shown(value), limit, remedy)


_KINDS: tuple[tuple[type, str], ...] = (
    (bool, "true or false"),
    (int, "a whole number"),
    (float, "a number"),
    (str, "a text"),
    (list, "a list"),
    (tuple, "a list"),
    (dict, "a table"),
    (type(None), "None"),
)


def former_names(**names: str) -> Callable[[Class], Class]:
    """Return a class decorator: attributes can be read by their former names, with a DeprecationWarning.

    ``names``: the present name by the former one.
    """

    def attribute(self: object, name: str) -> Any:
        if name not in names:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        text = (
            f"{type(self).__name__}.{name} is {names[name]} now; the old name will be removed in the next"
            " version"
        )
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return getattr(self, names[name])

    def decorate(owner: Class) -> Class:
        owner.__getattr__ = attribute  # type: ignore[attr-defined]
        return owner

    return decorate


def __getattr__(name: str) -> type[Fault]:
    if name == "QuantityError":
        warnings.warn(
            "QuantityError is Fault now; the old name will be removed in the next version",
            DeprecationWarning,
            stacklevel=2,
        )
        return Fault
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
