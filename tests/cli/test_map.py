"""``vfife map``: a diagram, a table, a file that goes on; sentences."""

from pathlib import Path

PIN = Path(__file__).resolve().parents[2] / "examples" / "slider_crank_loose_pin.toml"
BRIEF = ("--count", 2, "--turns", 3, "--drop", 1, "--step", "20 us", "--set", "joint.pin.contact.restitution=0.3")


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
        (("--over", "body.rod.length=120..121mm", *BRIEF), "elsewhere in their bodies"),
    ):
        done = command("map", PIN, *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
        assert "Traceback" not in done.stderr
