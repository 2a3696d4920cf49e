"""The cache of compiled steps: a second process compiles nothing, and no broken file stands in the way."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vfife.codegen import compile as compiling

TEXT = """@jit
def half(x):
    return 0.5 * x

@jit
def tripled(S):
    for k in range(len(S)):
        S[k] = 6.0 * half(S[k])
    return 0
"""

COUNTED = """
import json, sys
from numba.core import event
import numpy as np
with event.install_recorder("numba:compile") as recorder:
{code}
    compiles = sum(record.is_start for _, record in recorder.buffer)
print(json.dumps([compiles, result]))
"""

TRIPLED = """
    from vfife.codegen.compile import compiled
    S = np.arange(3.0)
    compiled({text!r}, "tripled")(S)
    result = S.tolist()
"""

WHOLE_RUN = """
    sys.path.insert(0, {tests!r})
    from support import four_bar, go
    record = go(four_bar("BCD"), 2e-6, duration=1e-3)
    result = [len(record.steps), float(record.rows.sum())]
"""


def process(code: str, cache: Path | None = None) -> tuple[int, list]:
    """Functions that numba compiled in a fresh process, and the code's ``result``."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
    if cache is not None:
        environment["VFIFE_CACHE"] = str(cache)
    done = subprocess.run(
        [sys.executable, "-c", COUNTED.format(code=code)], env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    compiles, result = json.loads(done.stdout.splitlines()[-1])
    return compiles, result


def files(folder: Path) -> dict[str, tuple[int, int]]:
    """Size and time of change of every file."""
    return {p.relative_to(folder).as_posix(): (p.stat().st_size, p.stat().st_mtime_ns) for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def tripled() -> list[float]:
    """Calls the small step through the cache as a new process would."""
    values = np.arange(3.0)
    compiling.compiled(TEXT, "tripled")(values)
    return values.tolist()


def test_a_second_process_compiles_nothing(folder):
    first, expected = process(TRIPLED.format(text=TEXT), folder)
    before = files(folder)
    second, found = process(TRIPLED.format(text=TEXT), folder)
    assert first >= 1 and second == 0
    assert found == expected == [0.0, 3.0, 6.0]
    assert files(folder) == before and any(name.endswith(".nbc") for name in before)


def test_a_second_process_runs_a_mechanism_without_compiling():
    """With the cache that this session's other tests fill; the first process compiles the loop if they have not yet."""
    code = WHOLE_RUN.format(tests=str(Path(__file__).parents[1]))
    _, first = process(code)
    before = files(compiling.cache_folder())
    compiles, second = process(code)
    assert compiles == 0
    assert first == second and first[0] > 10
    after = files(compiling.cache_folder())
    assert {name: after.get(name) for name in before} == before


def test_another_text_is_compiled_anew(folder):
    """The key holds the whole text: a nudged coefficient never meets old machine code."""
    assert tripled() == [0.0, 3.0, 6.0]
    values = np.arange(3.0)
    compiling.compiled(TEXT.replace("6.0 *", "8.0 *"), "tripled")(values)
    assert values.tolist() == [0.0, 4.0, 8.0]
    assert tripled() == [0.0, 3.0, 6.0]


def test_the_cache_knows_what_it_holds(folder):
    assert not compiling.is_compiled(TEXT, "tripled")
    tripled()
    assert compiling.is_compiled(TEXT, "tripled")
    assert not compiling.is_compiled(TEXT.replace("0.5", "0.25"), "tripled")


@pytest.mark.parametrize("kind", ["nbi", "nbc", "py"])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.95])
def test_a_truncated_file_is_recovered(folder, kind, share):
    """A full disk or a killed process leaves part of a file; the step is compiled again and the cache mended."""
    tripled()
    (broken,) = folder.rglob(f"*.{kind}")
    whole = broken.read_bytes()
    broken.write_bytes(whole[: int(share * len(whole))])
    assert tripled() == [0.0, 3.0, 6.0]
    if share == 0.5:  # the next process finds it whole again
        assert process(TRIPLED.format(text=TEXT), folder) == (0, [0.0, 3.0, 6.0])


def test_garbage_is_recovered(folder):
    tripled()
    for path in folder.rglob("*.nb?"):
        path.write_bytes(b"\x80\x04garbage" * 50)
    assert tripled() == [0.0, 3.0, 6.0]


def test_without_a_place_to_write_steps_are_compiled_all_the_same(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("a file where the folder should be")
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "file" / "cache"))
    assert tripled() == [0.0, 3.0, 6.0]


def test_two_processes_may_start_at_once(folder):
    """Both write under names of their own and one of them comes first; neither fails, both are right, one entry is left."""
    code = COUNTED.format(code=TRIPLED.format(text=TEXT))
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
    both = [subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [process.communicate(timeout=300)[0] for process in both]
    assert [json.loads(text)[1] for text in outputs] == [[0.0, 3.0, 6.0]] * 2
    assert len(list(folder.iterdir())) == 1
