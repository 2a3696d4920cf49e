"""Where a run comes from, in words that a file can keep, and a record made again from them."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly, StepChoice
from ..codegen.runner import compiler_of
from ..errors import RunFileError
from ..kernels.blocks import BY_NAME
from ..laws.stored import kept as kept_laws
from ..laws.stored import standing_in
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..modelfile import dump, loads
from ..solvers.record import Record, Rows
from ..solvers.status import Status
from .runfile import RunFile
from .start import COUNTED, assembly_of, kept_assembly, present_name, state_of


def versions(loop: str = "generated") -> dict[str, str]:
    """Versions of what computes a run by a loop; no large library is imported for it."""
    from .. import __version__

    return {"python": sys.version.split()[0], "vfife": __version__, "numpy": np.__version__, **compiler_of(loop)}


def provenance(assembly: Assembly, kept: NDArray[np.uint32], loop: str, model: str | None = None) -> dict[str, Any]:
    """What a run file's meta should hold to read the run again, and to run it again; of the user's own laws also the text of their files.

    ``kept`` is stored by the names of blocks, so that a later order of rows does not matter. ``model`` is the text of the mechanism where it is
    written already. Raises ValueError for a mechanism that no model file can hold.
    """
    return {
        "model": dump(assembly.mechanism) if model is None else model,
        "source": assembly.mechanism.source,
        "versions": versions(loop),
        "step": assembly.choice.step,
        "choice": dataclasses.asdict(assembly.choice),
        "loop": loop,
        "kept": named_rows(assembly, kept),
        "laws": sources(assembly.mechanism),
        "notes": list(assembly.notes),
        "own_laws": own_laws(assembly.mechanism),
        **kept_assembly(assembly),
    }


def own_laws(mechanism: Mechanism) -> list[dict[str, Any]]:
    """The user's own laws in a mechanism, with the text of their files."""
    joints = mechanism.contacts.values()
    return kept_laws([(law, surfaces(mechanism, joint)) for joint in joints for law in (joint.contact, joint.friction)])


def sources(mechanism: Mechanism) -> dict[str, str]:
    """Source of each law, by joint and name."""
    joints = mechanism.contacts.values()
    return {f"{joint.name}.{law.name}": law.source for joint in joints for law in (joint.contact, joint.friction)}


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


def restored(meta: Mapping[str, Any], steps: NDArray[np.int64], rows: Rows | Callable[[], Rows], where: str) -> Record:
    """The record of which a file kept the meta, the steps and the rows, or what reads them; ``where`` names the file in messages.

    The model is read and not assembled, unless the file is one of version 0.1 and before. Raises RunFileError where the model cannot be read by
    this version, or was recorded with quantities it does not know.
    """
    wanted = ("model", "choice", "kept", *(("start", "tables") if "assembly" in meta else ()))
    if missing := [key for key in wanted if key not in meta]:
        raise RunFileError(f"{where}: the run ended before it said what it runs, or that is damaged ({', '.join(missing)}); run the model again")
    if len(steps) and steps[0] != 0:
        raise RunFileError(f"{where}: this run file is damaged (its first output is lost, from which energies count); run the model again")
    if not len(steps):
        raise RunFileError(f"{where}: the run ended before its first output; run the model again")
    pairs = {name: tuple((first, second) for first, second in meta["choice"].get(name, ())) for name in ("limits", "tried")}
    choice = StepChoice(**{**meta["choice"], **pairs})
    mechanism = _mechanism(meta, where)
    assembly = assembly_of(meta, mechanism, choice, where) if "assembly" in meta else _assembled(meta, mechanism, choice, where)
    kept = rows_named(assembly, meta["kept"], where)
    if not isinstance(rows, np.ndarray):
        return _record(meta, assembly, steps, rows, kept, where)
    if rows.shape[1] != len(kept) or len(rows) != len(steps):
        raise RunFileError(f"{where}: {rows.shape[1]} rows were recorded and {len(kept)} are named; run the model again")
    counted = np.repeat([name in COUNTED for name, _ in meta["kept"]], [count for _, (_, count) in meta["kept"]])
    if counted.any():
        rows = np.where(counted, rows * choice.step, rows)
    return _record(meta, assembly, steps, rows, kept, where)


def _record(
    meta: Mapping[str, Any], assembly: Assembly, steps: NDArray[np.int64], rows: Rows | Callable[[], Rows], kept: NDArray[np.uint32], where: str
) -> Record:
    wall, loop, message = float(meta.get("wall", 0.0)), str(meta.get("loop", "")), str(meta.get("message", ""))
    return Record(assembly, steps, rows, kept, wall, loop, status_of(meta, where), message=message)


def final_state(meta: Mapping[str, Any], assembly: Assembly, values: Rows, where: str) -> Rows | None:
    """S of a checkpoint; None where a file of version 0.1 has another number of rows than the model has today."""
    if "assembly" in meta:
        return state_of(assembly.layout, meta["assembly"]["blocks"], values, where)
    return values if len(values) == assembly.layout.rows else None


def status_of(meta: Mapping[str, Any], where: str) -> Status:
    """How the run of a file ended. Raises RunFileError for a word that this version does not know."""
    text = str(meta.get("status", Status.COMPLETE))
    try:
        status = Status(text)
    except ValueError:
        raise RunFileError(
            f"{where}: the run is said to be {text!r}, which this version does not know; read it with the one that wrote it"
        ) from None
    return Status.UNFINISHED if status == Status.RUNNING else status


def _mechanism(meta: Mapping[str, Any], where: str) -> Mechanism:
    """The nouns of the model's text."""
    try:
        with standing_in(meta.get("own_laws", ())):
            mechanism = loads(meta["model"])
    except ValueError as error:
        raise RunFileError(_unreadable(meta, where, f"read: {error}")) from error
    mechanism.source = meta.get("source")
    return mechanism


def _assembled(meta: Mapping[str, Any], mechanism: Mechanism, choice: StepChoice, where: str) -> Assembly:
    """The assembly of a file that does not have it."""
    try:
        return dataclasses.replace(assemble(mechanism, choice.step, force_step=True), choice=choice)
    except ValueError as error:
        raise RunFileError(_unreadable(meta, where, f"assembled: {error}")) from error


def _unreadable(meta: Mapping[str, Any], where: str, what: str) -> str:
    by = meta.get("versions", {}).get("vfife", "another version")
    return (
        f"{where}: the model in this run file, written by vfife {by}, cannot be {what}. "
        "If it uses a law of your own, load the file that defines the law first"
    )


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


def keep_reference(file: RunFile, record: Record) -> None:
    """Stores the record of the ideal mechanism beside the run."""
    meta = provenance(record.assembly, record.kept, record.loop) | {"status": record.status, "wall": record.wall}
    file.keep_reference(meta, record.steps, record.rows)
