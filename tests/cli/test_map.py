"""``vfife map``: a diagram, a table, a file that goes on; sentences."""

from pathlib import Path

from vfife.results.lock import Lock

PIN = Path(__file__).resolve().parents[2] / "examples" / "slider_crank_loose_pin.toml"
BRIEF = ("--count", 2, "--turns", 3, "--drop", 1, "--step", "10 us", "--set", "joint.pin.contact.restitution=0.3")


def test_a_map_is_drawn_told_and_gone_on_with(command, tmp_path):
    words = ("map", PIN, "--over", "joint.pin.clearance=0.2..0.3mm", *BRIEF, "-o", "a.map", "--csv", "a.csv")
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    assert "2 turns" not in done.stdout and "3 turns at each value, 1 of them dropped" in done.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG") and len((tmp_path / "a.csv").read_text().splitlines()) == 1 + 2 * 2 * 2
    assert "of 2 values" in done.stderr
    again = command(*words)
    assert again.exit_code == 0 and "of 2 values" not in again.stderr


def test_faults_are_sentences(command):
    for words, said in (
        (("--over", "joint.pin.clearance"), "PATH=LOW..HIGH"),
        (("--over", "joint.pin.clearence=1..2mm"), "clearance"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--figure", "a.gif"), ".png"),
        (("--over", "joint.pin.clearance"), "--over joint.pin.clearance"),
        (("--over", "joint.pin.clearance=1..1mm"), "--over joint.pin.clearance=1..1mm: the range is empty"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--of", "nope"), "Name one that it has"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--step", "1 s", "-o", "b.map"), "1 s"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--count", 10**9), "10000"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--turns", 10**9), "1000000"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "--csv", "none/a.csv"), "there is no folder"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "-o", "none/a.map"), "there is no folder"),
        (("--over", "joint.pin.clearance=0.2..0.3mm", "-o", "."), "a map file is kept here"),
        (("--over", "body.rod.length=120..121mm", *BRIEF), "elsewhere in their bodies"),
    ):
        done = command("map", PIN, *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
        assert "Traceback" not in done.stderr


def test_a_figure_does_not_take_the_place_of_the_map(command, tmp_path):
    done = command("map", PIN, "--over", "joint.pin.clearance=0.2..0.3mm", *BRIEF, "-o", "a.png")
    assert done.exit_code == 2 and "as in a.map" in done.stderr and not list(tmp_path.iterdir())


def test_two_writers_of_a_map_are_kept_apart(command, tmp_path):
    with Lock(tmp_path, "a.map.lock", "this map"):
        done = command("map", PIN, "--over", "joint.pin.clearance=0.2..0.3mm", *BRIEF, "-o", "a.map")
    assert done.exit_code == 2 and "writes this map" in done.stderr and not (tmp_path / "a.map").exists()


def test_a_damaged_map_says_that_it_is_a_map(command, tmp_path):
    words = ("map", PIN, "--over", "joint.pin.clearance=0.2..0.3mm", *BRIEF, "-o", "a.map", "-q")
    assert command(*words).exit_code == 0
    (tmp_path / "a.map").write_bytes((tmp_path / "a.map").read_bytes()[:3000])
    done = command(*words)
    assert done.exit_code == 2 and "this map file is damaged" in done.stderr and "make the map again" in done.stderr
