"""`vfife check` tells what would run without running it; `vfife laws` tells every law."""

import json
import math
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
    """The step told beforehand is the step taken, the record as large as told, and nothing of the run is
    computed.
    """
    said = json.loads(command("check", CASE_C, "--set", "run.turns=1", "--json").stdout)
    assert not Path("runs").exists()
    result = vfife.Result.load(case_c_run)
    assert said["step"]["size"] == result.record.assembly.choice.step
    assert said["steps"] == result.record.steps[-1]
    assert said["estimate"]["bytes"] == result.record.rows.nbytes


def test_check_takes_the_step_and_length_of_the_run_that_comes(command: Callable) -> None:
    """It is asked before the run whether a step divides a turn, and which step nearby does."""
    told = json.loads(command("check", CASE_C, "--step", "3.3 us", "--turns", "5", "--json").stdout)
    assert told["step"]["size"] == 3.3e-6 and told["turns"] == pytest.approx(5.0, rel=1e-3)
    (note,) = (note for note in told["notes"] if "does not divide a turn" in note)
    step = note.rpartition("Take a step of ")[2].partition(" s (")[0]
    again = json.loads(command("check", CASE_C, "--step", step, "--turns", "5", "--json").stdout)
    assert again["steps"] % 5 == 0 and not [note for note in again["notes"] if "divide a turn" in note]
    assert "run.step" not in {entry["path"] for entry in again["defaults"]}
    assert "1 µs" in command("check", CASE_C, "--step", "1 us", "--turns", "1").stdout.replace(
        "1e-06 s", "1 µs"
    )


def test_check_says_which_defaults_it_filled_in(command: Callable, pendulum: Path) -> None:
    found = {
        entry["path"]: entry for entry in json.loads(command("check", pendulum, "--json").stdout)["defaults"]
    }
    assert found["run.step"]["value"] == "auto"
    assert found["body.rod.start_mass"] == found["body.rod.start_mass"] | {"value": 0.0, "unit": "kg"}
    assert not {"run.duration", "body.rod.length", "body.rod.elements", "gravity"} & set(found)
    again = json.loads(command("check", pendulum, "--set", "body.rod.start_mass=1", "--json").stdout)[
        "defaults"
    ]
    assert "body.rod.start_mass" not in {entry["path"] for entry in again}


def test_check_names_joints_whose_length_is_the_default(command: Callable, tmp_path: Path) -> None:
    path = tmp_path / "machine.toml"
    command("new", "compressor", "-o", path)
    text = path.read_text()
    path.write_text("\n".join(line for line in text.splitlines() if line != 'axial_length = "22 mm"'))
    words = " ".join(command("check", path).stdout.split())
    assert "Among them is axial_length of big-end, 20 mm: pressure and wear depend on it." in words


def test_check_shows_loads_with_their_values(command: Callable, tmp_path: Path) -> None:
    """A moment over time and a gas over travel, with signs and units, on the screen and as data."""
    model = tmp_path / "loaded.toml"
    text = (ROOT / "examples" / "slider_crank.toml").read_text()
    model.write_text(
        f'{text}\n[load.brake]\nat = "crank.start"\nmoment = "10 N m"\ntimes = ["0 s", "50 ms", "100 ms"]\n'
        'factors = [0, -1, 0.5]\n[load.wind]\nat = "rod.end"\nforce = ["-3 N", 0]\n'
    )
    brake, wind = json.loads(command("check", model, "--json").stdout)["loads"]
    assert (brake["name"], brake["kind"], brake["acts_on"]) == ("brake", "force", "crank.start")
    assert brake["by"] == "time" and brake["components"] == [
        {"quantity": "moment", "unit": "N m", "lowest": -10.0, "highest": 5.0}
    ]
    assert wind["by"] is None and wind["components"] == [
        {"quantity": "force_x", "unit": "N", "lowest": -3.0, "highest": -3.0}
    ]
    shown = " ".join(command("check", model).stdout.split())
    assert "moment -10 to 5 N m" in shown and "force x -3 N" in shown
    (gas,) = json.loads(command("check", ROOT / "examples" / "compressor.toml", "--json").stdout)["loads"]
    (force,) = gas["components"]
    assert (gas["acts_on"], gas["by"], force["unit"]) == ("cylinder", "travel", "N")
    # gauge pressures of -0.063 and 7.387 bar on a bore of 65 mm, against the direction of the guide
    area = math.pi * 0.065**2 / 4.0
    assert force["lowest"] == pytest.approx(-7.387e5 * area, rel=1e-3) and force["highest"] > 0.0
    assert json.loads(command("check", CASE_C, "--json").stdout)["loads"] == []


