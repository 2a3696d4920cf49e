"""Which tests run a line of the package: recorded once by running parts of the suite under coverage, and kept
until it is recorded anew.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from mutations.faults import PACKAGES
from mutations.mutants import Mutant

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / ".mutations"  # ignored by git
SUITES = "not verify and not soak and not bench"  # tests that judge
PARTS = (
    "measures",
    "assembly",
    "kinematics",
    "physics",
    "results",
    "solvers",
    "studies",
    "identification",
    "dynamics",
    "tribology",
)  # of the suite
# They start processes of their own, whose lines nobody sees, or write gigabytes.
LEFT_OUT = (
    "results/test_killed_processes.py",
    "results/test_large_files.py",
    "results/test_threads.py",
    "studies/test_cluster.py",
)
NEAR = 12  # lines after that of a default, in which the function lies that it belongs to
DURATION = re.compile(r"^([0-9.]+)s (?:call|setup)\s+(\S.*)$")


def record(tests: Sequence[str] = ()) -> None:
    """Run the parts of the suite once under coverage, which takes some ten minutes, and keep what each test
    runs and how long it takes.

    ``tests``: only these files or folders, what is known of others staying as it is.
    """
    FOLDER.mkdir(exist_ok=True)
    source = ",".join(f"src/vfife/{package}" for package in PACKAGES)
    (FOLDER / "coveragerc").write_text(f"[run]\nsource = {source}\ndata_file = {FOLDER}/coverage\n")
    line = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-n",
        "0",
        "-m",
        SUITES,
        "-p",
        "no:cacheprovider",
        "--durations=0",
        "-vv",
    ]
    line += ["--cov", f"--cov-config={FOLDER}/coveragerc", "--cov-context=test", "--cov-report="]
    line += tests or [*(f"tests/{part}" for part in PARTS), *(f"--ignore=tests/{file}" for file in LEFT_OUT)]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    found, file = measured(done.stdout), FOLDER / "reach.json"
    if tests and file.exists():
        found = merged(json.loads(file.read_text()), found, tests)
    file.write_text(json.dumps(found))


def measured(said: str) -> dict[str, Any]:
    """What a run recorded: ``names`` of tests that passed, what they ``took`` (s), and per source file the
    places of tests by line.
    """
    from coverage import CoverageData

    took: dict[str, float] = defaultdict(float)
    red = {
        line.split(" ", 1)[1].split(" - ")[0]
        for line in said.splitlines()
        if line.startswith(("FAILED", "ERROR"))
    }
    for line in said.splitlines():
        if found := DURATION.match(line):
            took[found[2]] += float(found[1])
    data = CoverageData(str(FOLDER / "coverage"))
    data.read()
    names = sorted(
        one
        for one in {context.rsplit("|", 1)[0] for context in data.measured_contexts()}
        if one and one not in red
    )
    place, lines = {name: k for k, name in enumerate(names)}, {}
    for file in data.measured_files():
        at = Path(file).resolve().relative_to(ROOT / "src" / "vfife").as_posix()
        lines[at] = {
            str(line): sorted({place[name] for one in contexts if (name := one.rsplit("|", 1)[0]) in place})
            for line, contexts in data.contexts_by_lineno(file).items()
        }
    return {"names": names, "took": [took.get(name, 0.0) for name in names], "lines": lines}


def merged(old: dict[str, Any], new: dict[str, Any], tests: Sequence[str]) -> dict[str, Any]:
    """The old recording with what is new of some files in the place of what it had of them."""
    gone = {k for k, name in enumerate(old["names"]) if name.startswith(tuple(tests))}
    count, lines = len(old["names"]), old["lines"]
    for of_file in lines.values():
        for line, places in of_file.items():
            of_file[line] = [k for k in places if k not in gone]
    for file, of_file in new["lines"].items():
        own = lines.setdefault(file, {})
        for line, places in of_file.items():
            own[line] = own.get(line, []) + [count + k for k in places]
    return {"names": old["names"] + new["names"], "took": old["took"] + new["took"], "lines": lines}


class Reach:
    """What was recorded: the tests that run a line, those first that are likely to see a fault there soon."""

    @cached_property
    def known(self) -> dict[str, dict[int, list[int]]]:
        """Tests by source file and line."""
        return {
            file: {int(line): tests for line, tests in lines.items()}
            for file, lines in self.recorded["lines"].items()
        }

    @cached_property
    def recorded(self) -> dict[str, Any]:
        """All of it."""
        if not (FOLDER / "reach.json").exists():
            print("recording which test runs which line (some ten minutes) ...", flush=True)
            record()
        found: dict[str, Any] = json.loads((FOLDER / "reach.json").read_text())
        return found

    @cached_property
    def sizes(self) -> Counter[int]:
        """How many lines each test runs."""
        return Counter(test for lines in self.known.values() for tests in lines.values() for test in tests)

    def tests(self, mutant: Mutant, text: str) -> list[tuple[str, float]]:
        """Tests that run the lines of a fault and how long each takes (s): those of its own package first,
        quick ones before slow ones.

        Those that run few lines in all come first, for they are about these. Of a
        constant of a module, which runs when it is imported, those of all its lines.
        """
        lines = self.known.get(mutant.file.replace(".", "/") + ".py", {})
        first = mutant.line
        last = first + text[slice(*mutant.span)].count("\n")
        found = {test for line in range(first, last + 1) for test in lines.get(line, [])}
        if not found:  # a default or a constant, which nobody runs but the import
            near = range(first, last + NEAR) if mutant.function else lines
            found = {test for line in near for test in lines.get(line, [])}
        own = f"tests/{mutant.file.split('.')[0]}/"
        names, took, size = self.recorded["names"], self.recorded["took"], self.sizes
        ranked = sorted(
            found, key=lambda k: (took_class(took[k]), not names[k].startswith(own), size[k], names[k])
        )
        return [(names[k], took[k]) for k in ranked]


def took_class(seconds: float) -> int:
    """Of which order a duration is: below a second, five, or more; it was measured under coverage, on a
    machine that may have been busy.
    """
    return 0 if seconds < 1.0 else 1 if seconds < 5.0 else 2
