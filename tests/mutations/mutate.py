"""Does the suite notice small faults? ``make mutations`` draws some of each package, and ends with 1 where
one is not noticed.

Each fault goes into a copy of the package, never into the working tree. A process of its own runs tests of
the suite in that copy. For the kernels these are what is quick and sees most first: mechanisms against the
constrained equations, hashes of the bits of the straight-line loop, then whole files of tests. For other
packages they are the tests that run the faulty line, which is recorded once (``reach.py``). What changes no
result is listed with its reason in ``equivalent.txt``.

  mutate.py --package measures --seed 1 --count 40
"""

from __future__ import annotations

import argparse
import compileall
import importlib
import json
import linecache
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from difflib import unified_diff
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

import pytest

from mutations import faults
from mutations.faults import PACKAGES
from mutations.judge import Copy
from mutations.mutants import Mutant, drawn
from mutations.reach import SUITES, Reach, record

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
SOURCE = ROOT / "src" / "vfife"
LONGEST = 120.0  # s of processor time that the first tests may take: a fault can make a loop endless
QUICK = [("contact", k) for k in range(4)] + [("loop", 1), ("chain", 0), ("gears", 0), ("redundant", 0),
    ("chain", 2), ("loop", 5), ("gears", 3),
         ("chain", 4), ("redundant", 1), ("redundant", 2), ("chain", 5), ("contact", 17),
         ("linked", 1)]  # fmt: skip
# Files of tests of a kernel by itself, which need no compilation.
OWN = {
    "elementary": [
        "tests/kernels/test_elementary.py",
        "tests/laws/test_friction_solutions.py",
        "tests/laws/test_bristles.py",
    ],
    "frame": ["tests/kernels/test_frame.py", "tests/assembly/test_stiffness.py"],
    "closing": ["tests/kernels/test_closing.py"],
    "constraint": ["tests/kernels/test_closing.py", "tests/kernels/test_constraint.py"],
    "polynomial": ["tests/model/test_functions.py"],
    "spring": ["tests/physics/test_loads_and_drivers.py"],
    "central_difference": ["tests/kernels/test_central_difference.py"],
    "geometry": ["tests/kernels/test_central_difference.py", "tests/physics/test_curved_slot.py"],
    "step": ["tests/kernels/test_central_difference.py", "tests/physics/test_loads_and_drivers.py"],
}
# Files of tests that a fault in a kernel should be seen by, where the first did not.
CLOSE = {
    "elementary": [
        "tests/kernels/test_elementary.py",
        "tests/laws/test_forms.py",
        "tests/laws/test_contact_laws.py",
    ],
    "polynomial": ["tests/model/test_functions.py", "tests/physics/test_loads_and_drivers.py"],
    "frame": ["tests/kernels/test_frame.py", "tests/physics/test_beams.py"],
    "spring": ["tests/physics/test_machinery.py", "tests/physics/test_accounts.py"],
    "contact": [
        "tests/kernels/test_contact_step.py",
        "tests/physics/test_journal_in_bearing.py",
        "tests/physics/test_accounts.py",
        "tests/physics/test_sticking.py",
        "tests/physics/test_lubricated_journal.py",
    ],
    "constraint": ["tests/physics/test_ideal_joints.py", "tests/physics/test_rigid_joints.py"],
    "closing": [
        "tests/assembly/test_timestep.py",
        "tests/physics/test_massless_links.py",
        "tests/physics/test_ideal_joints.py",
        "tests/physics/test_rigid_joints.py",
    ],
    "factors": ["tests/physics/test_ideal_joints.py", "tests/physics/test_rigid_joints.py"],
    "central_difference": ["tests/kernels/test_central_difference.py"],
    "geometry": ["tests/kernels", "tests/physics/test_curved_slot.py"],
    "step": ["tests/kernels", "tests/physics/test_accounts.py", "tests/physics/test_machinery.py"],
    "advance": ["tests/kernels", "tests/physics/test_accounts.py", "tests/solvers/test_companions.py"],
}
REST = [
    "tests/kernels",
    "tests/kinematics",
    "tests/physics",
    "tests/solvers",
    "tests/measures",
    "tests/model",
    "tests/compiler",
    "tests/golden",
    "tests/assembly",
]


