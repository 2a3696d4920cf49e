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
    assert "not an equilibrium" not in found.stdout and ": 1 natural vibration\n" in found.stdout
    value = json.loads(told(tmp_path, -90.0, "--json").stdout)
    assert math.isclose(value["modes"][0]["angular_frequency_squared"], 1.5 * 9.81, rel_tol=1e-9)


def test_what_is_unstable_and_what_is_no_equilibrium_is_told(tmp_path) -> None:
    assert "unstable, e-fold in 0.261 s" in told(tmp_path, 90.0).stdout
    assert "The start is not an equilibrium" in told(tmp_path, 0.0).stdout


CANTILEVER = """
name = "cantilever"
[ground]
O = [0, 0]
[body.beam]
length = "1 m"
model = "elastic"
section = { rectangle = ["20 mm", "10 mm"] }
MODEL
[joint.clamp]
kind = "weld"
bearing = "ground.O"
journal = "beam.start"
[run]
duration = "10 ms"
"""


def cantilever(tmp_path, model: str = "", *options: str):
    path = tmp_path / "cantilever.toml"
    path.write_text(CANTILEVER.replace("MODEL", model), encoding="utf-8")
    return CliRunner().invoke(app, ["modes", str(path), *options])


def test_frequencies_have_ranges_and_the_digits_that_are_known(tmp_path) -> None:
    """With the default elements; the closed form of the third is 146.03 Hz, of the pinned one 210.2 Hz."""
    text = " ".join(cantilever(tmp_path).stdout.split())
    assert "8.09 Hz 8.08 to 8.34 Hz" in text and "126 Hz 125 to 149 Hz" in text and "125.9" not in text
    assert "197 Hz (196 to 213)" in text
    assert "4 more vibrations below 8,343 Hz, which these elements cannot represent" in text
    value = json.loads(cantilever(tmp_path, "", "--json").stdout)
    low, high = (value["modes"][2]["range"][end] for end in ("low", "high"))
    assert low <= value["modes"][2]["frequency"] <= 146.03 <= high
    assert value["modes"][9]["range"] is None and value["missing"] == 4
    assert value["link_ranges"]["beam"][2]["high"] > 210.2


def test_a_link_of_one_element_has_no_range(tmp_path) -> None:
    path = tmp_path / "cantilever.toml"
    text = CANTILEVER.replace('"elastic"', '"two-particle"').replace("MODEL", "")
    path.write_text(text.replace('"weld"', '"ideal"'), encoding="utf-8")
    found = CliRunner().invoke(app, ["modes", str(path), "-n", "2", "--json"])
    assert found.exit_code == 0, found.stderr
    modes = json.loads(found.stdout)["modes"]
    assert all(mode["range"] is None for mode in modes if mode["frequency"])
    assert any(mode["frequency"] for mode in modes)
    assert "not estimated" in CliRunner().invoke(app, ["modes", str(path), "-n", "2"]).stdout
