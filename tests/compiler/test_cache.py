"""What is kept on disk: a second process compiles nothing, no broken or foreign file stands in the way,
nobody else can write there.
"""

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from choice import default_cases
from support import bits, journal_in_bearing, lanes, rounds
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime import cache, loops, native
from vfife.laws import Frictionless

POSIX = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and permissions are those of POSIX")

RUN = """
import json, sys
sys.path.insert(0, {tests!r})
from support import go, journal_in_bearing
from vfife.compiler.runtime import loops
written = []
make = loops.step_code
loops.step_code = lambda *given: written.append(1) or make(*given)
record = go(journal_in_bearing(), 1e-6, duration=1e-3, loop="generated")
print(json.dumps([len(written), "numba" in sys.modules, record.rows.tobytes().hex()[-4000:]]))
"""


def command() -> list[str]:
    return [sys.executable, "-c", RUN.format(tests=str(Path(__file__).parents[1]))]


def environment(**changes: str) -> dict[str, str]:
    return dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p)) | changes


def answer(text: str) -> tuple[int, bool, str]:
    compiled, numba, rows = json.loads(text.splitlines()[-1])
    return compiled, numba, rows


def process(**changes: str) -> tuple[int, bool, str]:
    """Steps compiled in a fresh process, whether it imported numba, and the bits of its last rows."""
    done = subprocess.run(
        command(), env=environment(**changes), capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return answer(done.stdout)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


ASSEMBLY = assemble(journal_in_bearing(), 1e-6, duration=1e-3, force_step=True)
OTHER = assemble(journal_in_bearing(friction=Frictionless()), 1e-6, duration=1e-3, force_step=True).topology


def fresh(monkeypatch) -> tuple[int, np.ndarray]:
    """Runs as a new process would: steps compiled, and the state after some of them."""
    loops.straight_line.cache_clear()
    made, make = [], loops.step_code
    with monkeypatch.context() as patch:
        patch.setattr(loops, "step_code", lambda *given: made.append(1) or make(*given))
        runner = lanes([ASSEMBLY], "generated")
    runner.advance(300, 1)
    loops.straight_line.cache_clear()
    return len(made), runner.S.copy()


def kept(folder: Path) -> Path:
    (path,) = folder.glob("step-*.o")
    return path


@pytest.mark.system("starts processes")
def test_a_second_process_compiles_nothing_and_needs_no_numba(folder):
    first = process()
    before = {p.name: p.stat().st_mtime_ns for p in folder.iterdir()}
    second = process()
    assert (first[0], second[0]) == (1, 0)
    assert not first[1] and not second[1]
    assert first[2] == second[2]
    assert {p.name: p.stat().st_mtime_ns for p in folder.iterdir()} == before


@pytest.mark.system("starts several processes")
@pytest.mark.rounds
def test_several_processes_may_start_at_once(folder):
    """All write under names of their own; none fails, all are right, one entry is left."""
    given = {"env": environment(VFIFE_CACHE=str(folder)), "stdout": subprocess.PIPE, "text": True}
    some = [subprocess.Popen(command(), **given) for _ in range(rounds(8, 3))]
    rows = {answer(one.communicate(timeout=300)[0])[2] for one in some}
    assert len(rows) == 1
    assert sorted(path.name.partition("-")[0] for path in folder.iterdir()) == ["loop", "loop", "step"], (
        "the routines of numerics, the driver, and the step"
    )


@pytest.mark.parametrize(
    "harm",
    default_cases(
        ["empty", "half", "cut", "flipped", "garbage", "unsealed", "longer"],
        lambda harm: harm in ("cut", "flipped", "unsealed"),
        "compiles a step for each harm",
    ),
)
def test_a_broken_file_is_compiled_anew(folder, monkeypatch, harm):
    """A full disk, a killed process, a bit that fell over: the step is compiled again and the file mended."""
    _, whole = fresh(monkeypatch)
    path = kept(folder)
    found = path.read_bytes()
    middle = len(found) // 2
    changed = {
        "empty": b"", "half": found[:middle], "cut": found[:-1],
        "flipped": found[:middle] + bytes([found[middle] ^ 1]) + found[middle + 1 :],
        "garbage": b"\x80\x04garbage" * 500, "unsealed": found[len(cache.MAGIC) + 65 :],
        "longer": found + b"\0",
    }[harm]  # fmt: skip
    path.write_bytes(changed)
    compiled, again = fresh(monkeypatch)
    assert compiled == 1 and (bits(again) == bits(whole)).all()
    assert path.read_bytes() == found
    assert fresh(monkeypatch)[0] == 0


def test_a_foreign_file_is_compiled_anew(folder, monkeypatch):
    """Whole and sealed, but of another step: its name is in its seal."""
    _, whole = fresh(monkeypatch)
    path = kept(folder)
    found = path.read_bytes()
    loops.straight_line(OTHER, 1)
    (foreign,) = set(folder.glob("step-*.o")) - {path}
    path.write_bytes(foreign.read_bytes())
    compiled, again = fresh(monkeypatch)
    assert compiled == 1 and (bits(again) == bits(whole)).all()
    assert path.read_bytes() == found


@pytest.mark.parametrize("what", ["sources", "processor", "compiler", "width", "topology"])
def test_what_decides_the_code_decides_its_name(monkeypatch, what):
    """A stale file is never met: it goes by another name."""
    topology, width = ASSEMBLY.topology, 1
    before = loops.name_of(topology, width)
    assert loops.name_of(topology, width) == before
    if what == "sources":
        monkeypatch.setattr(cache, "sources", lambda: b"another text")
    elif what == "processor":
        monkeypatch.setattr(native, "processor", lambda: (native._target().get_host_cpu_name(), "+another"))
    elif what == "compiler":
        monkeypatch.setattr("llvmlite.__version__", "0.0")
    elif what == "width":
        width = 2
    else:
        topology = OTHER
    assert loops.name_of(topology, width) != before


def test_every_text_of_the_step_is_among_its_sources(tmp_path, monkeypatch):
    """A nudged coefficient in a kernel, a law or a writer never meets old machine code."""
    package = Path(cache.__file__).parents[2]
    for part in (
        "kernels/frame.py",
        "laws/contact/flores.py",
        "compiler/backends/llvm.py",
        "compiler/backends/modules.py",
    ):
        copy = tmp_path / part.replace("/", "-")
        for name in ("kernels", "compiler", "laws"):
            for source in (package / name).rglob("*"):
                if source.suffix in (".py", ".ll", ".js"):
                    target = copy / name / source.relative_to(package / name)
                    target.parent.mkdir(parents=True, exist_ok=True)
                    target.write_bytes(source.read_bytes())
        monkeypatch.setattr(cache, "__file__", str(copy / "compiler" / "runtime" / "cache.py"))
        before = cache.sources.__wrapped__()
        (copy / part).write_text((copy / part).read_text() + "\n")
        assert cache.sources.__wrapped__() != before


def test_without_a_place_to_write_steps_are_compiled_all_the_same(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("a file where the folder should be")
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "file" / "cache"))
    first, second = fresh(monkeypatch), fresh(monkeypatch)
    assert first[0] == second[0] == 1 and (bits(first[1]) == bits(second[1])).all()


