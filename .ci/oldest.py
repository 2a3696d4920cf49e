"""Prints the oldest versions that pyproject.toml allows of what the package runs on and of its extras, as
constraints for pip.
"""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8"))[
    "project"
]
TOOLS = ("test", "dev")  # extras of those who work on the package

extras = [
    one for extra, every in PROJECT["optional-dependencies"].items() if extra not in TOOLS for one in every
]
for requirement in PROJECT["dependencies"] + extras:
    name, _, oldest = requirement.partition(">=")
    if not oldest:
        raise SystemExit(
            f"{requirement}: a dependency is written name>=version, so that its oldest version can be tried"
        )
    print(f"{name}=={oldest}")