def test_check_takes_length_and_step_as_run_does(command: Callable) -> None:
    options = ("--turns", "3", "--step", "1 us", "--companions", "0")
    said = json.loads(command("check", CASE_C, *options, "--json").stdout)
    same = ("--set", "run.turns=3", "--set", "run.step=1e-6", "--set", "run.companions=0")
    assert said | {"defaults": []} == json.loads(command("check", CASE_C, *same, "--json").stdout) | {
        "defaults": []
    }
    assert said["steps"] * said["step"]["size"] == pytest.approx(0.12) and not said["step"]["automatic"]
    assert not {"run.turns", "run.step", "run.companions"} & {one["path"] for one in said["defaults"]}
    refused = command("check", CASE_C, "--step", "1 ms")
    assert refused.exit_code == 2 and "too large" in refused.stderr
    forced = json.loads(command("check", CASE_C, "--step", "1 ms", "--force-step", "--json").stdout)
    assert forced["step"]["size"] > forced["step"]["stable"]


def test_check_derives_stiffness_modulus_and_exponent_with_units(command: Callable) -> None:
    """The demo, Pereira: K and n by Eq. 26-27 and E* by Eq. 28, worked out here; a bronze bearing gives its
    compliance to E*.
    """
    model = ROOT / "examples" / "four_bar.toml"
    joint = next(
        one for one in json.loads(command("check", model, "--json").stdout)["joints"] if one["name"] == "C"
    )
    contact, gap = joint["contact"], 1e3 * joint["clearance"]
    modulus = 207e9 / (2.0 * (1.0 - 0.3**2))
    n = (1.51 * math.log(1000.0 * gap) ** -0.151 if gap < 0.34954 else 0.0151 * gap + 1.151) * gap**-0.005
    assert contact["modulus"] == pytest.approx(modulus)
    assert contact["exponent"] == pytest.approx(n, rel=1e-9)
    stiffness = (0.965 * gap + 0.0965) * 1e3 * joint["axial_length"] * 1e-6 * modulus / gap * 1e3**n
    assert float(contact["derived"]["stiffness"]) == pytest.approx(stiffness, rel=1e-5)
    assert contact["units"] == {"stiffness": f"N/m^{n:.4g}", "exponent_beyond_1": "1", "damping_factor": "1"}
    text = " ".join(command("check", model, "--set", "joint.C.bearing_material=bronze").stdout.split())
    assert f"composite modulus E* {1e-9 / ((1 - 0.3**2) / 207e9 + (1 - 0.341**2) / 110e9):.4g} GPa" in text


def test_the_template_has_its_rebound_among_the_laws(command: Callable) -> None:
    """Its restitution is no caution, because no answer of a check needs another one; laws come last, after
    step and cost.
    """
    model = ROOT / "examples" / "compressor.toml"
    said = json.loads(command("check", model, "--json").stdout)
    (fact,) = said["law_facts"]
    assert "restitution 0.5 a free impact rebounds with 0.7252" in fact
    assert not [note for note in said["notes"] if "rebound" in note]
    text = " ".join(command("check", model).stdout.split())
    assert text.index("Time, an estimate") < text.index("composite modulus") < text.index(fact)


def test_materials_are_listed(command: Callable) -> None:
    found = {one["name"]: one for one in json.loads(command("materials", "--json").stdout)}
    assert found["steel"]["youngs_modulus"] == 207e9 and all(one["source"] for one in found.values())
    assert "bronze" in command("materials").stdout


