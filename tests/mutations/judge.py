"""Judge faults in a copy of the package: a warm process forks, loads the faulty copy, and runs the tests that
reach the fault.
"""

from __future__ import annotations

import compileall
import os
import shutil
import signal
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mutations.mutants import Mutant
from mutations.reach import ROOT, SUITES, Reach

SOURCE = ROOT / "src" / "vfife"
# Tests of the first look at a fault and of the second: what so many that run the line do not see wants a test
# of its own.
FEW, MORE = 16, 400
# s that the tests of a second look took when they were recorded; beyond that a fault counts as not seen
LONGEST = 120.0
# s of processor time that a look may take: a fault can make a loop endless. Four times what was recorded, and
# some to begin with.
SLACK, TIMES = 10.0, 4.0
# What most tests load, once for all forks.
WARM = (
    "hypothesis", "llvmlite.binding", "numpy", "pandas", "pytest", "rich.console", "scipy.integrate",
    "scipy.interpolate", "scipy.optimize", "scipy.special", "scipy.stats", "typer.testing", "xarray",
)  # fmt: skip


@dataclass
class Copy:
    """A copy of the package in a folder, and the tests that fail in it without any fault."""

    base: Path
    reach: Reach
    red: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        for library in WARM:
            __import__(library)
        shutil.copytree(SOURCE, self.base / "vfife", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(ROOT / "examples", self.base / "vfife" / "examples")
        compileall.compile_dir(self.base, quiet=1)

    def judged(self, mutant: Mutant) -> str:
        """The test that sees a fault, or nothing."""
        file = self.base / "vfife" / f"{mutant.file.replace('.', '/')}.py"
        whole = file.read_text()
        tests = self.reach.tests(mutant, whole)
        if not tests:
            return ""
        cached = file.parent / "__pycache__" / f"{file.stem}.{sys.implementation.cache_tag}.pyc"
        cached.unlink(missing_ok=True)
        try:
            file.write_text(mutant.applied(whole))
            return self.look(tests[:FEW]) or self.look(within(tests[FEW : FEW + MORE], LONGEST))
        finally:
            file.write_text(whole)

    def look(self, tests: Sequence[tuple[str, float]]) -> str:
        """The first of these tests that fails, or nothing; they held without any fault when they were
        recorded.
        """
        names = [name for name, _ in tests if name not in self.red]
        return run(self.base, names, SLACK + TIMES * sum(seconds for _, seconds in tests)) if names else ""

    def fail_anyway(self, tests: Collection[str]) -> set[str]:
        """Those of some tests that fail without any fault now, which are left out from now on."""
        left, found = {name for name in tests if "::" in name}, set()
        while left and (failed := run(self.base, sorted(left), LONGEST * TIMES)) in left:
            left.remove(failed)
            found.add(failed)
        self.red |= found
        return found


def within(tests: Sequence[tuple[str, float]], longest: float) -> list[tuple[str, float]]:
    """The first of them that took no longer together."""
    found, whole = [], 0.0
    for name, seconds in tests:
        whole += seconds
        if whole > longest:
            break
        found.append((name, seconds))
    return found


def run(base: Path, tests: Collection[str], limit: float) -> str:
    """Run tests with the copy in ``base`` in a fork of this process: the first that fails, why none could
    run, or nothing.
    """
    out = base / "said.txt"
    out.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        signal.setitimer(signal.ITIMER_PROF, limit)  # kills it
        try:
            os._exit(in_child(base, tests, out))
        except BaseException:
            os._exit(9)
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        return f"it took too long or died ({signal.Signals(os.WTERMSIG(status)).name})"
    code = os.WEXITSTATUS(status)
    if code in (0, 5):
        return ""
    said = out.read_text() if out.exists() else ""
    failed = [
        line.split(" ", 1)[1].split(" - ")[0]
        for line in said.splitlines()
        if line.startswith(("FAILED", "ERROR"))
    ]
    return failed[0] if failed else f"pytest ended with {code}"


def in_child(base: Path, tests: Collection[str], out: Path) -> int:
    """What the fork does: pytest in it, with the copy before the installed package."""
    import pytest

    os.chdir(ROOT)
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(base))
    os.environ |= {
        "PYTHONPATH": str(base),
        "VFIFE_CACHE": str(ROOT / ".mutations" / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    with out.open("w") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    return int(
        pytest.main(["-x", "-q", "-n", "0", "-m", SUITES, "-p", "no:cacheprovider", "--tb=no", *tests])
    )
