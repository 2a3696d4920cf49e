"""Files that commands keep things in, given where a text is read: one sentence says what they are and which
command reads them.
"""

import pytest

from vfife.store.runfile import RunFile
from vfife.store.studyfile import MapFile, StudyFile

LAID = {
    "a.map": (MapFile, "vfife map show"),
    "a.study": (StudyFile, "vfife study show"),
    "run.sqlite": (RunFile, "vfife info"),
}


@pytest.fixture
def laid(tmp_path):
    """A file of each kind."""
    MapFile.create(tmp_path / "a.map", {}).__exit__()
    StudyFile.begin(tmp_path / "a.study", {}, []).__exit__()
    RunFile.create(tmp_path / "run.sqlite", {}).__exit__()
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        ("map", "{}", "--over", "joint.pin.clearance=0.1..1mm"),
        ("sensitivity", "{}"),
        ("live", "{}", "-o", "page.html"),
        ("check", "{}"),
        ("optimise", "{}"),
    ],
)
def test_what_a_command_cannot_read_is_named(command, laid, words) -> None:
    for name, (_, reader) in LAID.items():
        done = command(*[word.format(name) for word in words])
        if words[0] != "live" or name != "run.sqlite":  # of which there is a page
            assert done.exit_code == 2 and reader in done.stderr and "UTF-8" not in done.stderr, done.stderr


def test_a_map_is_no_run(command, laid) -> None:
    for words in (("info", "a.map"), ("plot", "a.map"), ("report", "a.map")):
        done = command(*words)
        assert done.exit_code == 2 and "vfife map show" in done.stderr, done.stderr
