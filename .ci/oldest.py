"""Prints the oldest versions that pyproject.toml allows of what the package runs on, as constraints for pip."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]

for requirement in PROJECT["dependencies"]:
    name, _, oldest = requirement.partition(">=")
    if not oldest:
        raise SystemExit(f"{requirement}: a dependency is written name>=version, so that its oldest version can be tried")
    print(f"{name}=={oldest}")
