"""Run files survive their writer, and say what is wrong with them."""

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from vfife.errors import RunFileError
from vfife.solvers.companions import CompanionOutputs
from vfife.solvers.record import Checkpoint
from vfife.store.packing import packed, unpacked
from vfife.store.runfile import RunFile

WRITER = """
import sys
import numpy as np
from vfife.store.runfile import RunFile
file = RunFile.create(sys.argv[1], {"step": 1e-6})
steps = np.arange(50)
while True:
    file.append(steps, np.sin(np.outer(steps, np.arange(1, 41))))
    file.checkpoint(int(steps[-1]), np.full(100, float(steps[-1])))
    steps = steps + len(steps)
"""


def written(steps: np.ndarray) -> np.ndarray:
    return np.sin(np.outer(steps, np.arange(1, 41)))


def small(path: Path) -> Path:
    with RunFile.create(path, {"step": 1e-6, "loop": "data-driven"}) as file:
        for first in (0, 10, 20):
            steps = np.arange(first, first + 10)
            file.append(steps, written(steps))
            file.checkpoint(first, np.full(5, float(first)))
        file.event(20, "something happened")
        file.finish("complete", {"energy_error": 1e-7}, wall=0.5)
    return path


def test_what_was_written_is_read(tmp_path: Path) -> None:
    with RunFile.open(small(tmp_path / "run.sqlite")) as file:
        assert file.meta["step"] == 1e-6
        assert file.meta["status"] == "complete"
        assert file.meta["summary"] == {"energy_error": 1e-7}
        assert file.meta["wall"] == 0.5
        assert np.array_equal(file.steps, np.arange(30))
        assert np.array_equal(file.rows, written(file.steps))
        step, state = file.last_checkpoint()
        assert (step, list(state)) == (20, [20.0] * 5)
        assert [(step, text) for step, _, text in file.events] == [(20, "something happened")]
        assert file.reference() is None
    assert os.listdir(tmp_path) == ["run.sqlite"]


def test_only_the_latest_checkpoints_stay(tmp_path: Path) -> None:
    with sqlite3.connect(small(tmp_path / "a")) as connection:
        assert connection.execute("SELECT count(*) FROM checkpoints").fetchone() == (2,)


def test_a_second_try_takes_the_place_of_the_first(tmp_path: Path) -> None:
    with RunFile.create(tmp_path / "a", {"step": 2e-6, "loop": "generated"}) as file:
        file.append(np.arange(3), np.ones((3, 2)))
        file.checkpoint(2, np.ones(2))
        file.begin({"step": 1e-6})
        assert (len(file.steps), file.meta["step"], file.last_checkpoint()[0]) == (
            3,
            2e-6,
            2,
        )  # until something is there to take its place
        file.append(np.arange(2), np.zeros((2, 2)))
        file.append(np.arange(2), np.full((2, 2), 3.0))  # from step 0 again
        assert file.last_checkpoint() is None
        assert (file.meta["step"], file.meta["loop"]) == (1e-6, "generated")
        assert np.array_equal(file.rows, np.full((2, 2), 3.0))


@pytest.mark.system("kills processes")
@pytest.mark.parametrize("trial", range(6))
def test_killed_while_writing(tmp_path: Path, trial: int) -> None:
    path = tmp_path / "run.sqlite"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)])
    try:
        deadline = time.monotonic() + 30.0
        while not path.exists() or path.stat().st_size < 70_000:
            assert time.monotonic() < deadline
            assert writer.poll() is None
            time.sleep(0.005)
        time.sleep(0.004 * trial)
    finally:
        writer.send_signal(signal.SIGKILL)
        writer.wait()
    with RunFile.open(path) as file:
        steps = file.steps
        assert len(steps) >= 50
        assert np.array_equal(steps, np.arange(len(steps)))
        assert np.array_equal(file.rows, written(steps))
        step, state = file.last_checkpoint()
        assert step <= steps[-1]
        assert (state == step).all()
        assert file.meta["status"] == "running"


def half_written(path: Path) -> Path:
    """A copy of a file and its journal in the middle of a transaction, as a killed writer leaves them."""
    small(path)
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute(
        "PRAGMA cache_size = 1"
    )  # so that changed pages reach the file before the transaction ends
    connection.execute("BEGIN")
    connection.executemany(
        "INSERT INTO events VALUES (?, 0, '', '', x'00')", [(k,) for k in range(1000, 60000)]
    )
    folder = path.parent / "copy"
    folder.mkdir()
    for name in (path.name, f"{path.name}-journal"):
        shutil.copy(path.parent / name, folder)
    connection.rollback()
    return folder / path.name


def test_journal_of_a_killed_writer_is_rolled_back(tmp_path: Path) -> None:
    with RunFile.open(half_written(tmp_path / "run.sqlite")) as file:
        assert np.array_equal(file.steps, np.arange(30))


