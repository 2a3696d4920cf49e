"""Builds the wheel and the sdist into dist/, and tries the wheel where nothing of this checkout is:
installed, new, check, run, plot, export.
"""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
# What must be in them, beside the code.
IN_WHEEL = (
    "vfife/py.typed",
    "vfife/modelfile/model.schema.json",
    "vfife/modelfile/templates/",
    "vfife/examples/four_bar.toml",
    "LICENSE",
)
IN_SDIST = (
    "pyproject.toml",
    "README.md",
    "CHANGELOG.md",
    "LICENSE",
    "Makefile",
    ".ci/run",
    "tests/conftest.py",
    "examples/four_bar.toml",
)
EXPORTS = ("out.csv", "out.nc", "out.mat", "out.parquet", "forces.svg")
OURS = ("PYTHON", "VFIFE", "XDG", "VIRTUAL_ENV", "MPL")  # variables that would lead back here
TRIED = """
import pathlib, sys, pyarrow.parquet, vfife
assert pathlib.Path(vfife.__file__).is_relative_to(sys.prefix), vfife.__file__
result = vfife.load_result("run")
assert result.record.status == "complete"
table = pyarrow.parquet.read_table("out.parquet")
assert table["rod.angle"].to_numpy().tobytes() == result.series["rod.angle"].values.tobytes()
assert table.schema.field("rod.angle").metadata[b"units"] == b"rad"
m = vfife.load("my.toml", {"run.turns": 1})
assert m.check().after_drives == 0
assert [getattr(vfife.gallery, name)().check() for name in vfife.gallery.__all__]
assert len(m._repr_html_()) > 10_000 and len(result.to_dataframe()) == len(result.time)
"""


def main() -> None:
    """Build the packages, inspect their contents, install them and run them."""
    began = time.monotonic()
    version = re.search(
        r'__version__ = "(.+)"', (ROOT / "src/vfife/__init__.py").read_text(encoding="utf-8")
    )[1]
    shutil.rmtree(DIST, ignore_errors=True)
    run([sys.executable, "-m", "hatchling", "build", "-d", str(DIST)], ROOT)
    (sdist,), (wheel,) = DIST.glob("*.tar.gz"), DIST.glob("*.whl")
    assert version in sdist.name and version in wheel.name, (sdist.name, wheel.name)
    run([sys.executable, "-m", "twine", "check", "--strict", str(sdist), str(wheel)], ROOT)
    with tempfile.TemporaryDirectory() as folder:
        look_inside(sdist, wheel, Path(folder))
        told(
            f"{wheel.name} ({wheel.stat().st_size:,} bytes) and {sdist.name} ({sdist.stat().st_size:,} "
            f"bytes)",
            began,
        )
        for python in (sys.executable, *newest_python()):
            try_out(wheel, Path(folder) / Path(python).name, version, began, python)
    told("The wheel works where nothing else of this checkout is", began)


def look_inside(sdist: Path, wheel: Path, folder: Path) -> None:
    """Everything that belongs there is; what the sdist builds is the same wheel."""
    with zipfile.ZipFile(wheel) as archive:
        names = sorted(archive.namelist())
    files = [path for path in (ROOT / "src").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    packed = {path.relative_to(ROOT / "src").as_posix() for path in files}
    assert packed <= set(names), f"the wheel lacks {sorted(packed - set(names))}"
    for wanted in IN_WHEEL:
        assert any(wanted in name for name in names), f"the wheel lacks {wanted}"
    assert not [name for name in names if name.startswith("tests")]
    examples = {path.name for path in (ROOT / "examples").glob("*.toml")}
    assert {name.rpartition("/")[2] for name in names if name.startswith("vfife/examples/")} == examples, (
        "the gallery in the wheel is not examples/*.toml"
    )
    with tarfile.open(sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
        archive.extractall(
            folder / "sdist", **({"filter": "data"} if hasattr(tarfile, "data_filter") else {})
        )
    assert set(IN_SDIST) <= inside, f"the sdist lacks {sorted(set(IN_SDIST) - inside)}"
    (unpacked,) = (folder / "sdist").iterdir()
    run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder / "again")], unpacked)
    with zipfile.ZipFile(next((folder / "again").glob("*.whl"))) as archive:
        assert sorted(archive.namelist()) == names, "the sdist builds another wheel"


def newest_python() -> list[str]:
    """Return the newest other Python on this machine that the package supports, or nothing."""
    for name in ("python3.14", "python3.13", "python3.12"):
        found = shutil.which(name)
        test = f"import sys, venv; sys.exit(sys.version_info[:2] == {sys.version_info[:2]!r})"
        if found and subprocess.run([found, "-c", test], capture_output=True).returncode == 0:
            return [found]
    return []


def try_out(wheel: Path, folder: Path, version: str, began: float, base: str) -> None:
    """Try what a new user types, in a bare environment of the Python ``base`` outside the checkout."""
    bare, work = folder / "bare", folder / "work"
    work.mkdir(parents=True)
    run([base, "-m", "venv", "--without-pip", str(bare)], work)
    bin_ = bare / ("Scripts" if os.name == "nt" else "bin")
    python, vfife = str(bin_ / "python"), str(bin_ / "vfife")
    run(
        [
            sys.executable,
            "-m",
            "pip",
            "--python",
            python,
            "install",
            "-qq",
            "--no-compile",
            f"{wheel}[parquet]",
        ],
        work,
    )
    told(f"Installed with its dependencies for {run([python, '--version'], work).strip()}", began)
    assert run([vfife, "--version"], work).split() == ["vfife", version]
    run([vfife, "new", "slider-crank", "-o", "my.toml"], work)
    run([vfife, "check", "my.toml"], work)
    run([vfife, "new", "squeezer", "-o", "squeezer.toml"], work)
    run([vfife, "run", "my.toml", "-o", "run"], work)
    for command in (["plot", "run"], ["info", "run"], *(["export", "run", name] for name in EXPORTS)):
        run([vfife, *command], work)
    assert (work / "run/figures/mechanism.png").stat().st_size > 5000
    assert all((work / name).stat().st_size > 5000 for name in EXPORTS)
    run([python, "-W", "error", "-c", TRIED], work)


def run(words: list[str], where: Path) -> str:
    """Run a command in a folder, without our environment variables, and return its output. Exit with the
    output of a command that fails.
    """
    clean = {name: value for name, value in os.environ.items() if not name.startswith(OURS)}
    clean |= {
        "VFIFE_CACHE": str(Path(tempfile.gettempdir()) / "vfife-package-cache"),
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    }
    done = subprocess.run(words, cwd=where, env=clean, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(words)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def told(what: str, began: float) -> None:
    """Print a line of progress."""
    print(f"{what} ({time.monotonic() - began:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
