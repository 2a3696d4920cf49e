"""Every feature of the package, used once from outside: commands of features.toml, and a script of a user."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

import vfife
from vfife.cli.app import app

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
SETS = tomllib.loads((Path(__file__).parent / "features.toml").read_text())
MODEL = (
    f'model = "{EXAMPLES}/four_bar_case_b.toml"\nmeasures = ["C.force.max", "crank.power.mean"]\nturns = 1\n'
)
GRID = """
[vary.clearance]
path = "joint.C.clearance"
from = "0.1 mm"
to = "0.3 mm"
count = 4
[vary.speed]
path = "driver.crank.speed"
values = ["600 rpm", "900 rpm"]
"""
FITS = """method = "sobol"
count = 32
[vary.clearance]
path = "joint.C.clearance"
fit = "H9/e8"
diameter = "20 mm"
[limit]
"C.force.max" = "80 kN"
"""
# Forces (N) of runs of the paper's four-bar, and within which share of them.
FORCES = {"ideal": ("B", 39425.3, 1e-3), "b": ("C", 65794.78, 5e-3), "c": ("C", 68842.16, 1e-2)}
# What commands of a set write, beside what those after them read.
FILES = {"runs": ("b/**/forces.png", "forces.pdf"), "identification": ("fitted.toml",)}


def record(path: Path) -> None:
    """Write a curve of the ideal four-bar as measured data: few runs fit it."""
    result = vfife.simulate(
        vfife.load(EXAMPLES / "four_bar_ideal.toml"), turns=1, outputs=400, companions=0, reference=False
    )
    curve = result.data["body_angular_acceleration"].sel(body="follower")
    rows = zip(curve["time"].values[100:], curve.values[100:], strict=True)
    path.write_text(
        "time (s),follower.angular_acceleration (rad/s^2)\n"
        + "".join(f"{time:.9f},{value:.6f}\n" for time, value in rows)
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with what the commands read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "st.toml").write_text(MODEL + GRID)
    (tmp_path / "fits.toml").write_text(MODEL.replace(', "crank.power.mean"', "") + FITS)
    return tmp_path


def split(line: str) -> list[str]:
    """Return the words of a command."""
    return shlex.split(line.replace("EX/", f"{EXAMPLES}/"))


def command(line: str, alone: bool) -> tuple[int, str]:
    """Carry out a command, in a process of its own where ``alone`` is set, and return its exit code and all
    that it printed.
    """
    if not alone:
        done = CliRunner().invoke(app, split(line))
        assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)
        return done.exit_code, done.output
    words = [sys.executable, "-m", "vfife", *split(line)]
    process = subprocess.run(words, capture_output=True, text=True, timeout=300)
    return process.returncode, process.stdout + process.stderr


@pytest.mark.system("carries out ninety commands, those that come first in processes of their own")
@pytest.mark.parametrize("name", SETS)
def test_every_command_does_its_work(name, folder, subtests):
    """The commands of a set in one item, because most read what others have written. The first line of each
    command has a process of its own, which loads what that command needs and nothing else.
    """
    if name == "identification":
        record(folder / "data.csv")
    known: set[str] = set()
    for group in SETS[name]:
        for line in group["commands"]:
            with subtests.test(line):
                kind = line.split()[0]
                code, printed = command(line, alone=kind not in known)
                known.add(kind)
                assert code == group.get("exit", 0), printed[-500:]
                assert "Traceback" not in printed
    for file in FILES.get(name, ()):
        with subtests.test(file):
            assert list(folder.glob(file))
    for run, (joint, force, share) in FORCES.items() if name == "runs" else ():
        with subtests.test(f"force of {run}"):
            measures = json.loads((folder / run / "summary.json").read_text())["measures"]
            found = measures[f"{joint}.force.max"]
            assert (found["value"] if isinstance(found, dict) else found) == pytest.approx(force, rel=share)


@pytest.mark.system("runs a mechanism in every way of the Python front end")
def test_the_python_front_end_does_its_work(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    m = vfife.Mechanism("four-bar with a loose pin")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.150, 0.0)
    m.link("crank", length="400 mm", mass="3.12 kg")
    m.link("coupler", length=0.260, mass=2.028, angle="51 deg")
    m.link("follower", length=0.460, mass=3.588, angle="26 deg")
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.clearance_joint("C", "coupler.end", "follower.end", clearance="0.2 mm", bearing_radius="10 mm")
    m.revolute("D", "ground.D", "follower.start")
    m.drive("crank", speed="1500 rpm")
    m.check()
    assert "coupler" in m.to_toml() and m._repr_html_()
    result = vfife.simulate(m, turns=3)
    force = result.measures["C.force.max"]
    assert force.low <= force.value <= force.high
    assert "joint_force" in result.data and len(result.to_dataframe("C")) > 10
    result.plot("orbits")
    result.export("r.csv")
    assert Path("r.csv").stat().st_size > 1000
    simulation = vfife.Simulation(m)
    simulation.advance(1e-3)
    study = vfife.study(
        m, vary={"joint.C.clearance": ["0.1 mm", "0.2 mm"]}, measures=["C.force.max"], turns=1
    )
    assert len(study.cases) == 2
    for name in vfife.gallery.__all__:
        assert getattr(vfife.gallery, name)().bodies
    with pytest.raises(ValueError, match="apples"):
        m.link("x", length="5 apples", mass=1.0)
