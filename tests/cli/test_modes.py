"""``vfife modes``."""

import json
import math

from typer.testing import CliRunner

from vfife.cli.app import app

PENDULUM = """
name = "pendulum"
gravity = [0, "-9.81 m/s^2"]
[ground]
O = [0, 0]
[body.rod]
length = "1 m"
mass = "2 kg"
angle = "ANGLE deg"
[joint.a]
bearing = "ground.O"
journal = "rod.start"
[run]
duration = "1 s"
"""


def told(tmp_path, angle: float, *options: str):
    path = tmp_path / "pendulum.toml"
    path.write_text(PENDULUM.replace("ANGLE", str(angle)), encoding="utf-8")
    return CliRunner().invoke(app, ["modes", str(path), *options])


def test_a_pendulum(tmp_path) -> None:
    found = told(tmp_path, -90.0)
    assert (
        found.exit_code == 0 and "0.61052 Hz" in found.stdout and "rod, 100 % of the energy" in found.stdout
    )
    assert "no equilibrium" not in found.stdout and ": 1 natural vibration\n" in found.stdout
    value = json.loads(told(tmp_path, -90.0, "--json").stdout)
    assert math.isclose(value["modes"][0]["angular_frequency_squared"], 1.5 * 9.81, rel_tol=1e-9)


def test_what_is_unstable_and_what_is_no_equilibrium_is_told(tmp_path) -> None:
    assert "unstable, e-fold in 0.261 s" in told(tmp_path, 90.0).stdout
    assert "The start is no equilibrium" in told(tmp_path, 0.0).stdout