def test_the_same_where_nothing_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, connect = half_written(tmp_path / "run.sqlite"), sqlite3.connect
    before = path.read_bytes()

    def refused(name, *args, **kwargs):
        if "mode=rw" in str(name):
            raise sqlite3.OperationalError("attempt to write a readonly database")
        return connect(name, *args, **kwargs)

    monkeypatch.setattr(sqlite3, "connect", refused)
    with RunFile.open(path) as file:
        assert np.array_equal(file.rows, written(np.arange(30)))
    assert path.read_bytes() == before


def test_read_while_it_is_written(tmp_path: Path) -> None:
    with RunFile.create(tmp_path / "run.sqlite") as writer:
        writer.append(np.arange(2), np.zeros((2, 3)))
        with RunFile.open(tmp_path) as reader:
            assert reader.rows.shape == (2, 3)
            writer.append(np.arange(2, 4), np.zeros((2, 3)))
            assert reader.rows.shape == (4, 3)
            with pytest.raises(RunFileError):
                reader.event(0, "a reader does not write")


def test_what_is_gathered_is_one_transaction(tmp_path: Path) -> None:
    """A short run waits for the disk at its begin and its end; a reader sees all of a slice or nothing, and
    closing loses nothing.
    """
    path, commits = tmp_path / "run.sqlite", []
    with RunFile.create(path, {"step": 1e-6}, gather=3600.0) as file:
        file._connection.set_trace_callback(lambda line: commits.append(line) if line == "COMMIT" else None)
        for first in (0, 10, 20):
            file.append(np.arange(first, first + 10), written(np.arange(first, first + 10)))
            file.checkpoint(first + 9, np.zeros(5))
        assert len(file.steps) == 30 and not commits
        with RunFile.open(path) as reader:
            assert len(reader.steps) == 0 and reader.meta["status"] == "running"
        assert np.array_equal(file.later()(), written(np.arange(30)))
        file.append(np.arange(30, 40), written(np.arange(30, 40)))
        file.checkpoint(39, np.zeros(5))
    assert len(commits) == 2
    with RunFile.open(path) as reader:
        assert np.array_equal(reader.rows, written(np.arange(40)))
        assert reader.last_checkpoint()[0] == 39


def test_what_waits_long_enough_goes_to_the_disk_with_its_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    with RunFile.create(path, gather=1e-9) as file, RunFile.open(path) as reader:
        file.append(np.arange(2), np.zeros((2, 3)))
        assert len(reader.steps) == 0
        file.checkpoint(1, np.zeros(2))
        assert len(reader.steps) == 2 and reader.last_checkpoint()[0] == 1


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    path = small(tmp_path / "a")
    with pytest.raises(RunFileError, match="this run file exists already"):
        RunFile.create(path)
    with RunFile.create(path, replace=True) as file:
        assert len(file.steps) == 0


def test_what_is_no_run_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(RunFileError, match="there is no run file of this name"):
        RunFile.open(tmp_path / "nothing")
    with pytest.raises(RunFileError, match="is a folder, not a run; name a folder with a run.sqlite"):
        RunFile.open(tmp_path)
    (tmp_path / "text").write_text("name = 1\n")
    sqlite3.connect(tmp_path / "other").execute("CREATE TABLE meta (key, json)").connection.close()
    for name, what in {"text": "not a run file of vfife", "other": "a database of another program"}.items():
        with pytest.raises(RunFileError, match=what):
            RunFile.open(tmp_path / name)
    with pytest.raises(RunFileError, match="no run file can be made here"):
        RunFile.create(tmp_path / "no" / "such" / "folder")


def test_a_newer_format_is_told(tmp_path: Path) -> None:
    path = small(tmp_path / "a")
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA user_version = 99")
    with pytest.raises(RunFileError, match="newer vfife"):
        RunFile.open(path)


