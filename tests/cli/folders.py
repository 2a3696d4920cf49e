"""What lies in a folder."""

from __future__ import annotations

from pathlib import Path


def contents(where: Path) -> dict[str, bytes]:
    """Every file below a folder, and its bytes."""
    return {
        str(path.relative_to(where)): path.read_bytes() for path in sorted(where.rglob("*")) if path.is_file()
    }


def stages() -> list[Path]:
    """What only lies in the working folder while a command is at work."""
    return [path for path in Path().rglob("*") if ".new-" in path.name or path.name in ("run.lock",)]
