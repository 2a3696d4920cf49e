"""What tells a run file from any other file; it loads nothing, for every command asks it."""

from __future__ import annotations

from pathlib import Path

from ..files import open_regular

RUN_FILE = "run.sqlite"  # its name in a run folder
APPLICATION = 0x56464946  # "VFIF", in the header of the file
FORMAT = 3  # 1 had no arrays, and so no start; 1 and 2 had no seals
STUDY_APPLICATION = 0x56465354  # "VFST", of a study file
STUDY_FORMAT = 2  # 1 had no tally of its rows; so of the three below
MAP_APPLICATION = 0x56464D50  # "VFMP", of a map file
MAP_FORMAT = 2
WEAR_APPLICATION = 0x56465752  # "VFWR", of a wear file
WEAR_FORMAT = 2
FIT_APPLICATION = 0x56464654  # "VFFT", of a fit file
FIT_FORMAT = 2
HEADER = 100  # bytes of SQLite's header


def is_run_file(path: Path) -> bool:
    """Whether a file is one that this program made: SQLite's header with our application id."""
    return head_of(path) is not None


def head_of(path: Path) -> bytes | None:
    """The header of a run file; None for any other file."""
    return head_with(path, APPLICATION)


def study_head(path: Path) -> bytes | None:
    """The header of a study file; None for any other file."""
    return head_with(path, STUDY_APPLICATION)


def head_with(path: Path, application: int) -> bytes | None:
    """The header of a file of SQLite with an application id; None for any other file."""
    try:
        with open_regular(path) as stream:
            head = stream.read(HEADER)
    except OSError:
        return None
    own = head.startswith(b"SQLite format 3\0") and int.from_bytes(head[68:72], "big") == application
    return head if own else None
