"""Files and folders that the documents for developers name exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATH = re.compile(r"`((?:[\w.-]+/)+[\w*.-]*|[a-z_]+\.py)`")
ELSEWHERE = {"my_laws.py", "runs/", "model.schema.json"}  # of a reader


def exists(path: str) -> bool:
    """Whether a path is that of a file below the root, the package or the tests, or the end of one."""
    if "/" in path and "*" not in path:
        return any(
            (base / path).exists() for base in (ROOT, ROOT / "src", ROOT / "src/vfife", ROOT / "tests")
        )
    return any(
        True for base in ("src", "tests", "examples") for _ in (ROOT / base).rglob(path.rpartition("/")[2])
    )


@pytest.mark.parametrize("name", ["docs/design.md", "docs/internals.md", "CONTRIBUTING.md", "docs/faults.md"])
def test_paths_in_a_document_exist(name: str) -> None:
    text = (ROOT / name).read_text("utf-8")
    paths = sorted({match[1] for match in PATH.finditer(text)})
    assert len(paths) > 5
    missing = [path for path in paths if path not in ELSEWHERE and not exists(path)]
    assert not missing, missing
