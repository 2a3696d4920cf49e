"""Make a release: write the version into the package, CITATION.cff and the README, and date the entries that
the changelog has under Unreleased.

`make release VERSION=0.2.0`; then look at the difference, commit, and tag it.
"""

import re
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def released(version: str, today: str, root: Path = ROOT) -> None:
    """Write version and date into all files, or into none if one of them does not fit."""
    if not re.fullmatch(r"\d+\.\d+\.\d+", version):
        raise SystemExit(f'"{version}" is no version: give three numbers, as in make release VERSION=0.2.0')
    package, citation, changelog = (
        root / "src/vfife/__init__.py",
        root / "CITATION.cff",
        root / "CHANGELOG.md",
    )
    readme, recipe = root / "README.md", root / "conda/recipe.yaml"
    paths = (package, citation, changelog, readme, recipe)
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    former = re.search(r'^__version__ = "(.+)"$', texts[package], re.M)[1]
    if tuple(map(int, version.split("."))) < tuple(map(int, former.split("."))):
        raise SystemExit(f"{version} is older than {former}, which is there")
    unreleased = re.search(r"^## Unreleased\n+(.*?)(?=^## |\Z)", texts[changelog], re.M | re.S)
    if f"\n## {version} - " in texts[changelog] or unreleased is None or not unreleased[1].strip():
        raise SystemExit(f"CHANGELOG.md has {version} already, or nothing under Unreleased")
    texts[package] = re.sub(r'^__version__ = ".+"$', f'__version__ = "{version}"', texts[package], flags=re.M)
    texts[citation] = re.sub(r"^date-released: .*\n", "", texts[citation], flags=re.M)
    texts[citation] = re.sub(
        r"^version: .+$", f"version: {version}\ndate-released: {today}", texts[citation], flags=re.M
    )
    texts[readme] = re.sub(r"(?m)^(  version = )\{.+\}", rf"\g<1>{{{version}}}", texts[readme])
    texts[readme] = re.sub(
        r"(?m)^(  year    = )\{.+\}(\n\})", rf"\g<1>{{{today[:4]}}}\g<2>", texts[readme], count=1
    )
    texts[recipe] = re.sub(r'(?m)^  version: ".+"$', f'  version: "{version}"', texts[recipe])
    texts[changelog] = texts[changelog].replace(
        "## Unreleased\n", f"## Unreleased\n\n## {version} - {today}\n", 1
    )
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
    print(f"{version} of {today}; look at git diff, commit, and tag it v{version}")


if __name__ == "__main__":
    released(sys.argv[1] if len(sys.argv) > 1 else "", date.today().isoformat())