def test_check_names_the_law_that_a_joint_leaves_out(command: Callable, pendulum: Path) -> None:
    given = [
        "--set",
        "joint.J.kind=clearance",
        "--set",
        "joint.J.clearance=0.1 mm",
        "--set",
        "joint.J.bearing_radius=1 cm",
    ]
    found = {
        entry["path"]: entry
        for entry in json.loads(command("check", pendulum, *given, "--json").stdout)["defaults"]
    }
    assert found["joint.J.contact.law"]["value"] == "lankarani-nikravesh"
    assert found["joint.J.friction.v1"] == found["joint.J.friction.v1"] | {"value": 0.01, "unit": "m/s"}


@pytest.mark.parametrize("name", [path.stem for path in sorted((ROOT / "examples").glob("*.toml"))])
def test_check_speaks_of_every_example(command: Callable, name: str) -> None:
    done = command("check", ROOT / "examples" / f"{name}.toml")
    assert done.exit_code == 0, done.stderr
    static = 'analysis = "static"' in (ROOT / "examples" / f"{name}.toml").read_text()
    lasting = ("Static analysis",) if static else ("stable step", "an estimate")
    for word in ("mass, kg", "Degrees of freedom", *lasting, "have their defaults"):
        assert word in done.stdout
    assert ("INFERRED" in done.stdout) == (name == "four_bar")
    assert len(done.stdout.splitlines()) < 50 and "filled in" not in done.stdout


def test_all_that_check_knows_is_told_with_long(command: Callable) -> None:
    short, long = (command("check", CASE_C, *words).stdout for words in ([], ["--long"]))
    assert "run.energy_limit" not in short and "run.energy_limit" in long and "filled in" in long
    found = json.loads(command("check", CASE_C, "--json").stdout)
    assert f"{len(found['defaults'])} values" in short
    assert all(f"{value:.4g} s  {name}" in long for name, value in found["step"]["limits"].items())


def test_long_tables_are_told_with_long(command: Callable) -> None:
    chain = 'name = "chain"\n[run]\nduration = 0.1\n[ground]\nO = [0, 0]\n'
    for k in range(33):
        bearing = f"l{k - 1}.end" if k else "ground.O"
        chain += (
            f"[body.l{k}]\nlength = 0.1\nmass = 0.1\nangle = -1.2\n[joint.j{k}]\nbearing ="
            f' "{bearing}"\njournal = "l{k}.start"\n'
        )
    Path("chain.toml").write_text(chain)
    short, long = (command("check", "chain.toml", *words).stdout for words in ([], ["--long"]))
    assert (
        "and 3 more bodies; --long lists them." in short
        and "and 3 more joints" in short
        and " l32 " not in short
        and " j29 " in short
    )
    assert " l32 " in long and " j32 " in long and "more bodies" not in long


def test_a_long_ideal_reference_is_forecast_and_not_run(command: Callable) -> None:
    """One slow turn of it would take hours for a stiff spring, though the run itself is short."""
    Path("m.toml").write_text(
        CASE_C.read_text()
        + '[spring.s]\nfirst = "ground.D"\nsecond = "coupler.end"\nstiffness = 1e9\nfree_length = 0.46\n'
    )
    slow = ["--set", "driver.crank.speed=1e-8"]
    told = command("run", "m.toml", *slow, "--duration", "1e-3", "--json")
    assert told.exit_code == 2 and "--yes" in told.stderr and not Path("runs").exists(), told.stderr
    found = json.loads(command("check", "m.toml", *slow, "--json").stdout)
    assert found["estimate"]["ideal_seconds"] > 3600.0 and "days" in found["estimate"]["asks_for_yes"]
    assert {joint["expected_force"] for joint in found["joints"]} == {None}
    text = command("check", "m.toml", *slow).stdout
    assert "The ideal mechanism alone takes" in text and "vfife run needs --yes" in text


def test_a_long_static_analysis_is_asked_for_twice(command: Callable) -> None:
    """A million load factors of a thousand elements; some few take their time from measured ones."""
    model = ROOT / "examples" / "elastica_circle.toml"
    found = json.loads(command("check", model, "--json").stdout)["estimate"]
    assert 0.05 < found["seconds"] < 10.0 and found["asks_for_yes"] == ""
    long = [
        "--set",
        "body.strip.elements=1000",
        "--set",
        f"run.load_factors={[k / 2000 for k in range(1, 2001)]}",
    ]
    told = command("run", model, *long)
    assert (
        told.exit_code == 2
        and "--yes" in told.stderr
        and "load_factors" in told.stderr
        and not Path("runs").exists()
    ), told.stderr