class Quick:
    """The quick tests: what does not depend on the kernels is computed once, in the process that makes all
    others.
    """

    def __init__(self) -> None:
        from differential.compared import fitting, stepped
        from differential.test_against_equations import STEPS, check
        from golden.test_golden import CASES, KINDS, digest

        self.drawn = [fitting(seed, family) for family, seed in QUICK]
        self.check = lambda one, exact: check(stepped(one, exact, STEPS, "interpreted"))
        self.digest = lambda name: digest(name, "generated")
        self.bits = json.loads(
            in_a_child(lambda: json.dumps({name: self.digest(name) for name in (*KINDS, *CASES)}))
        )

    def __call__(self) -> str:
        """Which of them sees a fault in the kernels of this process; nothing where none does."""
        for one, exact in self.drawn:
            try:
                self.check(one, exact)
            except BaseException as error:
                return f"differential {one.label} ({type(error).__name__})"
        for name, bits in self.bits.items():
            try:
                if self.digest(name) != bits:
                    return f"golden {name}"
            except BaseException as error:
                return f"golden {name} ({type(error).__name__})"
        return ""


def put(mutant: Mutant, text: str, file: Path) -> None:
    """Gives the function of a fault its new code, wherever it was imported; ``file`` has the text."""
    from importlib import import_module

    module = import_module(f"vfife.kernels.{mutant.file}")
    space = dict(vars(module))
    exec(compile(text, str(file), "exec"), space)
    getattr(module, mutant.function).__code__ = space[mutant.function].__code__
    linecache.checkcache()


