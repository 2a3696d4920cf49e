"""Conversion of a run to the meta of its file and back: its origin, its assembly, its companions.

The assembly is stored as names, integers, parameters and its start state, so that reading a run parses no
model and assembles nothing. States are stored block by block under the names of the blocks, so that another
order of rows, new blocks and blocks that no longer exist do not matter.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import forms
from ..assembly.assembled import Assembly, BodyMap, StepChoice
from ..compiler.runtime.loops import compiler_of
from ..errors import ResumeError, RunFileError
from ..kernels.arrays import Layout
from ..kernels.blocks import BY_NAME
from ..kernels.topology import Topology
from ..kinematics.mobility import Mobility
from ..laws import ContactLaw, FrictionLaw
from ..laws.stored import law_entries as kept_laws
from ..laws.stored import standing_in
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..modelfile import dump, loads
from ..solvers.companions import (
    CompanionOutputs,
    Companions,
    Parting,
    companion_rows,
    oldest_needed,
    turn_end_steps,
)
from ..solvers.record import Checkpoint, Record, Rows, lasting_blocks, lasting_rows
from ..solvers.repeating import turn_grid
from ..solvers.status import Status
from ..store.runfile import RunFile

NAMES = ("contacts", "ideals", "pivots", "springs", "contact_joints", "notes", "missing_joints", "shared")
# Fields of a topology that follow from the laws of the model.
OF_LAWS = ("contact_laws", "friction_laws", "contact_form", "friction_form")

# -------------------------------------------------------------------------------------------- what is written


def versions(loop: str = "generated") -> dict[str, str]:
    """Return the versions of the programs that compute a run by a loop; no large library is
    imported for it.
    """
    from .. import __version__

    return {
        "python": sys.version.split()[0],
        "vfife": __version__,
        "numpy": np.__version__,
        **compiler_of(loop),
    }


def provenance(
    assembly: Assembly, recorded: NDArray[np.uint32], loop: str, model: str | None = None
) -> dict[str, Any]:
    """Return the meta of a run file, from which the run can be read and repeated, with the files of the
    user's own laws.

    ``model`` is the text of the mechanism, if known. Raises ValueError for a mechanism that no model file can
    hold.
    """
    return {
        "model": dump(assembly.mechanism) if model is None else model,
        "source": assembly.mechanism.source,
        "versions": versions(loop),
        "step": assembly.choice.step,
        "choice": dataclasses.asdict(assembly.choice),
        "loop": loop,
        "kept": named_rows(assembly, recorded),
        "laws": sources(assembly.mechanism),
        "notes": list(assembly.notes),
        "own_laws": own_laws(assembly.mechanism),
        **assembly_meta(assembly),
    }


def own_laws(mechanism: Mechanism) -> list[dict[str, Any]]:
    """User laws of a mechanism, with the text of their files."""
    joints = mechanism.contacts.values()
    return kept_laws(
        [(law, surfaces(mechanism, joint)) for joint in joints for law in (joint.contact, joint.friction)]
    )


def sources(mechanism: Mechanism) -> dict[str, str]:
    """Return the source of each law, by joint and name."""
    joints = mechanism.contacts.values()
    return {
        f"{joint.name}.{law.name}": law.source for joint in joints for law in (joint.contact, joint.friction)
    }


def named_rows(assembly: Assembly, recorded: NDArray[np.uint32]) -> list[tuple[str, tuple[int, int]]]:
    """Group recorded rows into runs of one block: its name, its first row and the number of
    consecutive rows.
    """
    layout = assembly.layout
    names = list(BY_NAME)
    block, entity = np.zeros(layout.rows, dtype=int), np.zeros(layout.rows, dtype=int)
    for k, name in enumerate(names):
        rows = layout.rows_of(name)
        block[rows] = k
        entity[rows] = np.arange(len(rows))
    b, e = block[recorded], entity[recorded]
    starts = (
        np.flatnonzero(np.r_[True, (np.diff(b) != 0) | (np.diff(e) != 1)])
        if len(recorded)
        else np.zeros(0, dtype=int)
    )
    counts = np.diff(np.r_[starts, len(recorded)])
    return [(names[b[at]], (int(e[at]), int(count))) for at, count in zip(starts, counts, strict=True)]


def assembly_meta(assembly: Assembly) -> dict[str, Any]:
    """Return the entries of a run file's meta for an assembly: ``assembly`` for JSON, ``start`` and
    ``tables`` as arrays.
    """
    mobility, blocks = assembly.mobility, lasting_blocks(assembly.layout)
    topology = {
        field.name: getattr(assembly.topology, field.name)
        for field in dataclasses.fields(Topology)
        if field.name not in OF_LAWS
    }
    entries = {
        "topology": topology,
        "blocks": [(name, len(rows)) for name, rows in blocks],
        "bodies": [dataclasses.asdict(body) for body in assembly.bodies.values()],
        "mobility": None if mobility is None else dataclasses.asdict(mobility),
        **{name: getattr(assembly, name) for name in NAMES},
    }
    return {
        "assembly": entries,
        "start": assembly.state[lasting_rows(assembly.layout)],
        "tables": assembly.tables,
    } | (
        {}
        if assembly.companion_states is None
        else {"companion_starts": assembly.companion_states[lasting_rows(assembly.layout)]}
    )


def companions_meta(
    assembly: Assembly,
    counts: NDArray[np.int64],
    earlier: Mapping[str, tuple[float, float]],
    tries: Mapping[str, tuple[float, float]],
    rows: NDArray[np.uint32] | None = None,
) -> dict[str, Any]:
    """Return the entry of a run file's meta for its companions, with the names of their ``rows``, the ranges
    of the try before (``earlier``) and of all ``tries``; nothing without companions.
    """
    if not len(counts):
        return {}
    names = named_rows(assembly, companion_rows(assembly) if rows is None else rows)
    return {
        "companions": {
            "counts": [int(count) for count in counts],
            "kept": names,
            "earlier": dict(earlier),
            "tries": dict(tries),
        }
    }


def companion_rows_of(record: Record) -> CompanionOutputs | None:
    """Return the rows of the companions of a record, for a run file that is written at its end."""
    companions = record.companions
    if companions is None:
        return None
    grid, turns = turn_grid(record.assembly), companions.turns
    ends = () if grid is None else turn_end_steps(record.assembly, grid, 1, len(turns))
    oldest = oldest_needed(record.assembly, int(record.steps[-1]))
    return CompanionOutputs(companions.rows, companions.findings, oldest, turns, 1, ends)


def keep_reference(file: RunFile, record: Record) -> None:
    """Write the record of the ideal mechanism into the file of the run."""
    meta = provenance(record.assembly, record.row_numbers, record.loop) | {
        "status": record.status,
        "wall": record.wall,
    }
    file.keep_reference(meta, record.steps, record.rows)


# ----------------------------------------------------------------------------------------------- what is read


def restored(
    meta: Mapping[str, Any], steps: NDArray[np.int64], rows: Rows | Callable[[], Rows], place: str
) -> Record:
    """Make a record of the meta, the steps and the rows of a file, or a function that reads these; ``place``
    names the file.

    The model is read and not assembled. Raises RunFileError if this version cannot read the model or does not
    know a recorded quantity.
    """
    if missing := [
        key for key in ("model", "choice", "kept", "assembly", "start", "tables") if key not in meta
    ]:
        raise RunFileError(
            f"{place}: the description of the run is missing or damaged ({', '.join(missing)});"
            " run the model again"
        )
    if len(steps) and steps[0] != 0:
        raise RunFileError(
            f"{place}: this run file is damaged (its first output is lost, from which energies count); run"
            " the model again"
        )
    if not len(steps):
        raise RunFileError(f"{place}: the run ended before its first output; run the model again")
    pairs = {
        name: tuple((first, second) for first, second in meta["choice"].get(name, ()))
        for name in ("limits", "tried")
    }
    try:
        with standing_in(meta.get("own_laws", ())):
            mechanism = loads(meta["model"])
    except ValueError as error:
        by = meta.get("versions", {}).get("vfife", "another version")
        raise RunFileError(
            f"{place}: the model in this run file, written by vfife {by}, cannot be read: {error}. "
            "If it uses a law of your own, load the file that defines the law first"
        ) from error
    mechanism.source = meta.get("source")
    assembly = assembly_of(meta, mechanism, StepChoice(**{**meta["choice"], **pairs}), place)
    recorded = rows_named(assembly, meta["kept"], place)
    if isinstance(rows, np.ndarray) and (rows.shape[1] != len(recorded) or len(rows) != len(steps)):
        raise RunFileError(
            f"{place}: {rows.shape[1]} rows were recorded and {len(recorded)} are named; run the model again"
        )
    wall = float(meta.get("wall", 0.0))
    loop = str(meta.get("loop", ""))
    message = str(meta.get("message", ""))
    record = Record(assembly, steps, rows, recorded, wall, loop, status_of(meta, place), message=message)
    record.snaps = tuple((float(start), float(end)) for start, end in meta.get("snaps", ()))
    record.unstable = tuple((float(factor), state) for factor, state in meta.get("unstable", ()))
    return record


def final_state(meta: Mapping[str, Any], assembly: Assembly, values: Rows, place: str) -> Rows:
    """Return the state S of a checkpoint."""
    return state_of(assembly.layout, meta["assembly"]["blocks"], values, place)


def last_state(file: RunFile, record: Record) -> Checkpoint | None:
    """Return the latest checkpoint of a file, with that of all companions, as a copy of the file can hold it.

    None without one, where outputs follow it, and where its blocks are those of another version.
    """
    last, layout = file.latest(), record.assembly.layout
    if last is None or last.step < record.steps[-1]:
        return None
    blocks = [(name, len(rows)) for name, rows in lasting_blocks(layout)]
    stored = [(name, count) for name, count in file.meta["assembly"]["blocks"]]
    return Checkpoint(last.step, last.values, last.extra) if stored == blocks else None


def status_of(meta: Mapping[str, Any], place: str) -> Status:
    """Return the status with which the run of a file ended. Raises RunFileError for one unknown to this
    version.
    """
    text = str(meta.get("status", Status.COMPLETE))
    try:
        status = Status(text)
    except ValueError:
        raise RunFileError(
            f"{place}: the status of the run is {text!r}, which this version does not know; read it with the"
            " one that wrote it"
        ) from None
    return Status.UNFINISHED if status == Status.RUNNING else status


def rows_named(assembly: Assembly, runs: list[tuple[str, tuple[int, int]]], place: str) -> NDArray[np.uint32]:
    """Return the rows of S, from the runs of blocks of :func:`named_rows`."""
    layout = assembly.layout
    rows = {name: layout.rows_of(name) for name in BY_NAME}
    unknown = sorted({name for name, (first, count) in runs if first + count > len(rows.get(name, ()))})
    if unknown:
        raise RunFileError(
            f"{place}: it records {', '.join(unknown)}, which this version does not know for this model; "
            "read it with the version it names, or run the model again"
        )
    parts = [np.array(rows[name][first : first + count], dtype=np.uint32) for name, (first, count) in runs]
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.uint32)


def assembly_of(meta: Mapping[str, Any], mechanism: Mechanism, choice: StepChoice, place: str) -> Assembly:
    """Make an assembly of its entries in a file; ``place`` names the file. Raises RunFileError if they do not
    fit.
    """
    entries = _tuples(meta["assembly"])
    joints = [mechanism.contacts[name] for name in entries["contact_joints"]]
    contact = forms(ContactLaw, [joint.contact for joint in joints])
    friction = forms(FrictionLaw, [joint.friction for joint in joints])
    topology = Topology(
        **_current_fields(Topology, entries["topology"]),
        contact_laws=contact,
        friction_laws=friction,
        contact_form=tuple(contact.index(joint.contact.form()) for joint in joints),
        friction_form=tuple(friction.index(joint.friction.form()) for joint in joints),
    )
    layout = Layout(topology)
    bodies = {body["name"]: BodyMap(**_current_fields(BodyMap, body)) for body in entries["bodies"]}
    mobility = (
        None if entries["mobility"] is None else Mobility(**_current_fields(Mobility, entries["mobility"]))
    )
    names = {name: entries.get(name, ()) for name in NAMES}
    state = state_of(layout, entries["blocks"], meta["start"], place)
    starts = meta.get("companion_starts")
    lanes = None
    if starts is not None:
        lanes = np.column_stack([state_of(layout, entries["blocks"], lane, place) for lane in starts.T])
    return Assembly(
        mechanism, topology, layout, state, meta["tables"], bodies, choice=choice, mobility=mobility, **names,
        companion_states=lanes,
    )  # fmt: skip


def state_of(
    layout: Layout, blocks: Iterable[tuple[str, int]], values: NDArray[np.float64], place: str
) -> NDArray[np.float64]:
    """Return the state S from its blocks; a block that the file does not have is zero, one that no longer
    exists is left out.
    """
    state, at = np.zeros(layout.rows), 0
    for name, count in blocks:
        rows = layout.rows_of(name) if name in BY_NAME else None
        if at + count > len(values) or (rows is not None and len(rows) != count):
            raise RunFileError(
                f"{place}: the state has {count} numbers for {name}, which does not fit the model; run the"
                " model again"
            )
        if rows is not None:
            state[rows] = values[at : at + count]
        at += count
    return state


def _current_fields(kind: type[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of the fields that a class has in this version."""
    return {field.name: values[field.name] for field in dataclasses.fields(kind) if field.name in values}


