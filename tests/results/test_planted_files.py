"""Links, pipes, devices and traps of SQLite that somebody has put in the place of a file: refused with a
sentence, at once, and never followed.
"""

from __future__ import annotations

import os
import sqlite3
import threading
from pathlib import Path

import pytest
from typer.testing import CliRunner

import vfife
from vfife import files
from vfife.cli.app import app
from vfife.errors import ModelError, RunFileError
from vfife.live.server.documents import Conflict, Document
from vfife.store.connections import Connection
from vfife.store.lock import Lock

PENDULUM = Path(__file__).resolve().parents[2] / "examples" / "double_pendulum.toml"
posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are POSIX's")


def plant(folder: Path, name: str) -> Path:
    """A link to a file outside the folder, under every name that a writer of ``name`` used to
    write through.
    """
    outside = folder.parent / "outside.txt"
    outside.write_text("untouched")
    for link in (f"{name}.part", f".{name}.part"):
        (folder / link).symlink_to(outside)
    return outside


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "folder").mkdir()
    return tmp_path / "folder"


def test_no_writer_goes_through_a_planted_link(folder, monkeypatch):
    outside = plant(folder, "new.toml")
    monkeypatch.chdir(folder)
    assert CliRunner().invoke(app, ["new", "compressor", "-o", "new.toml"]).exit_code == 0
    vfife.save_model(vfife.load_model("new.toml"), folder / "new.toml")
    document = Document("1", "new.toml", (folder / "new.toml").read_text(), folder / "new.toml")
    document.disk = document.text
    document.save()
    assert outside.read_text() == "untouched" and not (folder / "new.toml").is_symlink()


def test_a_link_that_is_the_target_itself_is_replaced_and_not_followed(folder):
    outside = folder.parent / "outside.txt"
    outside.write_text("untouched")
    (folder / "a.txt").symlink_to(outside)
    files.write_text(folder / "a.txt", "new")
    assert outside.read_text() == "untouched" and (folder / "a.txt").read_text() == "new"


def test_a_temporary_file_is_made_exclusively(folder, monkeypatch):
    outside = folder.parent / "outside.txt"
    outside.write_text("untouched")
    names = iter([b"\1" * 8, b"\2" * 8])
    monkeypatch.setattr(files.os, "urandom", lambda count: next(names))
    (folder / f".a.txt.{'01' * 8}.part").symlink_to(outside)
    with files.replacement(folder / "a.txt") as temporary:
        assert not temporary.is_symlink() and temporary.parent == folder
        temporary.write_text("new")
    assert outside.read_text() == "untouched" and (folder / "a.txt").read_text() == "new"


def test_what_fails_leaves_the_old_file_and_nothing_beside_it(folder):
    (folder / "a.txt").write_text("old")
    with pytest.raises(ZeroDivisionError), files.replacement(folder / "a.txt") as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    assert [path.name for path in folder.iterdir()] == ["a.txt"] and (folder / "a.txt").read_text() == "old"
    assert not files.UNFINISHED


def test_a_signal_that_leaves_no_time_takes_temporary_files_away(folder):
    with pytest.raises(FileNotFoundError), files.replacement(folder / "a.txt"):
        files.remove_unfinished()
        assert list(folder.iterdir()) == []


def test_a_lock_is_not_taken_through_a_planted_link(folder):
    outside = folder.parent / "outside.txt"
    outside.write_text("untouched")
    (folder / "run.lock").symlink_to(outside)
    with pytest.raises(OSError):
        Lock(folder)
    assert outside.read_text() == "untouched"


@posix
@pytest.mark.parametrize("what", ["/dev/zero", "pipe", "folder", "large"])
def test_only_regular_files_of_bounded_size_are_read(folder, monkeypatch, what):
    monkeypatch.chdir(folder)
    words = {"/dev/zero": "device", "pipe": "pipe", "folder": "folder", "large": "more than 32 MB"}[what]
    if what == "pipe":
        os.mkfifo("pipe")
    elif what == "folder":
        Path("folder").mkdir()
    elif what == "large":
        with open("large", "wb") as stream:
            stream.write(b"#" * (files.LARGEST + 1))
    with pytest.raises(ModelError, match=words):
        vfife.load_model(what)
    done = CliRunner().invoke(app, ["check", what])
    assert done.exit_code == 2 and words in done.stderr and "Traceback" not in done.stderr
    Path("study.toml").write_text(f'model = "{what}"\n[vary]\n"joint.C.clearance" = ["0.1 mm"]\n')
    done = CliRunner().invoke(app, ["study", "run", "study.toml"])
    assert done.exit_code == 2 and words in done.stderr, done.stderr
    with pytest.raises(vfife.VfifeError, match=words):
        vfife.laws.load_laws(what)
    with pytest.raises(RunFileError):
        vfife.load_result(what)


@posix
def test_a_pipe_in_the_place_of_a_file_that_is_followed_counts_as_gone(folder):
    path = folder / "a.toml"
    path.write_bytes(PENDULUM.read_bytes())
    document = Document("1", "a.toml", path.read_text(), path)
    document.disk = document.text
    path.unlink()
    os.mkfifo(path)
    found: list[str | None] = []
    thread = threading.Thread(target=lambda: found.append(document.follow(document.look())), daemon=True)
    thread.start()
    thread.join(5.0)
    assert found == ["gone"]
    with pytest.raises(Conflict, match="pipe"):
        document.save()


TRAPS = {
    "view": (
        "CREATE VIEW v AS WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT k FROM n"
    ),
    "trigger": "CREATE TRIGGER t AFTER INSERT ON meta BEGIN DELETE FROM meta; END",
}


@pytest.mark.parametrize("trap", TRAPS)
def test_views_and_triggers_are_refused(trap, tmp_path):
    result = vfife.simulate(vfife.load_model(PENDULUM), duration=0.01)
    result.save(tmp_path / "run.sqlite")
    with sqlite3.connect(tmp_path / "run.sqlite") as connection:
        connection.execute(TRAPS[trap])
    connection.close()
    with pytest.raises(RunFileError, match=f"it has a {trap}"):
        vfife.load_result(tmp_path / "run.sqlite")
    with pytest.raises(vfife.VfifeError, match=f"it has a {trap}"):
        vfife.resume(tmp_path / "run.sqlite")


def test_a_view_in_the_place_of_a_table_is_refused(tmp_path):
    """A run file whose table of outputs is an endless view: it was read until memory was full."""
    vfife.simulate(vfife.load_model(PENDULUM), duration=0.01).save(tmp_path / "run.sqlite")
    with sqlite3.connect(tmp_path / "run.sqlite") as connection:
        connection.execute("DROP TABLE history")
        connection.execute(TRAPS["view"].replace("VIEW v", "VIEW history"))
    connection.close()
    with pytest.raises(RunFileError, match="it has a view"):
        vfife.load_result(tmp_path / "run.sqlite")


def test_a_statement_that_does_not_end_is_stopped(monkeypatch):
    monkeypatch.setattr("vfife.store.connections.MOST_BEATS", 3)
    connection = sqlite3.connect(":memory:", factory=Connection)
    endless = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT max(k) FROM n"
    with pytest.raises(sqlite3.OperationalError, match="interrupted"):
        connection.execute(endless)
    assert connection.execute("SELECT 1").fetchone() == (1,)
    connection.close()