def in_a_child(work: Callable[[], str]) -> str:
    """What a function says in a process of its own; one that does not come back has seen something."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        signal.setitimer(signal.ITIMER_PROF, LONGEST)  # kills it
        os.close(read)
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        try:
            said = work()
        except BaseException as error:
            said = f"at once ({type(error).__name__}: {error})"
        os.write(write, (said or "-").encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        said = pipe.read()
    os.waitpid(child, 0)
    return "" if said == "-" else said or "it took too long"


def by_pytest(
    source: Path, files: Sequence[str], but: Collection[str] = (), *, all_of_them: bool = False
) -> list[str]:
    """Tests of some files that fail with a copy of the package: the first one, or all; ``but``
    are not run.
    """
    variables = {**os.environ, "PYTHONPATH": str(source.parent), "VFIFE_CACHE": str(source.parent / "cache")}
    line = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-n",
        "0",
        "-m",
        SUITES,
        *([] if all_of_them else ["-x"]),
        *files,
    ]
    line += [word for test in but for word in ("--deselect", test)]
    done = subprocess.run(line, cwd=ROOT, env=variables, capture_output=True, text=True, check=False)
    failed = [
        text.split(" ", 1)[1].split(" - ")[0]
        for text in done.stdout.splitlines()
        if text.startswith(("FAILED", "ERROR"))
    ]
    return failed or ([] if done.returncode in (0, 5) else [f"pytest ended with {done.returncode}"])


@dataclass
class Suite:
    """A copy of the package, and what holds of it without any fault."""

    base: Path
    quick: Quick
    red: dict[tuple[str, ...], list[str]] = field(
        default_factory=dict
    )  # tests that fail anyway, by the files that were asked for

    def with_it(self, mutant: Mutant, work: Callable[[str, Path], str | list[str]]) -> Any:
        """What is done while the copy has a fault."""
        file = self.base / "vfife" / "kernels" / f"{mutant.file}.py"
        whole = file.read_text()
        try:
            file.write_text(mutant.applied(whole))
            return work(mutant.applied(whole), file)
        finally:
            file.write_text(whole)

    def quickly(self, mutant: Mutant) -> str:
        """Which of the quick tests sees a fault; nothing where none does."""

        def work(text: str, file: Path) -> str:
            put(mutant, text, file)
            files = OWN.get(mutant.file, [])
            os.chdir(ROOT)
            return (
                self.quick()
                or (
                    files
                    and pytest.main(["-x", "-q", "-p", "no:cacheprovider", "-n", "0", *files]) == 1
                    and files[0]
                )
                or ""
            )

        found: str = self.with_it(mutant, lambda text, file: in_a_child(lambda: work(text, file)))
        return found

    def slowly(self, mutant: Mutant, files: Sequence[str]) -> str:
        """Which test of some files sees a fault, those aside that fail without it."""
        key = tuple(files)
        found = self.with_it(mutant, lambda *_: by_pytest(self.base / "vfife", files, self.red.get(key, ())))
        if found and key not in self.red:
            self.red[key] = by_pytest(self.base / "vfife", files, all_of_them=True)
            if set(found) & set(self.red[key]):
                return self.slowly(mutant, files)
        return found[0] if found else ""


def equivalent() -> set[str]:
    """Faults that change no result, from their list: one a line, the reason after a tab.

    Those of the kernels stand there by their labels, those of other packages with the line of the text too.
    """
    lines = (TESTS / "mutations" / "equivalent.txt").read_text().splitlines()
    return {line.split("\t")[0] for line in lines if line and not line.startswith("#")}


def main() -> int:
    """Draw faults and print which are seen."""
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument(
        "--package",
        action="append",
        choices=["kernels", *PACKAGES],
        help="may come several times; all of them unless said",
    )
    ask.add_argument(
        "--module",
        action="append",
        default=[],
        help="only these modules of a package, such as turns; not of the kernels",
    )
    ask.add_argument("--seed", type=int, default=11)
    ask.add_argument(
        "--count", type=int, help="faults of each package; 100 of the kernels and 40 of any other unless said"
    )
    ask.add_argument("--quick", action="store_true", help="only the quick tests of the kernels")
    ask.add_argument(
        "--record",
        nargs="*",
        metavar="TESTS",
        help="record anew which test runs which line, of all or of some files of tests",
    )
    given = ask.parse_args()
    if given.record is not None:
        record(given.record)
    packages = given.package or ["kernels", *PACKAGES]
    alive = [
        one
        for package in packages
        if package != "kernels"
        for one in of_package(package, given.seed, given.count or 40, tuple(given.module))
    ]
    code = of_kernels(given.seed, given.count or 100, given.quick) if "kernels" in packages else 0
    return 1 if alive else code


def of_package(package: str, seed: int, count: int, modules: tuple[str, ...]) -> list[Mutant]:
    """Draw faults of a package and print which are seen; return those that are not, whose differences are
    printed too.
    """
    known, seen = equivalent(), {}
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder), Reach())
        mutants = faults.drawn(SOURCE, package, seed, count, modules)
        left = list(mutants)
        while left:
            for mutant in left:
                seen[mutant] = "equivalent" if mutant.place in known else copy.judged(mutant)
                print(
                    f"{seen[mutant] or 'NOT SEEN'}\n    {mutant.kind}, line {mutant.line}: {mutant.place}",
                    flush=True,
                )
            red = copy.fail_anyway(set(seen.values()))
            left = [mutant for mutant, said in seen.items() if said in red]
    alive, same = (
        [mutant for mutant, said in seen.items() if not said],
        sum(said == "equivalent" for said in seen.values()),
    )
    for mutant in alive:
        print(difference(mutant))
    told = f"{len(mutants) - same - len(alive)} seen, {same} equivalent, {len(alive)} not seen"
    print(f"{package}, seed {seed}: {len(mutants)} drawn, {told}", flush=True)
    return alive


def difference(mutant: Mutant) -> str:
    """What a fault changes in the text, as a patch has it."""
    file = SOURCE / f"{mutant.file.replace('.', '/')}.py"
    whole = file.read_text()
    name = f"src/vfife/{mutant.file.replace('.', '/')}.py"
    return "".join(
        unified_diff(whole.splitlines(True), mutant.applied(whole).splitlines(True), name, name, n=0)
    )


def of_kernels(seed: int, count: int, quick: bool) -> int:
    """Draw faults of the kernels and print which are seen; 1 where one is not."""
    for library in (
        "hypothesis",
        "llvmlite.binding",
        "numpy",
        "scipy.integrate",
    ):  # what each child would load
        importlib.import_module(library)
    known, alive = equivalent(), []
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        shutil.copytree(SOURCE, base / "vfife", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(ROOT / "examples", base / "vfife" / "examples")
        compileall.compile_dir(base, quiet=1)  # a file with a fault is compiled anew, and kept nowhere
        sys.dont_write_bytecode = True
        os.environ["VFIFE_CACHE"] = str(base / "cache")
        sys.path.insert(0, str(base))
        suite = Suite(base, Quick())
        if said := in_a_child(suite.quick):  # and the tests of OWN hold, or all faults were seen
            print(f"without any fault: {said}")
            return 2
        mutants = drawn(SOURCE / "kernels", seed, count)
        for number, mutant in enumerate(mutants):
            said = "equivalent" if mutant.label in known else suite.quickly(mutant)
            alive += [] if said else [mutant]
            print(
                f"{number:3d} {said or 'not seen quickly':42s} {mutant.kind}, line {mutant.line}:"
                f" {mutant.label}",
                flush=True,
            )
        print(f"seed {seed}: {len(mutants) - len(alive)} of {len(mutants)} seen quickly, or equivalent")
        if not quick:
            for mutant in list(alive):
                said = suite.slowly(mutant, CLOSE.get(mutant.file, REST)) or suite.slowly(mutant, REST)
                print(f"{said or 'NOT SEEN'}: line {mutant.line}: {mutant.label}", flush=True)
                alive = [one for one in alive if one is not mutant or not said]
    print(f"kernels, seed {seed}: {len(alive)} of {len(mutants)} not seen")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
