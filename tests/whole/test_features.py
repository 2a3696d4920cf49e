"""Every feature of the package, used once from outside: the commands of features.toml in one folder, and a
user's script.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import vfife

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
GROUPS = tomllib.loads((Path(__file__).parent / "features.toml").read_text())["group"]
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


def record(path: Path) -> None:
    """Write a curve of case b as measured data."""
    result = vfife.simulate(
        vfife.load(EXAMPLES / "four_bar_case_b.toml"), turns=1, outputs=400, companions=0, reference=False
    )
    curve = result.data["body_angular_acceleration"].sel(body="follower")
    rows = zip(curve["time"].values[100:], curve.values[100:], strict=True)
    path.write_text(
        "time (s),follower.angular_acceleration (rad/s^2)\n"
        + "".join(f"{time:.9f},{value:.6f}\n" for time, value in rows)
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands read."""
    folder = tmp_path_factory.mktemp("features")
    (folder / "st.toml").write_text(MODEL + GRID)
    (folder / "fits.toml").write_text(MODEL.replace(', "crank.power.mean"', "") + FITS)
    record(folder / "data.csv")
    return folder


def command(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    words = shlex.split(line.replace("EX/", f"{EXAMPLES}/"))
    return subprocess.run(
        [sys.executable, "-m", "vfife", *words], cwd=folder, capture_output=True, text=True, timeout=300
    )


@pytest.mark.system("starts a process for each of ninety commands")
def test_every_command_does_its_work(folder, subtests):
    """In one item, because most commands read what others have written."""
    for group in GROUPS:
        for line in group["commands"]:
            with subtests.test(line):
                done = command(line, folder)
                assert done.returncode == group.get("exit", 0), done.stderr[-500:]
                assert "Traceback" not in done.stdout + done.stderr
    for run, (joint, force, share) in FORCES.items():
        with subtests.test(f"force of {run}"):
            measures = json.loads((folder / run / "summary.json").read_text())["measures"]
            found = measures[f"{joint}.force.max"]
            assert (found["value"] if isinstance(found, dict) else found) == pytest.approx(force, rel=share)
    assert list(folder.glob("b/**/forces.png")) and (folder / "fitted.toml").exists()


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
