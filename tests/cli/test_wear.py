"""``vfife wear``: a figure, a table, the worn model, a file that goes on and is shown; sentences."""

import dataclasses
import json
import re
from pathlib import Path

import pytest

import vfife
from vfife.laws.materials import PAIRS
from vfife.report.wear import document as wear_document
from vfife.store.lock import Lock

PIN = Path(__file__).resolve().parents[2] / "examples" / "slider_crank_loose_pin.toml"
BRIEF = (
    "--turns",
    "2e3",
    "--block",
    1,
    "--settle",
    1,
    "--step",
    "10 us",
    "--set",
    "joint.pin.contact.restitution=0.3",
)
WEAR = 'wear = { bearing = "1e-6 mm^3/(N m)", journal = "mild steel on mild steel" }'


def worn_pin(folder: Path) -> Path:
    """The example, with friction and wear."""
    text = PIN.read_text().replace(
        'friction = { law = "none" }',
        f'{WEAR}\nfriction = {{ law = "ambrosio", coefficient = 0.05, v0 = 1e-4, v1 = 1e-2 }}',
    )
    model = folder / "pin.toml"
    model.write_text(text)
    return model


@pytest.mark.slow("runs and draws wear twice")
def test_wear_is_drawn_told_and_gone_on_with(command, tmp_path, request):
    model = worn_pin(tmp_path)
    words = ("wear", model, *BRIEF, "-o", "a.wear", "--csv", "a.csv", "--worn", "worn.toml")
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "pin: rod (bearing) 1e-15" in said and "pin: block (journal) 4.38e-12" in said
    assert (
        "steps a turn; friction: pin ambrosio. With half the step the volume that the last block wears"
        in said
    )
    assert (
        "pin: block (journal) is that of mild steel on mild steel, dry, K = 0.007 (Archard: Contact and"
        in said
    )
    assert "within a factor of 10, 4.4e-13 to 4.4e-11 1/Pa, with oil 4.4e-15 and less" in said
    assert (tmp_path / "a-wear.png").read_bytes().startswith(
        b"\x89PNG"
    ) and "turns,joint,side,angle [rad],depth [m],body" in (tmp_path / "a.csv").read_text()
    assert len(vfife.load_model(tmp_path / "worn.toml").contacts["pin"].wear.bearing_profile) == 15
    assert "2,000 of 2,000 turns" in done.stderr
    request.getfixturevalue("unrendered")
    again = command(*words)
    assert again.exit_code == 0 and "2,000 of" not in again.stderr and again.stdout == done.stdout
    assert again.stdout.splitlines()[-1] == "a.wear, a-wear.png, a.csv, worn.toml"
    commas = command("wear", "a.wear", "--csv", "c.csv", "--decimal", "comma")
    assert commas.exit_code == 0 and commas.stdout.splitlines()[-1].endswith("c.csv")
    row = (tmp_path / "c.csv").read_text(encoding="utf-8-sig").splitlines()[1]
    assert row.startswith("0,0;pin;bearing;-3,1") and row.endswith(";0,0;rod")
    wrong = command("wear", "a.wear", "--csv", "c.xlsx", "--decimal", "comma")
    assert wrong.exit_code == 2 and 'decimal = "comma" is for .csv' in " ".join(wrong.stderr.split())
    shown = command("wear", "a.wear", "--figure", "b.svg")
    assert shown.exit_code == 0 and "pin: block (journal)" in shown.stdout and (tmp_path / "b.svg").exists()
    other = command("info", "a.wear")
    assert (
        other.exit_code == 2
        and "is the results of vfife wear, not a run; show them with vfife wear" in other.stderr
    )


@pytest.mark.parametrize(
    ("option", "text", "remedy"), [("--clearance", "0.8", "0.8 mm"), ("--force", "2", "2 kN")]
)
def test_a_limit_without_a_unit_is_questioned_before_anything_is_simulated(
    command, tmp_path, option, text, remedy
):
    done = command("wear", worn_pin(tmp_path), *BRIEF, option, text, "-o", "a.wear")
    said = " ".join(done.stderr.split())
    assert done.exit_code == 2 and "a unit is probably missing" in said and f'"{remedy}"' in said
    assert "forecast" not in said and not Path("a.wear").exists()


