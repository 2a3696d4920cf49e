"""Files for publication agree with the package: dependencies, versions of Python, sections of the paper."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
SECTIONS = [
    "Summary", "Statement of need", "State of the field", "Software design", "Research impact statement",
    "AI usage disclosure", "Acknowledgements", "References",
]  # fmt: skip
CONDA_NAMES = {"matplotlib": "matplotlib-base"}


def test_the_conda_recipe_has_the_dependencies_and_the_version_of_the_package() -> None:
    recipe = (ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    run = recipe.partition("  run:\n")[2].partition("\n\n")[0]
    listed = dict(re.findall(r"- ([\w-]+) >=([\d.]+)", run))
    python = PROJECT["requires-python"].removeprefix(">=")
    wanted = dict(re.fullmatch(r"([\w-]+)>=([\d.]+)", one).groups() for one in PROJECT["dependencies"])  # type: ignore[union-attr]
    assert listed == {CONDA_NAMES.get(name, name): bound for name, bound in wanted.items()} | {
        "python": python
    }
    import vfife

    assert f'version: "{vfife.__version__}"' in recipe


def test_the_forge_tests_the_oldest_and_newest_python_on_three_systems() -> None:
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    versions = [one.rpartition(" ")[2] for one in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", one)]
    assert versions[0] == PROJECT["requires-python"].removeprefix(">=")
    assert f'python: ["{versions[0]}", "{versions[-1]}"]' in workflow
    assert "os: [ubuntu-latest, windows-latest, macos-latest]" in workflow


def test_the_paper_has_every_section_and_every_citation_an_entry() -> None:
    paper = (ROOT / "joss" / "paper.md").read_text(encoding="utf-8")
    assert re.findall(r"^# (.+)$", paper, re.M) == SECTIONS
    entries = set(re.findall(r"^@\w+\{(\w+),$", (ROOT / "joss" / "paper.bib").read_text("utf-8"), re.M))
    assert set(re.findall(r"@(\w+)", paper.partition("# Summary")[2])) == entries


def test_the_project_has_addresses() -> None:
    assert {"Homepage", "Documentation", "Source", "Issues", "Changelog"} <= set(PROJECT["urls"])
    assert all(address.startswith("https://") for address in PROJECT["urls"].values())
