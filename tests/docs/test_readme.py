"""The README shows what the package does today: its block is the demo's output, its counts and links hold."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from vfife.laws import ContactLaw, FrictionLaw

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LARGEST = 700_000  # bytes of a picture in the README


@pytest.fixture
def texts(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    monkeypatch.setattr("sys.argv", ["texts.py"])
    return runpy.run_path(str(ROOT / ".ci" / "texts.py"))


@pytest.mark.system("runs the demo")
def test_the_block_of_the_readme_is_the_output_of_the_demo(texts: dict[str, object]) -> None:
    printed, _ = texts["demo"]()  # type: ignore[operator]
    (shown,) = re.findall(r"<!-- demo:[^\n]*-->\n```text\n(.*?)\n```", README, re.S)
    assert shown == printed, "run: make texts"


def test_counts_of_laws_hold() -> None:
    built_in = [
        sum(law.__module__.startswith("vfife.") for law in kind.registry.values())
        for kind in (ContactLaw, FrictionLaw)
    ]
    for text in (README, (ROOT / "joss" / "paper.md").read_text(encoding="utf-8")):
        assert re.findall(r"(\d+) contact laws and (\d+) friction laws", text) == [
            tuple(str(count) for count in built_in)
        ]


def test_links_of_the_readme_lead_to_files() -> None:
    links = re.findall(r"\]\(([^)#]+)(?:#[\w-]+)?\)", README)
    assert len(links) > 15
    assert [link for link in links if not link.startswith("http") and not (ROOT / link).exists()] == []


def test_pictures_of_the_readme_are_described_and_small() -> None:
    pictures = re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", README)
    assert len(pictures) == 2
    for words, path in pictures:
        assert len(words) > 60
        assert 10_000 < (ROOT / path).stat().st_size < LARGEST


def test_the_readme_cites_this_version() -> None:
    import vfife

    assert f"version = {{{vfife.__version__}}}" in README
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {vfife.__version__}" in citation
    (doi,) = re.findall(r"doi\s+= \{([^}]+)\}", README)
    assert doi in citation