@pytest.mark.parametrize("kind", ["cut", "overwritten"])
def test_damage_to_all_of_it_is_told(tmp_path: Path, kind: str) -> None:
    path = small(tmp_path / "a")
    whole = path.read_bytes()
    path.write_bytes(
        whole[: len(whole) // 3] if kind == "cut" else whole[:4096] + b"\x5a" * (len(whole) - 4096)
    )
    with pytest.raises(RunFileError, match="damaged .*; run the model again"), RunFile.open(path) as file:
        _ = file.meta, file.steps, file.rows


@pytest.mark.parametrize(
    ("statement", "left", "lost"),
    [
        ("DROP TABLE history", 1, "outputs 1 to 29"),
        ("DELETE FROM history WHERE chunk = 0", 21, "outputs 1 to 9"),
        ("DELETE FROM history WHERE chunk = 1", 20, "outputs 10 to 19"),
        ("DELETE FROM history WHERE chunk = 2", 20, "outputs 20 to 29"),
        ("UPDATE history SET data = zeroblob(50) WHERE chunk = 1", 20, "outputs 10 to 19"),
        ("UPDATE history SET outputs = 9 WHERE chunk = 0", 21, "outputs 1 to 9"),
        (
            "UPDATE history SET steps = (SELECT steps FROM history WHERE chunk = 0) WHERE chunk = 2",
            20,
            "outputs 20 to 29",
        ),
    ],
)
def test_a_damaged_block_loses_itself_and_no_more(
    tmp_path: Path, statement: str, left: int, lost: str
) -> None:
    path = small(tmp_path / "a")
    with sqlite3.connect(path) as connection:
        connection.execute(statement)
    with RunFile.open(path) as file:
        steps, rows = file.outputs()
        assert len(steps) == left and np.array_equal(rows, written(steps) if left else np.zeros((0, 0)))
        assert file.damaged_parts == (lost,)
        assert file.meta["summary"] == {"energy_error": 1e-7}


def test_steps_that_do_not_rise_are_told(tmp_path: Path) -> None:
    """Whole and sealed, and yet of another run: a chunk that says again what an earlier one said."""
    with RunFile.create(tmp_path / "a") as file:
        for first in (0, 10, 5):
            steps = np.arange(first, first + 10)
            file.append(steps, written(steps))
    with RunFile.open(tmp_path / "a") as file:
        assert np.array_equal(file.steps, np.arange(20)) and file.damaged_parts == ("outputs 20 to 29",)


def test_without_the_copy_of_the_first_output_it_is_missing(tmp_path: Path) -> None:
    path = small(tmp_path / "a")
    with sqlite3.connect(path) as connection:
        connection.execute("DELETE FROM history WHERE chunk = 0")
        connection.execute("UPDATE copies SET data = zeroblob(9) WHERE key = 'first output'")
    with RunFile.open(path) as file:
        assert np.array_equal(file.steps, np.arange(10, 30)) and file.damaged_parts == ("outputs 0 to 9",)


@pytest.mark.parametrize("where", ["meta", "arrays", "copies"])
def test_what_it_says_of_itself_is_there_twice(tmp_path: Path, where: str) -> None:
    """All of one place gone, entry by entry and as a whole: the other one has it."""
    for statement in (
        f"UPDATE {where} SET seal = zeroblob(16)",
        f"DELETE FROM {where}",
        f"DROP TABLE {where}",
    ):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}"
        with RunFile.create(path, {"step": 1e-6, "start": np.ones(4)}) as file:
            file.append(np.arange(4), written(np.arange(4)))
        with sqlite3.connect(path) as connection:
            connection.execute(statement)
        with RunFile.open(path) as file:
            assert (
                file.meta["step"] == 1e-6 and list(file.meta["start"]) == [1.0] * 4 and not file.damaged_parts
            )
        if statement.startswith("DROP"):  # as in a file that was begun before there was such a table
            with RunFile.write(path) as file:
                file.put({"step": 2e-6})
                assert file.meta["step"] == 2e-6


@pytest.mark.parametrize("table", ["meta", "arrays", "checkpoints", "reference", "companions"])
def test_other_blocks_are_checked_as_well(tmp_path: Path, table: str) -> None:
    path = tmp_path / "a"
    with RunFile.create(path, {"step": 1e-6, "start": np.ones(4)}) as file:
        steps = np.arange(4)
        told = {"parting": None, "lost": []}
        file.append(
            steps, written(steps), CompanionOutputs(np.ones((4, 2, 1)), told, 0), Checkpoint(3, np.ones(4))
        )
        file.keep_reference({"step": 1.0}, steps, written(steps))
    change = {
        "meta": "json = '2e-6' WHERE key = 'step'",
        "arrays": "key = 'tables'",
        "checkpoints": "step = 2",
        "reference": "data = zeroblob(20) WHERE part = 'steps'",
        "companions": "told = replace(told, 'null', '[1, 2]')",
    }
    with sqlite3.connect(path) as connection:
        connection.execute(f"UPDATE {table} SET {change[table]}")
        connection.execute("UPDATE copies SET data = x'00' WHERE key IN ('meta.step', 'arrays.start')")
    with RunFile.open(path) as file:
        got = {
            "meta": lambda: file.meta.get("step"),
            "checkpoints": file.latest,
            "reference": file.reference,
            "companions": file.companions,
        }
        got["arrays"] = lambda: file.meta.get("start")
        assert got[table]() is None
        assert file.damaged_parts
        assert np.array_equal(file.rows, written(steps))