@pytest.mark.usefixtures("unrendered")
def test_a_limit_that_is_not_reached_is_told_with_when_it_would_be(command, tmp_path):
    """Life is more than the turns that were asked for; the later one is the last slope of the clearance over
    turns, drawn on.
    """
    done = command("wear", worn_pin(tmp_path), *BRIEF, "--clearance", "0.8 mm", "-o", "a.wear")
    assert done.exit_code == 0, done.stderr
    found = vfife.tribology.load_wear("a.wear")
    left = (
        (0.8e-3 - found.clearance[-1, 0])
        / (found.clearance[-1, 0] - found.clearance[-2, 0])
        * (found.turns[-1] - found.turns[-2])
    )
    said = " ".join(done.stdout.split())
    assert "Life: more than 2,000 turns; no limit was reached" in said
    turns = float(f"{found.turns[-1] + left:.2g}")
    assert f"grooves smoothed by 8 harmonics give {turns:,.0f} turns" in said
    assert re.search(
        r"turns \(\S+ to \S+ h at \S+ rpm\); \S+ to \S+( million)? with the scatter of the wear", said
    )
    grown, lost = (
        float(f)
        for f in re.search(
            r"The clearance of pin grew by (\S+) µm where its deepest places lost (\S+) µm: 8 harmonics", said
        ).groups()
    )
    assert 0.0 < grown < 0.8 * lost
    # The table, the axis and the limit mean smoothed profiles; the deepest places reach the limit earlier.
    assert "clearance, smoothed" in said
    earlier = found.turns_to("pin", 0.8e-3, smoothed=False)
    deepest = found.unsmoothed_clearance("pin")
    assert deepest[-1] - deepest[0] == pytest.approx(1e-6 * lost, rel=1e-3) and earlier < 0.9 * turns
    # Between: the same volumes spread evenly, at the rate of the last jump.
    lost_means = (found.depth - found.depth[0]).mean(axis=2).sum(axis=1)
    rate = (lost_means[-1] - lost_means[-2]) / (found.turns[-1] - found.turns[-2])
    even = found.turns[-1] + (0.8e-3 - found.clearance[0, 0] - lost_means[-1]) / rate
    low, high = (
        float(end.replace(",", ""))
        for end in re.search(r"pin would reach 0.8 mm after (\S+) to (\S+) turns", said).groups()
    )
    assert earlier / 1.1 < low <= earlier and even <= high < 1.1 * even
    assert not found.life("pin", 0.8e-3).determined
    # A limit that the deepest places reach in the turns that were simulated is no bound of the life.
    between = 0.5 * float(deepest[-1] + found.clearance[-1, 0])
    spec = dataclasses.replace(found.spec, clearance=between)
    text = str(wear_document(dataclasses.replace(found, spec=spec)))
    assert "Life: not determined; with smoothed grooves no limit was reached in 2,000 turns; at the" in text
    assert "more than 2,000 turns" not in text
    assert "less where a limit is reached" in done.stderr
    assert done.stderr.index("forecast: ") < done.stderr.index("2,000 of 2,000 turns")


