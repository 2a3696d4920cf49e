"""One virtual environment for each program of others, under .peers, filled from the package index when
missing.
"""

from __future__ import annotations

import glob
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from measure import HERE

FOLDER = HERE / ".peers"
SCRIPTS = HERE / "peers"
REQUIREMENTS = {
    "exudyn": ["exudyn"],
    "mujoco": ["mujoco", "numba"],
    "scipy": ["numpy", "scipy", "numba"],
    "openseespy": ["openseespy"],
    "pyelastica": ["pyelastica"],
}
# OpenSees is linked against these and its wheel does not bring them.
DEBIAN = ["libblas3", "liblapack3", "libgfortran5", "libquadmath0"]
PYTHONS = (sys.executable, "python3", "python3.13", "python3.12", "python3.11")


class Missing(RuntimeError):
    """A program of others cannot be had here."""


def environment(name: str) -> Path:
    """Interpreter that has a peer, installed at the first call; raises Missing with the reason where that
    fails.
    """
    python = FOLDER / name / "bin" / "python"
    stamp = FOLDER / name / ".complete"
    if stamp.exists():
        return python
    quiet = {"check": True, "capture_output": True, "text": True, "timeout": 600}
    pip = [str(python), "-m", "pip", "install", "-qq", "--disable-pip-version-check"]
    problem: Any = None
    for base in [base for base in PYTHONS if shutil.which(base)]:
        try:
            subprocess.run([base, "-m", "venv", "--clear", str(FOLDER / name)], **quiet)
            subprocess.run([*pip, *REQUIREMENTS[name]], **quiet)
        except (OSError, subprocess.SubprocessError) as error:
            text = getattr(error, "stderr", None) or str(error)
            problem = text.strip().splitlines()[-1] if text.strip() else repr(error)
            continue
        stamp.write_text(" ".join(REQUIREMENTS[name]) + "\n")
        return python
    raise Missing(f"{name} cannot be installed: {problem}")


def debian_libraries() -> list[str]:
    """Folders of the libraries that OpenSees wants, unpacked beside it; nothing of the system is changed."""
    root = FOLDER / "openseespy" / "debian"
    if not root.exists() and shutil.which("apt-get") and shutil.which("dpkg-deb"):
        work = FOLDER / "openseespy" / "packages"
        work.mkdir(parents=True, exist_ok=True)
        subprocess.run(["apt-get", "download", *DEBIAN], cwd=work, capture_output=True, check=False)
        for package in work.glob("*.deb"):
            subprocess.run(["dpkg-deb", "-x", str(package), str(root)], capture_output=True, check=False)
    return sorted({str(Path(path).parent) for path in glob.glob(f"{root}/**/lib*.so*", recursive=True)})


def run(name: str, script: str, *arguments: str, timeout: float = 300.0) -> dict[str, Any]:
    """The JSON line that a peer's script prints; one core."""
    python = environment(name)
    variables = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
    variables.pop("PYTHONPATH", None)
    if name == "openseespy":
        variables["LD_LIBRARY_PATH"] = ":".join([*debian_libraries(), os.environ.get("LD_LIBRARY_PATH", "")])
    command = [str(python), script, *arguments]
    said_to: dict[str, Any] = {"cwd": SCRIPTS, "env": variables, "capture_output": True, "text": True}
    try:
        done = subprocess.run(command, timeout=timeout, check=False, **said_to)
    except subprocess.TimeoutExpired as error:
        raise Missing(f"{script} {' '.join(arguments)} took more than {timeout:.0f} s") from error
    for line in reversed(done.stdout.splitlines()):
        if line.startswith("{"):
            result: dict[str, Any] = json.loads(line)
            return result
    said = (done.stderr.strip() or done.stdout.strip() or "nothing").splitlines()[-1]
    hint = f" (it needs Debian's {', '.join(DEBIAN[:2])})" if name == "openseespy" else ""
    raise Missing(f"{script} gave no result; it said: {said}{hint}")