def test_laws_are_described(command: Callable) -> None:
    laws = json.loads(command("laws", "--json").stdout)
    assert {law["name"] for law in laws} >= {"lankarani-nikravesh", "pereira", "ambrosio", "none"}
    for law in laws:
        assert set(law) == {"name", "kind", "own", "source", "formula", "parameters", "slots"}
        assert law["source"]
        assert law["formula"]
        for one in law["parameters"]:
            assert (
                {"name", "unit", "meaning"}
                <= set(one)
                <= {"name", "unit", "meaning", "default", "above", "low", "high", "choices"}
            )
            assert one["unit"]
            assert one["meaning"]


def test_each_law_has_a_line(command: Callable) -> None:
    lines = command("laws").stdout.splitlines()
    found = json.loads(command("laws", "--json").stdout)
    assert len(lines) == len(found) + 3
    for law in found:
        assert any(
            line.startswith(law["name"]) and law["source"][:20] in line and len(line) <= 120 for line in lines
        )
    assert command("laws", "--long").stdout.count("parameter ") > 20


def test_one_law(command: Callable) -> None:
    (law,) = json.loads(command("laws", "--json", "ambrosio").stdout)
    assert law["kind"] == "friction"
    assert next(one for one in law["parameters"] if one["name"] == "v0")["default"] == 1e-4
    text = command("laws", "Ambrosio").stdout
    assert law["formula"] in text
    assert "pereira" not in text


def test_limits_are_told(command: Callable) -> None:
    (law,) = json.loads(command("laws", "pereira", "--json").stdout)
    one = next(one for one in law["parameters"] if one["name"] == "restitution")
    assert (one["above"], one["high"]) == (0.0, 1.0)
    assert "above 0, at most 1" in command("laws", "pereira").stdout


def test_a_contact_law_by_itself(command: Callable, request: pytest.FixtureRequest) -> None:
    """Twice the mass at half the stiffness goes as deep with half the force; what is printed is what is
    drawn.
    """
    words = ("laws", "lankarani-nikravesh", "--plot", "--speed", "0.5 m/s", "--json")
    (one,) = json.loads(
        command(*words, "--set", "stiffness=1e10 N/m^1.5", "--mass", "1 kg", "-o", "a.svg").stdout
    )
    (two,) = json.loads(command(*words, "--set", "stiffness=2e10", "--mass", "2000 g", "-o", "b.png").stdout)
    assert (
        one["picture"] == "a.svg"
        and Path("a.svg").read_text().startswith("<?xml")
        and Path("b.png").stat().st_size > 10_000
    )
    first, second = (said["numbers"]["impacts"] for said in (one, two))
    assert [entry["restitution"] for entry in first] == pytest.approx([0.05 * k for k in range(1, 21)])
    for a, b in zip(first, second, strict=True):
        assert b["deepest"] == pytest.approx(a["deepest"], rel=1e-9)
        assert b["force"] == pytest.approx(2.0 * a["force"], rel=1e-9)
        assert b["delivered"] == pytest.approx(a["delivered"], rel=1e-9)
    request.getfixturevalue("unrendered")
    assert (
        "delivered" in command("laws", "lankarani-nikravesh", "--plot").stdout
        and Path("lankarani-nikravesh.png").exists()
    )


