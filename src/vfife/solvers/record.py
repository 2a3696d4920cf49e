"""Records of runs: rows of the state at the outputs, with the extremes between them."""

from __future__ import annotations

import mmap
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..assembly.assembled import Assembly
from ..errors import StorageError, former_names
from ..kernels.arrays import Layout
from ..kernels.blocks import BLOCKS
from .status import Status

if TYPE_CHECKING:
    from .companions import CompanionOutputs, Companions

Rows: TypeAlias = NDArray[np.float64]
IN_MEMORY = 2**28  # largest size (bytes) of rows in memory; larger arrays are mapped to a file
# The same of rows that a run file has already. Reading them must not take the memory that the run saved.
READ_IN_MEMORY = 2**25
PIECE_BYTES = 2**23  # of a mapped array that are in memory at once
CACHED_BYTES = 3 * 2**22  # of blocks of mapped rows that a record holds in memory


def room_for_rows(outputs: int, width: int, in_memory: int | None = None) -> Rows:
    """Return an array for rows, shape (outputs, width): in memory up to ``in_memory`` bytes, or, if it is
    larger, mapped to a file without a name, which disappears with the array.

    Raises StorageError if the disk has no space for it, and it is larger than ``IN_MEMORY``.
    """
    size = 8 * outputs * width
    if size <= (IN_MEMORY if in_memory is None else min(in_memory, IN_MEMORY)):
        return np.empty((outputs, width))
    folder = tempfile.gettempdir()
    free = shutil.disk_usage(folder).free
    if size > free:
        if size <= IN_MEMORY:
            return np.empty((outputs, width))
        raise StorageError(
            f"{folder}: the outputs of this run take {size:,} bytes outside of memory, and {free:,} are free"
            " there"
        )
    with tempfile.TemporaryFile() as file:
        return np.memmap(file, dtype=float, mode="w+", shape=(outputs, width)).view(np.ndarray)


def release(rows: Rows) -> None:
    """Take the pages of a mapped array out of memory; they stay in its file. Other arrays are unchanged."""
    mapping = mapping_of(rows)
    if mapping is not None and hasattr(mapping, "madvise"):  # Windows has none
        mapping.madvise(mmap.MADV_DONTNEED)


def mapping_of(rows: Rows) -> mmap.mmap | None:
    """Return what maps rows to a file; None for rows in memory."""
    base: Any = rows
    while isinstance(base, np.ndarray):
        base = base.base
    return base if isinstance(base, mmap.mmap) else None


def rows_between(rows: Rows, first: int, last: int) -> Rows:
    """Return a part of rows, in memory if it is a small part of a mapped array."""
    part = rows[first:last]
    if mapping_of(rows) is None or part.nbytes > PIECE_BYTES:
        return part
    copy = np.array(part)
    release(rows)
    return copy