def _tuples(value: Any) -> Any:
    """Turn lists of JSON into tuples."""
    if isinstance(value, list):
        return tuple(_tuples(entry) for entry in value)
    return {key: _tuples(entry) for key, entry in value.items()} if isinstance(value, dict) else value


def restored_companions(file: RunFile, record: Record) -> Companions | None:
    """Return the companions of a record that was read from a file, None without any. Raises RunFileError if
    they do not fit the run.
    """
    stored, meta = file.companions(), file.meta.get("companions")
    if stored is None or not meta:
        return None
    (findings, steps, rows), place = stored, str(file.path)
    counts, names = counts_of(meta, record.assembly), rows_named(record.assembly, meta["kept"], place)
    if rows.shape[1] != len(names) * len(counts):
        raise RunFileError(
            f"{place}: {rows.shape[1]} numbers are kept of {len(counts)} companions with {len(names)} each;"
            " run the model again"
        )
    parting = (
        None
        if findings["parting"] is None
        else Parting(float(findings["parting"][0]), str(findings["parting"][1]))
    )
    window = steps >= oldest_needed(record.assembly, int(record.steps[-1]))
    rows = rows.reshape(len(rows), len(names), len(counts))[window]
    earlier, tries = ranges_of_tries(meta)
    turns, grid = file.turns(), turn_grid(record.assembly)
    full_turns = 0 if grid is None else grid.count(len(record.steps) - 1)
    complete = (
        turns[:full_turns] if turns.shape[1:] == rows.shape[1:] and len(turns) >= full_turns else turns[:0]
    )
    divergent = tuple(findings["lost"])
    return Companions(counts, names, steps[window], rows, parting, divergent, earlier, complete, tries)


def ranges_of_tries(
    meta: Mapping[str, Any],
) -> tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]:
    """Return the ranges, by measure, of the try before and of all tries from the entry of a file's meta for
    companions; files without the latter have the one before.
    """
    earlier, tries = (
        {name: (float(low), float(high)) for name, (low, high) in meta.get(key, {}).items()}
        for key in ("earlier", "tries")
    )
    return earlier, tries or earlier


def refuse_displaced(meta: Mapping[str, Any], place: str) -> None:
    """Raise ResumeError for a run of version 0.2 whose companions had the step of the run and displaced first
    steps: they are no longer stepped.
    """
    if "shifts" in meta.get("companions", {}):
        raise ResumeError(
            f"{place}: version 0.2 wrote this run, with companions of the same step, which are no longer"
            " made; its results stay readable; start a new run from its end (--start-from), or run the model"
            " again"
        )


def counts_of(meta: Mapping[str, Any], assembly: Assembly) -> NDArray[np.int64]:
    """Read the steps of each companion between two outputs, shape (companions,), from the entry of a file's
    meta.
    """
    if "counts" in meta:
        return np.array(meta["counts"], dtype=np.int64)
    return np.full(len(meta.get("shifts", ())), assembly.choice.outputs_every, dtype=np.int64)