def test_faults_are_sentences(command, tmp_path):
    model = worn_pin(tmp_path)
    soft = tmp_path / "soft.toml"
    soft.write_text(
        model.read_text()
        .replace('"1e-6 mm^3/(N m)"', '"ptfe on tool steel"')
        .replace("[joint.pin]", '[joint.pin]\nbearing_material = "ptfe"')
    )
    odd = tmp_path / "odd.toml"
    odd.write_text(
        model.read_text().replace(
            'bearing = "1e-6 mm^3/(N m)"', "bearing = -1, bearing_profile = [1e-6, 2e-6]"
        )
    )
    for words, said in (
        ((PIN,), "no joint has a wear coefficient above zero"),
        ((model, "--turns", "0"), "greater than or equal to 1"),
        ((model, "--turns", "1e16"), "--turns 1e+16: more than can be counted"),
        ((model, "--tolerance", "2"), "a share above 0 and up to 1"),
        ((model, "--clearance", "0.1 mm"), "as much clearance at the start"),
        ((model, "--clearance", "1 s"), "--clearance 1 s"),
        ((model, "-o", "."), "a wear file is kept here"),
        ((model, "--figure", "a.gif"), ".png"),
        ((soft,), "is over the hardness of the bearing, and that of ptfe is not known"),
        ((odd,), "bearing"),
        ((tmp_path / "none.toml",), "none.toml"),
    ):
        done = command("wear", *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
        assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.wear"))


@pytest.mark.usefixtures("unrendered")
def test_a_coefficient_for_joints_without_a_table(command, tmp_path):
    """It wears as the same table in the model does; a table has precedence over it."""
    bare = tmp_path / "bare.toml"
    bare.write_text(worn_pin(tmp_path).read_text().replace(f"{WEAR}\n", ""))
    refused = command("wear", bare, *BRIEF)
    assert refused.exit_code == 2 and '--wear "8e-17 1/Pa"' in " ".join(refused.stderr.split())
    words = ("--wear", "1e-15", *BRIEF, "--csv")
    assert command("wear", bare, *words, "bare.csv", "-o", "a.wear").exit_code == 0
    table = tmp_path / "table.toml"
    table.write_text(
        (tmp_path / "pin.toml").read_text().replace(WEAR, "wear = { bearing = 1e-15, journal = 1e-15 }")
    )
    assert command("wear", table, *BRIEF, "--csv", "table.csv", "-o", "b.wear").exit_code == 0
    depths = Path("bare.csv").read_text()
    assert depths == Path("table.csv").read_text() and len(depths.splitlines()) > 10
    model = vfife.load_model(table)
    with_table = vfife.tribology.wear_state.with_wear(model, "2e-15 1/Pa", "wear()")
    assert with_table.contacts["pin"].wear == model.contacts["pin"].wear
    wrong = command("wear", bare, *BRIEF, "--wear", "much")
    assert wrong.exit_code == 2 and "wear" in wrong.stderr and "Traceback" not in wrong.stderr


def test_joints_that_cannot_wear_are_told(command, tmp_path):
    model = worn_pin(tmp_path)
    for old, new, said in (
        (
            "clearance = ",
            'friction_moment = "off"\nclearance = ',
            "with friction_moment off the sliding due to rotation is ignored",
        ),
        (WEAR, "wear = { bearing = 1e-15, bearing_profile = [1e-6, 2e-6] }", "a cosine lacks its sine"),
        (WEAR, 'wear = { bearing = "steel on butter" }', "mild steel on mild steel"),
    ):
        other = tmp_path / "other.toml"
        other.write_text(model.read_text().replace(old, new, 1))
        done = command("check", other)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr


@pytest.mark.parametrize("unit", ["mm3/Nm", "mm^3/(N m)", "mm3/(N*m)", "mm³/(N m)"])
def test_units_of_tribology_are_read(command, tmp_path, unit):
    model = worn_pin(tmp_path)
    model.write_text(model.read_text().replace(WEAR, f'wear = {{ bearing = "8e-8 {unit}" }}', 1))
    done = command("check", model)
    assert done.exit_code == 0 and "pin: rod (bearing) wears by 8e-17 1/Pa" in " ".join(done.stdout.split())


def test_the_fault_of_a_coefficient_has_its_unit_and_all_pairs(command, tmp_path):
    model = worn_pin(tmp_path)
    for wrong in ("8e-8 mm3/kg", "steel on butter"):
        model.write_text(model.read_text().replace(WEAR, f'wear = {{ bearing = "{wrong}" }}', 1))
        said = " ".join(command("check", model).stderr.split())
        assert all(name in said for name in PAIRS) and wrong in said, said
        assert "mm^3/(N m)" in said and "1 1/Pa" not in said
        model = worn_pin(tmp_path)
    model.write_text(model.read_text().replace(WEAR, 'wear = { bearing = "-1 1/Pa" }', 1))
    said = " ".join(command("check", model).stderr.split())
    assert "negative" in said and 'as in "8e-8 mm^3/(N m)"' in said


def test_check_and_run_tell_the_wear(command, tmp_path):
    """Coefficients with their sources, and what a turn takes."""
    model = worn_pin(tmp_path)
    told = " ".join(command("check", model).stdout.split())
    assert (
        "pin: rod (bearing) wears by 1e-15 1/Pa" in told
        and "mild steel on mild steel (Archard: Contact and rubbing of flat surfaces" in told
    )
    done = command("run", model, "--turns", 1, "--step", "10 us", "--companions", 0, "-o", "r")
    long = command("info", "r", "--long").stdout
    assert done.exit_code == 0 and "Wear by Archard's law (last turn)" in long and "mm³" in long
    assert "pin: rod (bearing)" in long and "pin: block (journal)" in long
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["surfaces"] == {
        "pin": {"bearing": "rod", "journal": "block"}
    }


def test_two_writers_of_wear_are_kept_apart(command, tmp_path):
    model = worn_pin(tmp_path)
    with Lock(tmp_path, "a.wear.lock", "this wear"):
        done = command("wear", model, *BRIEF, "-o", "a.wear")
    assert done.exit_code == 2 and "writes this wear" in done.stderr and not (tmp_path / "a.wear").exists()


def test_force_is_a_limit_here_and_replaces_no_file(command) -> None:
    done = command("wear", "model.toml", "--force")
    words = " ".join(done.output.replace("│", " ").split())
    assert done.exit_code == 2 and "the joint force that ends the life, as in --force '2 kN'" in words