def columns_of(rows: Rows, columns: NDArray[np.intp]) -> Rows:
    """Return some columns of rows, shape (outputs, columns). A mapped array is read piece by piece, so that
    its rows need not fit into the memory.
    """
    if mapping_of(rows) is None:
        return rows[:, columns]
    # Column by column in memory, as numpy lays out the selection above: sums along a row depend on it.
    result = np.empty((len(columns), len(rows))).T
    size = max(PIECE_BYTES // max(8 * rows.shape[1], 1), 1)
    for first in range(0, len(rows), size):
        result[first : first + size] = rows[first : first + size, columns]
        release(rows)
    return result


class BlockCache:
    """The latest blocks of mapped ``rows``, up to :data:`CACHED_BYTES`.

    Series of one result need the same positions and forces again and again, and each reading goes through all
    of the file. Blocks are returned as copies, because their readers may change them.
    """

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        self.blocks: dict[str, Rows] = {}  # the latest at the end

    def block(self, name: str, columns: NDArray[np.intp]) -> Rows:
        """Return some columns of the rows, which belong to a block of this name."""
        values = self.blocks.pop(name, None)
        if values is None:
            values = columns_of(self.rows, columns)
            if values.nbytes > CACHED_BYTES:
                return values
            size = values.nbytes + sum(block.nbytes for block in self.blocks.values())
            while size > CACHED_BYTES:
                size -= self.blocks.pop(next(iter(self.blocks))).nbytes
        self.blocks[name] = values
        return values.T.copy().T  # the layout of rows in memory, on which sums depend


@dataclass(frozen=True)
class Checkpoint:
    """A state from which a run continues to the bit: ``values`` of S after ``step`` in the order of
    :func:`lasting_rows`, shape (rows,) or (rows, lanes), and ``extra`` data of the solver for JSON.

    ``chunks`` and ``outputs`` are the numbers that a file had at that step.
    """

    step: int
    values: Rows
    extra: Mapping[str, Any] = field(default_factory=dict)
    chunks: int = 0
    outputs: int = 0


class Writer(Protocol):
    """A destination of outputs and checkpoints of a run: a run file."""

    @property
    def steps(self) -> NDArray[np.int64]:
        """Steps of the outputs in the file."""

    def later(self) -> Callable[[], Rows]:
        """Return a function that reads the rows of the outputs."""

    def append(
        self,
        steps: NDArray[np.int64],
        rows: Rows,
        companions: CompanionOutputs | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> None:
        """Store outputs, with those of companions and the state at their end; outputs that begin with step 0
        replace all former ones.
        """

    def companions(self) -> tuple[dict[str, Any], NDArray[np.int64], Rows] | None:
        """Return findings about the companions, and their steps and rows as far as they are still needed."""

    def turns(self) -> Rows:
        """Return the rows of companions for each whole turn, shape (turns, rows, companions)."""

    def event(self, step: int, text: str) -> None:
        """Store a message about an event after a step."""


@dataclass(frozen=True)
class Burst:
    """Where numbers left their bounds: the ``step``, the ``rows`` of S, and whether they were ``finite``."""

    step: int
    rows: NDArray[np.uint32]
    finite: bool


@dataclass
class Estimate:
    """Estimated ``errors`` by measure, in its unit: of the step of a smooth run, from repetitions with half
    and a quarter of it, or of the mesh of a static analysis, from other numbers of elements. Measures without
    an entry were not estimated.

    ``order``: order of convergence in the step. ``converges``: whether runs with smaller steps converge where
    measures are taken.
    """

    order: float | None
    errors: dict[str, float]
    converges: bool = True


class TurnEnds(NamedTuple):
    """Exact beginning and end of a turn: ``steps``, no whole numbers, shape (2,), and the recorded ``rows``
    there, shape (2, rows).
    """

    steps: NDArray[np.float64]
    rows: Rows


@dataclass
class Columns:
    """Columns of blocks among recorded rows, ``row_numbers``, of a layout."""

    layout: Layout
    row_numbers: NDArray[np.uint32]
    places: dict[str, NDArray[np.intp]] = field(default_factory=dict)
    complete: dict[str, bool] = field(default_factory=dict)

    def of(self, name: str) -> NDArray[np.intp]:
        """Return the columns of a block."""
        if name not in self.places:
            self.places[name] = places(self.row_numbers, self.layout[name])
        return self.places[name]

    def keeps(self, name: str) -> bool:
        """Return whether all rows of a block are recorded."""
        if name not in self.complete:
            self.complete[name] = bool(np.isin(self.layout[name], self.row_numbers).all())
        return self.complete[name]


@former_names(kept="row_numbers", lost="damaged_parts")
@dataclass(repr=False)
class Record:
    """What a run leaves: ``rows[k]`` holds the rows ``row_numbers`` of S after step ``steps[k]``; time is
    steps * step.

    A static analysis leaves its equilibria: step k is that under load factor k, counted from 1; 0 is the
    start, without loads.

    Extremes in row k are those of the steps after output k - 1 up to output k. The first output is step 0.
    ``final`` is all of S after the last output, where it is known.

    ``source`` is the rows themselves or, where a run file has them, what reads them when they are first asked
    for: a run that writes a file keeps no rows in memory. ``companions`` ran beside it, or None; ``estimate``
    is that of a smooth run, where it was made. ``damaged_parts`` names what was damaged in the file that it
    was read from; ``normal_shares`` (1), shape (contacts,), are those of normal forces in the largest forces
    of the last turn, once they are known; a companion has those of its ``run``;
    ``reached`` is the last step made, ``burst`` where the run diverged.
    ``checkpoint`` is the state from which it goes on, with that of its companions, where no file has it.
    ``turn_ends`` are those of a record of one turn that begins and ends between two outputs.
    ``snaps`` are the pairs of load factors between which a structure in static analysis became unstable;
    ``unstable`` are load factors with whether their equilibrium is, None where that is not examined.
    """

    assembly: Assembly
    steps: NDArray[np.int64]
    source: Rows | Callable[[], Rows]
    row_numbers: NDArray[np.uint32]
    wall: float = 0.0
    loop: str = ""
    status: Status = Status.COMPLETE
    final: Rows | None = None
    message: str = ""
    companions: Companions | None = None
    estimate: Estimate | None = None
    damaged_parts: tuple[str, ...] = ()
    reached: int = 0
    burst: Burst | None = None
    normal_shares: Rows | None = field(default=None, repr=False, compare=False)
    run: Record | None = field(default=None, repr=False, compare=False)
    checkpoint: Checkpoint | None = field(default=None, compare=False)
    columns: Columns | None = field(
        default=None, repr=False, compare=False
    )  # where blocks stand, which records of one layout may share
    turn_ends: TurnEnds | None = field(default=None, repr=False, compare=False)
    snaps: tuple[tuple[float, float], ...] = ()
    unstable: tuple[tuple[float, bool | None], ...] = ()
    cache: BlockCache | None = field(default=None, init=False, repr=False, compare=False)

    def __repr__(self) -> str:
        return (
            f"<Record of {self.assembly.mechanism.name!r}: {self.status}, {len(self.steps)} outputs of"
            f" {len(self.row_numbers)} rows; see .steps, .rows, .block(name)>"
        )

    @property
    def _columns(self) -> Columns:
        if (
            self.columns is None
            or self.columns.row_numbers is not self.row_numbers
            or self.columns.layout is not self.assembly.layout
        ):
            self.columns = Columns(self.assembly.layout, self.row_numbers)
        return self.columns

    @property
    def rows(self) -> Rows:
        """Recorded rows, shape (outputs, rows). Raises RunFileError where a file that has them is gone or
        damaged.
        """
        if not isinstance(self.source, np.ndarray):
            self.source = self.source()
        return self.source

    @property
    def static(self) -> bool:
        """Whether the outputs are equilibria under load factors."""
        return self.assembly.mechanism.settings.analysis == "static"

    def block(self, name: str) -> NDArray[np.float64]:
        """Return the recorded values of a block, shape (outputs, entities)."""
        rows, columns = self.rows, self._columns.of(name)
        if mapping_of(rows) is None:
            return columns_of(rows, columns)
        if self.cache is None or self.cache.rows is not rows:
            self.cache = BlockCache(rows)
        return self.cache.block(name, columns)

    def last(self, name: str) -> NDArray[np.float64]:
        """Return the values of a block at the last output, shape (entities,)."""
        return np.asarray(self.rows[-1, self._columns.of(name)])

    def keeps(self, name: str) -> bool:
        """Return whether a block was recorded; a record of an older version may lack one."""
        return self._columns.keeps(name)

    def parameter(self, name: str) -> NDArray[np.float64]:
        """Return the values of a parameter block, shape (entities,)."""
        return self.assembly.state[self.assembly.layout[name]]


def lasting_blocks(layout: Layout) -> list[tuple[str, NDArray[np.intp]]]:
    """Return the blocks of S that have a meaning between two steps, by name, with their rows; empty blocks
    are left out.
    """
    return [
        (block.name, layout.rows_of(block.name))
        for block in BLOCKS
        if block.role != "scratch" and len(layout.records[block.entity])
    ]


def lasting_rows(layout: Layout) -> NDArray[np.intp]:
    """Return the rows of S that have a meaning between two steps, block by block: a checkpoint."""
    return np.concatenate([rows for _, rows in lasting_blocks(layout)])


def recorded_rows(assembly: Assembly) -> NDArray[np.uint32]:
    """Return the rows of S that a run records: all states and all extremes."""
    return np.array(assembly.layout.of("state", "extreme"), dtype=np.uint32)


def places(recorded: NDArray[np.uint32], rows: NDArray[Any]) -> NDArray[np.intp]:
    """Return the indices of ``rows`` of S among the ``recorded`` ones."""
    order = np.argsort(recorded, kind="stable")
    return np.asarray(order[np.searchsorted(recorded, rows, sorter=order)], dtype=np.intp)
