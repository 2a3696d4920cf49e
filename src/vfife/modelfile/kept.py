"""Files that commands keep things in, where a text was meant: what each is, and what reads it."""

from __future__ import annotations

from ..errors import Fault

SQLITE, MARK = b"SQLite format 3\0", slice(68, 72)  # how such a file begins, and where its header says whose it is
KEPT = {
    b"VFIF": ("this is what a run was kept in", "see vfife info, plot, report, impacts and resume, or name its model.toml"),
    b"VFST": ("this is what a study was kept in", "see vfife study show, plot, export, resume and add, or name its STUDY.toml"),
    b"VFMP": ("this is what a map was kept in", "see vfife map show, or name its model"),
}


def kept(data: bytes) -> Fault | None:
    """The fault that one of our own files is, whatever was meant to be read; None for any other file."""
    if not data.startswith(SQLITE) or data[MARK] not in KEPT:
        return None
    what, remedy = KEPT[data[MARK]]
    return Fault("file", what, "", "a text", remedy)