def test_no_flipped_bit_shows_another_number(tmp_path: Path) -> None:
    """Bits all over a small file, one at a time: what is read is what was written, or is missing and told, or
    the file is refused.
    """
    path, flipped = small(tmp_path / "a"), tmp_path / "b"
    whole, random = path.read_bytes(), np.random.default_rng(7)
    seen = {"same": 0, "told": 0, "refused": 0}
    for bit in random.choice(8 * len(whole), 400, replace=False):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << (bit % 8)
        flipped.write_bytes(changed)
        try:
            with RunFile.open(flipped) as file:
                (steps, rows), last, meta = file.outputs(), file.last_checkpoint(), file.meta
                events, lost = file.events, file.damaged_parts
        except RunFileError:
            seen["refused"] += 1
            continue
        assert np.array_equal(rows, written(steps)) if len(steps) else True
        assert last is None or (last[0] in (10, 20) and list(last[1]) == [float(last[0])] * 5)
        for key, value in {"step": 1e-6, "loop": "data-driven", "wall": 0.5, "status": "complete"}.items():
            assert meta.get(key, value) == value
            assert key in meta or lost
        assert len(steps) == 30 or lost
        assert all(text == "something happened" for _, _, text in events)
        seen["told" if lost else "same"] += 1
    assert seen["told"] > 0 and seen["refused"] > 0


def test_sizes_are_bounded_before_anything_is_unpacked() -> None:
    """A block of a megabyte that would inflate to a gigabyte, and one whose shape is a lie."""
    bomb = (
        packed(np.zeros((4, 4)))[:4]
        + np.array([2**15, 2**15 + 1], dtype="<u4").tobytes()
        + zlib.compress(bytes(2**20))
    )
    with pytest.raises(zlib.error, match="are the most"):
        unpacked(bomb)
    lie = np.array([1, 100], dtype="<u4").tobytes() + zlib.compress(bytes(2**27), 9)
    tracemalloc.start()
    with pytest.raises(zlib.error, match="as long as it should"):
        unpacked(lie)
    assert tracemalloc.get_traced_memory()[1] < 2**20
    tracemalloc.stop()


@pytest.mark.parametrize("shape", [(3,), (4, 5), (0, 5), (5, 0), (1, 1)])
def test_packing_keeps_every_bit(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(1).standard_normal(shape)
    values.ravel()[:3] = (np.nan, -0.0, np.inf)[: values.size]
    again = unpacked(packed(values))
    assert again.shape == shape
    assert again.tobytes() == values.tobytes()


def test_a_damaged_index_leads_to_no_other_row(tmp_path: Path) -> None:
    """A name in an index, overwritten by zeros: the row it leads to is whole, and is that of another name."""
    path, changed = small(tmp_path / "a"), tmp_path / "b.sqlite"
    whole = path.read_bytes()
    with RunFile.open(path) as file:
        meta = file.meta
    name = next(
        one for one in (f"meta.{key}".encode() for key in sorted(meta)) if whole.count(one) == 2
    )  # in the table and in its index
    at = whole.find(name)
    for place in (at, whole.find(name, at + 1)):
        changed.write_bytes(whole[: place + 5] + bytes(len(name) - 5) + whole[place + len(name) :])
        with RunFile.open(changed) as file:
            assert set(file.meta) == set(meta)
            assert all("\0" not in one for one in file.damaged_parts)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("history", "outputs 1 to 29"),
        ("checkpoints", "a checkpoint"),
        ("events", "some of its events"),
        ("reference", "the ideal reference"),
    ],
)
def test_a_table_that_is_empty_is_noticed_by_the_counts_of_the_end(
    tmp_path: Path, table: str, said: str
) -> None:
    path, steps = tmp_path / "run.sqlite", np.arange(30)
    with RunFile.create(path, {"step": 1e-6}) as file:
        file.append(steps, written(steps))
        file.checkpoint(29, np.ones(3))
        file.event(20, "something happened")
        file.keep_reference({"step": 1.0}, steps, written(steps))
        file.finish("complete")
    with sqlite3.connect(path) as connection:
        connection.execute(f"DELETE FROM {table}")
    with RunFile.open(path) as file:
        _ = file.latest(), file.events, file.reference(), file.outputs()
        assert any(said in one for one in file.damaged_parts), file.damaged_parts


def test_a_row_of_another_key_is_not_taken_for_the_one_that_was_looked_for(tmp_path: Path) -> None:
    """As a damaged index leads to it: the row is sound, and has its own seal."""

    class Misled:
        def execute(self, statement: str, values: tuple[str, ...]) -> sqlite3.Cursor:
            return connection.execute(statement, ("step",))

    RunFile.create(tmp_path / "run.sqlite", {"step": 1e-6, "loop": "generated"}).close()
    with RunFile.open(tmp_path / "run.sqlite") as file:
        connection = file._connection
        file._connection = Misled()  # type: ignore[assignment]
        assert file.row("meta", "step") is not None and file.row("meta", "loop") is None
        file._connection = connection
