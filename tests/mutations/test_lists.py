"""What the lists of `make mutations` name is there: packages, modules, files of tests, and faults."""

from __future__ import annotations

from pathlib import Path

import pytest

from mutations import faults, mutants
from mutations.reach import LEFT_OUT, PARTS

TESTS = Path(__file__).resolve().parents[1]
SOURCE = TESTS.parent / "src" / "vfife"


@pytest.mark.parametrize("package", faults.PACKAGES)
def test_modules_are_there(package: str) -> None:
    stems = {path.stem for path in (SOURCE / package).rglob("*.py")}
    assert stems and set(faults.MODULES[package]) <= stems


def test_parts_of_the_suite_are_there() -> None:
    assert [part for part in (*PARTS, *LEFT_OUT) if not (TESTS / part).exists()] == []


def test_faults_without_effect_are_faults_of_today() -> None:
    lines = (TESTS / "mutations" / "equivalent.txt").read_text("utf-8").splitlines()
    listed = {line.split("\t")[0] for line in lines if line and not line.startswith("#")}
    known: set[str] = set()
    for package, *inner in {tuple(one.partition(":")[0].split(".")[:-1]) for one in listed}:
        if inner:
            known |= {one.place for one in faults.every(SOURCE, package, (inner[-1],))}
    known |= {one.label for one in mutants.every(SOURCE / "kernels")}
    assert listed - known == set()