def test_a_friction_law_by_itself(command: Callable) -> None:
    (law,) = json.loads(
        command(
            "laws", "ambrosio", "--plot", "--normal-force", "50 N", "--set", "coefficient=0.2", "--json"
        ).stdout
    )
    found = {entry["speed"]: entry["force"] for entry in law["numbers"]["steady"]}
    assert found[1e-3] == pytest.approx(0.2 * 50.0 * (1e-3 - 1e-4) / (1e-2 - 1e-4), rel=1e-6)
    assert found[1.0] == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--plot"], "name the law to draw"),
        (["pereira", "--plot", "--material", "bronce"], 'did you mean "bronze"'),
        (["pereira", "--plot", "--clearance", "2 kg"], "a mass"),
        (["pereira", "--plot", "--clearance", "20 mm"], "the journal vanishes"),
        (["pereira", "--plot", "--clearance", "0.5 um"], "no exponent for a clearance"),
        (["pereira", "--plot", "--set", "restitution=2"], "too large"),
        (["pereira", "--plot", "--set", "restitutoin=0.5"], 'Did you mean "restitution"'),
        (["pereira", "--plot", "-o", "picture.doc"], ".png, .svg, .pdf"),
        (["pereira", "--plot", "-o", "none/picture.png"], "there is no folder"),
    ],
)
def test_what_cannot_be_drawn_is_told(command: Callable, words: list[str], expected: str) -> None:
    done = command("laws", *words)
    assert done.exit_code == 2 and expected.lower() in done.stderr.lower(), done.stderr
    assert "Traceback" not in done.output and not list(Path().glob("*.png"))


def test_a_static_model_with_clearance_is_told_what_needs_motion(command: Callable, tmp_path: Path) -> None:
    """Its knocks, fits and life are those of no motion at all."""
    text = (ROOT / "examples" / "toggle_press.toml").read_text()
    sizes = 'clearance = "0.1 mm"\naxial_length = "20 mm"\nbearing_radius = "10 mm"'
    loose = text.replace("[joint.knee]", f'[joint.knee]\nkind = "clearance"\n{sizes}')
    words = "knee: in a static analysis a clearance changes positions and forces. Knocks, fits and life"
    for model, expected in ((text, False), (loose, True)):
        (tmp_path / "press.toml").write_text(model)
        for call in (("check", "press.toml"), ("run", "press.toml", "-o", f"run{expected}", "--yes")):
            done = command(*call)
            assert done.exit_code == 0, done.stderr
            assert (words in " ".join((done.stdout + done.stderr).split())) == expected, done.stdout


def test_check_says_that_nothing_loads_a_model(command: Callable) -> None:
    loaded = command("new", "compressor", "-o", "loaded.toml"), command("check", "loaded.toml").stdout
    assert "No loads" not in loaded[1]
    said = "No loads: the model has neither a load, nor gravity, nor a spring."
    assert said in command("check", CASE_C).stdout
    assert said not in command("check", CASE_C, "--set", "gravity=[0, -9.81]").stdout


def test_check_names_a_material_that_nothing_is_made_of(command: Callable, tmp_path: Path) -> None:
    """A slip: the material is defined, and the body is still of steel."""
    iron = '[material.{}]\nyoungs_modulus = "100 GPa"\npoissons_ratio = 0.25\ndensity = "7000 kg/m^3"\n'
    text = CASE_C.read_text(encoding="utf-8")

    def notes(*names: str, change: str = "") -> list[str]:
        path = tmp_path / "model.toml"
        path.write_text("\n".join([text, *map(iron.format, names)]), encoding="utf-8")
        options = [f"--set={change}"] * bool(change)
        said = json.loads(command("check", path, "--json", *options).stdout)
        return [note for note in said["notes"] if "material" in note]

    assert notes() == []
    (note,) = notes("my")
    assert note.startswith(
        'Nothing is made of [material.my]: give a body material = "my", or a joint bearing_material'
    )
    assert [note.split(":")[0] for note in notes("my", "other", change="body.coupler.material=my")] == [
        "Nothing is made of [material.other]"
    ]
    assert notes("my", change="joint.C.journal_material=my") == []
    assert notes("steel") == []  # of which everything is made that names none


def test_cautions_of_a_long_answer_stand_at_its_end(command: Callable, pendulum: Path) -> None:
    """Its begin has left the screen by then; those of a short answer come first."""
    heavy = "--set", "gravity=[0, -9810]"
    words = "is it 9810 mm/s^2?"
    long = command("check", str(ROOT / "examples" / "jansen_leg_loose.toml"), *heavy).stdout
    assert " ".join(long.splitlines()[-4:]).replace("\n", " ").count(words) == 1
    assert "at the end of this answer." in " ".join(long.splitlines()[:4])
    short = command("check", str(pendulum), *heavy).stdout
    assert words in " ".join(short.splitlines()[:6]) and "at the end" not in short
