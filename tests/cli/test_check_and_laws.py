"""`vfife check` tells what would run without running it; `vfife laws` tells every law."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import vfife
from cli.models import CASE_C, ROOT


def test_check_says_what_would_run(command: Callable) -> None:
    said = json.loads(command("check", CASE_C, "--json").stdout)
    crank, coupler, follower = said["bodies"]
    assert [body["name"] for body in said["bodies"]] == ["crank", "coupler", "follower"]
    assert follower["mass"] == pytest.approx(3.588)
    assert coupler["inertia"] == pytest.approx(2.028 * 0.26**2 / 12.0)
    assert crank["driver"].startswith("constant speed 157.08")
    joint = next(joint for joint in said["joints"] if joint["name"] == "C")
    assert joint["expected_force"] == pytest.approx(65337.5, rel=1e-3)
    assert float(joint["contact"]["derived"]["stiffness"]) == 6.6e10
    assert (said["degrees_of_freedom"]["free"], said["degrees_of_freedom"]["after_drives"]) == (1, 0)
    assert said["steps"] * said["step"]["size"] == pytest.approx(0.08)
    assert set(said["step"]["limits"]) == {f"contact of joint {name}" for name in "BCD"}
    assert min(said["step"]["limits"].values()) == said["step"]["stable"] > said["step"]["size"]


def test_check_and_run_agree(command: Callable, case_c_run: Path) -> None:
    """The step told beforehand is the step taken, the record as large as told, and nothing of the run is computed."""
    said = json.loads(command("check", CASE_C, "--set", "run.turns=1", "--json").stdout)
    assert not Path("runs").exists()
    result = vfife.Result.load(case_c_run)
    assert said["step"]["size"] == result.record.assembly.choice.step
    assert said["steps"] == result.record.steps[-1]
    assert said["estimate"]["bytes"] == result.record.rows.nbytes


def test_check_says_which_defaults_it_filled_in(command: Callable, pendulum: Path) -> None:
    found = {entry["path"]: entry for entry in json.loads(command("check", pendulum, "--json").stdout)["defaults"]}
    assert found["run.step"]["value"] == "auto"
    assert found["body.rod.start_mass"] == found["body.rod.start_mass"] | {"value": 0.0, "unit": "kg"}
    assert not {"run.duration", "body.rod.length", "body.rod.elements", "gravity"} & set(found)
    again = json.loads(command("check", pendulum, "--set", "body.rod.start_mass=1", "--json").stdout)["defaults"]
    assert "body.rod.start_mass" not in {entry["path"] for entry in again}


def test_check_names_the_law_that_a_joint_leaves_out(command: Callable, pendulum: Path) -> None:
    given = ["--set", "joint.J.kind=clearance", "--set", "joint.J.clearance=0.1 mm", "--set", "joint.J.bearing_radius=1 cm"]
    found = {entry["path"]: entry for entry in json.loads(command("check", pendulum, *given, "--json").stdout)["defaults"]}
    assert found["joint.J.contact.law"]["value"] == "lankarani-nikravesh"
    assert found["joint.J.friction.v1"] == found["joint.J.friction.v1"] | {"value": 0.01, "unit": "m/s"}


@pytest.mark.parametrize("name", [path.stem for path in sorted((ROOT / "examples").glob("*.toml"))])
def test_check_speaks_of_every_example(command: Callable, name: str) -> None:
    done = command("check", ROOT / "examples" / f"{name}.toml")
    assert done.exit_code == 0, done.stderr
    lasting = ("Static analysis",) if name in ("elastica_circle", "williams_toggle") else ("stable step", "an estimate")
    for word in ("mass, kg", "Degrees of freedom", *lasting, "taken by default"):
        assert word in done.stdout
    assert ("INFERRED" in done.stdout) == (name == "four_bar")


def test_laws_are_described(command: Callable) -> None:
    laws = json.loads(command("laws", "--json").stdout)
    assert {law["name"] for law in laws} >= {"lankarani-nikravesh", "pereira", "ambrosio", "none"}
    for law in laws:
        assert set(law) == {"name", "kind", "source", "formula", "parameters"}
        assert law["source"]
        assert law["formula"]
        for one in law["parameters"]:
            assert set(one) | {"default"} == {"name", "unit", "meaning", "default"}
            assert one["unit"]
            assert one["meaning"]


def test_one_law(command: Callable) -> None:
    (law,) = json.loads(command("laws", "--json", "ambrosio").stdout)
    assert law["kind"] == "friction"
    assert next(one for one in law["parameters"] if one["name"] == "v0")["default"] == 1e-4
    text = command("laws", "Ambrosio").stdout
    assert law["formula"] in text
    assert "pereira" not in text
