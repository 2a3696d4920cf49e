"""Where a run comes from, in words that a file can keep, and a record made again from them."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from importlib import metadata
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly, StepChoice
from ..errors import RunFileError
from ..kernels.arrays import BY_NAME
from ..model.mechanism import Mechanism
from ..solvers.record import Record
from .runfile import RunFile

# Names of blocks in run files of version 0.1 and before.
OLD_ENTITIES = {"clearance": "contact", "ideal": "joint", "element": "frame", "row": "constraint"}
OLD_NAMES = {"clearance_contact": "contact_slots"}


def versions() -> dict[str, str]:
    """Versions of what computes a run; nothing is imported for it."""
    found = {"python": sys.version.split()[0]}
    for name in ("vfife", "numba", "numpy"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            from .. import __version__

            found[name] = __version__ if name == "vfife" else "not installed"
    return found


def provenance(assembly: Assembly, kept: NDArray[np.uint32], loop: str) -> dict[str, Any]:
    """What a run file's meta should hold to read the run again, and to run it again; of the user's own laws also the text of their files.

    ``kept`` is stored by the names of blocks, so that a later order of rows does not matter. Raises ValueError for a
    mechanism that no model file can hold.
    """
    from ..laws.stored import kept as kept_laws
    from ..model.surfaces import surfaces
    from ..modelfile import dump

    joints = assembly.mechanism.contacts.values()
    pairs = [(law, surfaces(assembly.mechanism, joint)) for joint in joints for law in (joint.contact, joint.friction)]
    laws = {f"{joint.name}.{law.name}": law.source for joint in joints for law in (joint.contact, joint.friction)}
    return {
        "model": dump(assembly.mechanism),
        "source": assembly.mechanism.source,
        "versions": versions(),
        "step": assembly.choice.step,
        "choice": dataclasses.asdict(assembly.choice),
        "loop": loop,
        "kept": named_rows(assembly, kept),
        "laws": laws,
        "notes": list(assembly.notes),
        "own_laws": kept_laws(pairs),
    }


def named_rows(assembly: Assembly, kept: NDArray[np.uint32]) -> list[tuple[str, tuple[int, int]]]:
    """The kept rows as runs of a block: its name, the first of its rows and how many follow one another."""
    layout = assembly.layout
    names = list(BY_NAME)
    block, entity = np.zeros(layout.rows, dtype=int), np.zeros(layout.rows, dtype=int)
    for k, name in enumerate(names):
        where = layout.rows_of(name)
        block[where] = k
        entity[where] = np.arange(len(where))
    b, e = block[kept], entity[kept]
    starts = np.flatnonzero(np.r_[True, (np.diff(b) != 0) | (np.diff(e) != 1)]) if len(kept) else np.zeros(0, dtype=int)
    counts = np.diff(np.r_[starts, len(kept)])
    return [(names[b[at]], (int(e[at]), int(count))) for at, count in zip(starts, counts, strict=True)]


def restored(meta: Mapping[str, Any], steps: NDArray[np.int64], rows: NDArray[np.float64], where: str) -> Record:
    """The record of which a file kept the meta, the steps and the rows; ``where`` names the file in messages.

    Raises RunFileError where the model cannot be assembled by this version, or was recorded with quantities it does
    not know.
    """
    wanted = ("model", "choice", "kept")
    if missing := [key for key in wanted if key not in meta]:
        raise RunFileError(f"{where}: the run ended before it said what it runs ({', '.join(missing)}); run the model again")
    if not rows.size:
        raise RunFileError(f"{where}: the run ended before its first output; run the model again")
    choice = StepChoice(**{**meta["choice"], "limits": tuple((name, value) for name, value in meta["choice"]["limits"])})
    assembly = dataclasses.replace(_assembled(meta, choice, where), choice=choice)
    kept = rows_named(assembly, meta["kept"], where)
    if rows.shape[1] != len(kept) or len(rows) != len(steps):
        raise RunFileError(f"{where}: {rows.shape[1]} rows were recorded and {len(kept)} are named; run the model again")
    status = "unfinished" if meta.get("status") == "running" else str(meta.get("status", "complete"))
    return Record(assembly, steps, rows, kept, float(meta.get("wall", 0.0)), str(meta.get("loop", "")), status)


def _assembled(meta: Mapping[str, Any], choice: StepChoice, where: str) -> Assembly:
    from ..assembly.assemble import assemble
    from ..laws.stored import standing_in
    from ..modelfile import loads

    try:
        with standing_in(meta.get("own_laws", ())):
            mechanism: Mechanism = loads(meta["model"])
            mechanism.source = meta.get("source")
            return assemble(mechanism, choice.step, force_step=True)
    except ValueError as error:
        by = meta.get("versions", {}).get("vfife", "another version")
        raise RunFileError(
            f"{where}: the model in this run file, written by vfife {by}, cannot be assembled: {error}. "
            "If it uses a law of your own, load the file that defines the law first"
        ) from error


def rows_named(assembly: Assembly, runs: list[tuple[str, tuple[int, int]]], where: str) -> NDArray[np.uint32]:
    """Rows of S of runs of a block, as :func:`named_rows` gives them."""
    layout = assembly.layout
    rows = {name: layout.rows_of(name) for name in BY_NAME}
    runs = [(present_name(name), where_to) for name, where_to in runs]
    unknown = sorted({name for name, (first, count) in runs if first + count > len(rows.get(name, ()))})
    if unknown:
        raise RunFileError(
            f"{where}: it records {', '.join(unknown)}, which this version does not know for this model; "
            "read it with the version it names, or run the model again"
        )
    parts = [np.array(rows[name][first : first + count], dtype=np.uint32) for name, (first, count) in runs]
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.uint32)


def present_name(name: str) -> str:
    """What a block is called today; run files keep the names of their time."""
    if name in BY_NAME:
        return name
    entity, _, rest = name.partition("_")
    return OLD_NAMES.get(name) or f"{OLD_ENTITIES.get(entity, entity)}_{rest}"


def keep_reference(file: RunFile, record: Record) -> None:
    """Stores the record of the ideal mechanism beside the run."""
    meta = provenance(record.assembly, record.kept, record.loop) | {"status": record.status, "wall": record.wall}
    file.keep_reference(meta, record.steps, record.rows)
