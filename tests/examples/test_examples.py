"""Every script of examples/ says its number, and the code of the README runs. The model files are in
test_gallery.py.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_every_script_says_its_number() -> None:
    """`make docs` runs them, and fails where a number does not hold."""
    scripts = sorted((ROOT / "examples").glob("*.py"))
    assert len(scripts) > 5 and all("assert" in script.read_text() for script in scripts)


def test_readme_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {"__name__": "__main__"})
    assert (tmp_path / "orbits.png").stat().st_size > 10_000


def test_code_of_the_designers_page_runs() -> None:
    blocks = re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "designer.md").read_text(encoding="utf-8"), re.S
    )
    assert blocks
    for block in blocks:
        exec(compile(block, "designer.md", "exec"), {"__name__": "__main__"})


@pytest.mark.system("runs the demo")
def test_demo_json_is_one_object(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "vfife",
        "run",
        str(ROOT / "examples/four_bar_case_c.toml"),
        "-o",
        str(tmp_path / "run"),
        "--json",
    ]
    done = subprocess.run([*command, "--step", "1e-6"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["status"] == "complete"
    assert said["step"] == 1e-6
    assert (said["measures"]["B.impacts"], said["measures"]["C.impacts"], said["measures"]["D.impacts"]) == (
        4,
        7,
        5,
    )
    assert said["measures"]["C.force.max"] == pytest.approx(68842.16, rel=0.01)
    assert said["energy_error"] < 1e-4