@pytest.mark.system("starts a process that compiles everything")
def test_without_a_home_steps_are_compiled_all_the_same(tmp_path):
    nowhere = environment(HOME=str(tmp_path / "missing" / "home"))
    for name in ("VFIFE_CACHE", "XDG_CACHE_HOME"):
        nowhere.pop(name, None)
    (tmp_path / "missing").write_text("no folder")
    done = subprocess.run(command(), env=nowhere, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert answer(done.stdout)[0] == 1


@POSIX
def test_the_folder_is_its_owners_alone(folder, monkeypatch):
    fresh(monkeypatch)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(kept(folder).stat().st_mode) == 0o600
    folder.chmod(0o755)  # others could read
    assert fresh(monkeypatch)[0] == 0
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@POSIX
def test_a_folder_that_others_can_write_to_is_not_used(folder, monkeypatch):
    fresh(monkeypatch)
    before = kept(folder).read_bytes()
    folder.chmod(0o777)
    compiled, _ = fresh(monkeypatch)
    assert compiled == 1 and kept(folder).read_bytes() == before


@POSIX
def test_a_folder_of_another_owner_is_not_used(folder, monkeypatch):
    fresh(monkeypatch)
    monkeypatch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1)
    assert fresh(monkeypatch)[0] == 1


@POSIX
@pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_is_read(folder, monkeypatch):
    fresh(monkeypatch)
    folder.chmod(0o500)
    assert fresh(monkeypatch)[0] == 0
    folder.chmod(0o700)


def test_what_was_not_used_for_the_longest_time_goes(folder, monkeypatch):
    """Each file of a hundred bytes or so; reading one makes it young again, and what is not ours stays."""
    monkeypatch.setattr(cache, "MOST_BYTES", 1000)
    names = [f"step-{k:040x}.o" for k in range(12)]
    folder.mkdir(mode=0o700)
    (folder / "notes.txt").write_text("mine")
    for k, name in enumerate(names[:5]):
        cache.keep(name, bytes(60))
        os.utime(folder / name, (k + 1, k + 1))
    assert cache.read(names[0]) is not None
    for k, name in enumerate(names[5:]):
        cache.keep(name, bytes(60))
        if (folder / name).exists() and k < 6:
            os.utime(folder / name, (k + 10, k + 10))
    left = {path.name for path in folder.iterdir()}
    assert sum(path.stat().st_size for path in folder.iterdir()) <= 1000
    assert {names[0], names[-1], "notes.txt"} <= left and names[1] not in left


@pytest.mark.parametrize("where", ["cache", "./cache"])
def test_never_relative_to_the_working_folder(tmp_path, monkeypatch, where):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("VFIFE_CACHE", where)
    cache.keep("step-1.o", b"code")
    assert cache.read("step-1.o") is None and not list(tmp_path.iterdir())
    assert "absolute path" in cache.trouble()
    monkeypatch.delenv("VFIFE_CACHE")
    for name in ("XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    cache.keep("step-1.o", b"code")
    assert not list(tmp_path.iterdir())
    monkeypatch.setenv("VFIFE_CACHE", str(tmp_path / "good"))
    cache.keep("step-1.o", b"code")
    assert cache.trouble() == "" and cache.read("step-1.o") == b"code"


@pytest.mark.parametrize("step", [1, 7])
def test_flipped_bits_anywhere_are_seen(folder, step):
    """Step, loop and text alike: name, seal and content."""
    whole = bytes(range(256)) * 4
    for name in ("step-a.o", "loop-a.o", "text-a.py"):
        cache.keep(name, whole)
        sound = (folder / name).read_bytes()
        for place in range(0, len(sound), 97 // step):
            changed = bytearray(sound)
            changed[place] ^= 1 << (place * step % 8)
            (folder / name).write_bytes(changed)
            assert cache.read(name) is None
        (folder / name).write_bytes(sound)
        assert cache.read(name) == whole
