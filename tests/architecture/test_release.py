"""What is released says its version once, and dates it."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

import vfife
from architecture.sources import PROJECT, ROOT


def script(name: str) -> ModuleType:
    """A script of .ci."""
    spec = importlib.util.spec_from_file_location(name, ROOT / ".ci" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def copied(folder: Path) -> Path:
    """The files that a release changes, elsewhere."""
    for name in ("src/vfife/__init__.py", "CITATION.cff", "CHANGELOG.md", "README.md", "conda/recipe.yaml"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text((ROOT / name).read_text(encoding="utf-8"), encoding="utf-8")
    changelog = folder / "CHANGELOG.md"
    changelog.write_text(
        changelog.read_text(encoding="utf-8").replace(
            "## Unreleased\n", "## Unreleased\n\n- Something.\n", 1
        ),
        encoding="utf-8",
    )
    return folder


def test_one_version_everywhere() -> None:
    assert PROJECT["project"]["dynamic"] == ["version"] and "version" not in PROJECT["project"]
    assert (
        re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)[1]
        == vfife.__version__
    )  # type: ignore[index]


def test_versions_in_the_changelog_are_dated_and_descend() -> None:
    heads = re.findall(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert heads[0] == "Unreleased"
    released = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) - \d{4}-\d\d-\d\d", head) for head in heads[1:]]
    assert all(released), heads
    versions = [tuple(map(int, one.groups())) for one in released if one is not None]
    assert versions == sorted(versions, reverse=True)


def test_a_release_puts_version_and_date_where_they_stand(tmp_path: Path) -> None:
    root = copied(tmp_path)
    script("release").released("7.0.0", "2031-02-03", root)
    assert '__version__ = "7.0.0"' in (root / "src/vfife/__init__.py").read_text(encoding="utf-8")
    assert "version: 7.0.0\ndate-released: 2031-02-03\n" in (root / "CITATION.cff").read_text(
        encoding="utf-8"
    )
    readme = (root / "README.md").read_text(encoding="utf-8")
    assert "  version = {7.0.0},\n  year    = {2031}\n" in readme and "year    = {2016}" in readme
    assert '  version: "7.0.0"' in (root / "conda/recipe.yaml").read_text(encoding="utf-8")
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(r"^## Unreleased\n\n## 7\.0\.0 - 2031-02-03\n\n- Something\.", text, re.M)
    with pytest.raises(SystemExit, match="nothing under Unreleased"):
        script("release").released("7.0.1", "2031-02-03", root)


@pytest.mark.parametrize(
    ("version", "said"), [("", "three numbers"), ("1.2", "three numbers"), ("0.0.1", "older than")]
)
def test_what_is_no_version_changes_nothing(version: str, said: str, tmp_path: Path) -> None:
    root = copied(tmp_path)
    before = {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
    with pytest.raises(SystemExit, match=said):
        script("release").released(version, "2031-02-03", root)
    assert before == {path: path.read_bytes() for path in root.rglob("*") if path.is_file()}
