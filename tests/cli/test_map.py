"""``vfife map``: a diagram, a table, a file that goes on; sentences."""

import math
from pathlib import Path

import pytest

from vfife.cli.commands.map import number_range
from vfife.dynamics.bifurcation import Spell
from vfife.modelfile import load
from vfife.report.dynamics import spells_words
from vfife.store.lock import Lock

PIN = Path(__file__).resolve().parents[2] / "examples" / "slider_crank_loose_pin.toml"
BRIEF = (
    "--count",
    2,
    "--turns",
    3,
    "--drop",
    1,
    "--step",
    "10 us",
    "--set",
    "joint.pin.contact.restitution=0.3",
)


def test_a_map_is_drawn_told_and_gone_on_with(command, tmp_path, request):
    words = (
        "map",
        PIN,
        "--over",
        "joint.pin.clearance=0.2..0.3mm",
        *BRIEF,
        "--companions",
        1,
        "-o",
        "a.map",
        "--csv",
        "a.csv",
    )
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    assert "haotic within 3 turns: on the way up" in done.stdout and "On the way down: " in done.stdout
    assert "2 turns" not in done.stdout and "3 turns at each value, 1 discarded" in done.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG") and len(
        (tmp_path / "a.csv").read_text().splitlines()
    ) == 1 + 2 * 2 * 2
    assert "of 2 values" in done.stderr
    request.getfixturevalue("unrendered")
    again = command(*words)
    assert again.exit_code == 0 and "of 2 values" not in again.stderr
    anew = command(*words, "--force")
    assert anew.exit_code == 0 and "of 2 values" in anew.stderr


FAULTS = (
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
    (("--over", "body.rod.length=120..121mm", *BRIEF), "have moved in their bodies"),
)
BY_DEFAULT = FAULTS[:4]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        pytest.param(*one, marks=() if one in BY_DEFAULT else pytest.mark.system("a command for each fault"))
        for one in FAULTS
    ],
)
def test_faults_are_sentences(command, words, said):
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


@pytest.mark.usefixtures("unrendered")
def test_a_damaged_map_says_that_it_is_a_map(command, tmp_path):
    words = (
        "map",
        PIN,
        "--over",
        "joint.pin.clearance=0.2..0.3mm",
        *BRIEF,
        "--companions",
        0,
        "-o",
        "a.map",
        "-q",
    )
    assert command(*words).exit_code == 0
    (tmp_path / "a.map").write_bytes((tmp_path / "a.map").read_bytes()[:3000])
    done = command(*words)
    assert (
        done.exit_code == 2
        and "this map file is damaged" in done.stderr
        and "make the map again" in done.stderr
    )


def test_a_section_is_drawn_told_and_shown(command, tmp_path, request):
    words = (
        "map",
        "section",
        PIN,
        "--turns",
        6,
        "--drop",
        2,
        *BRIEF[6:],
        "--step",
        "10 us",
        "-o",
        "s.map",
        "--csv",
        "s.csv",
    )
    done = command(*words)
    assert done.exit_code == 0, done.stderr
    assert (
        "contacts began, the fastest at" in done.stdout and "4 turns after 2 discarded turns" in done.stdout
    )
    assert "exponent" in done.stdout and "contact lankarani-nikravesh, friction none" in done.stdout
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG") and (tmp_path / "s.impacts.csv").exists()
    request.getfixturevalue("unrendered")
    shown = command("map", "show", "s.map", "--figure", "again.png")
    assert shown.exit_code == 0 and "contacts began" in shown.stdout and (tmp_path / "again.png").exists()


def test_basins_are_drawn_told_and_shown(command, tmp_path):
    words = (
        "map",
        "basins",
        PIN,
        "--over",
        "start.pin.x=-0.6..0.6mm",
        "--over",
        "start.crank=0..90deg",
        "--count",
        "3x2",
        "--turns",
        3,
    )
    done = command(
        *words, "--drop", 1, *BRIEF[6:], "--step", "10 us", "-o", "b.map", "--csv", "b.csv", "--companions", 1
    )
    assert done.exit_code == 0, done.stderr
    assert (
        "4 of the grid are not valid starts" in " ".join(done.stdout.split())
        and "1 case repeated" in done.stdout
    )
    assert (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG") and len(
        (tmp_path / "b.csv").read_text().splitlines()
    ) == 3
    shown = command("map", "show", "b.map")
    assert shown.exit_code == 0 and "4 of the grid are not valid starts" in " ".join(shown.stdout.split())


def test_where_which_motion_is_found_is_told() -> None:
    """Of a way with few spells all, of one with many the longest; a threshold lies between two of them."""
    few = [Spell("chaotic", 0.0, 0.03, 4), Spell("period 1", 0.04, 0.04, 1), Spell("chaotic", 0.05, 0.1, 6)]
    assert spells_words(few, "1") == "chaotic from 0 to 0.03, period 1 at 0.04, chaotic from 0.05 to 0.1"
    many = [Spell(f"period {k}", 1e-3 * k, 1e-3 * k, 1) for k in range(1, 20)] + [
        Spell("chaotic", 0.03, 0.04, 5)
    ]
    said = spells_words(many, "m")
    assert said.startswith("period 1 at 1 mm, period 2 at 2 mm") and said.count("period") == 7
    assert said.endswith("chaotic from 30 mm to 40 mm, and 12 others between them")


def test_a_range_is_what_is_said() -> None:
    """To the last digit, whatever the model's own value is."""
    model = load(PIN)
    assert number_range(model, "joint.pin.clearance=0.0201..0.4mm")[1:3] == (
        pytest.approx(2.01e-5, rel=1e-14),
        pytest.approx(4e-4, rel=1e-14),
    )
    assert number_range(model, "driver.crank.speed=500..1500rpm")[1:3] == pytest.approx(
        (500.0 * math.tau / 60.0, 50.0 * math.pi), rel=1e-14
    )


@pytest.mark.usefixtures("unrendered")
def test_values_are_begun_anew(command):
    done = command(
        "map",
        PIN,
        "--over",
        "joint.pin.clearance=0.2..0.3mm",
        *BRIEF,
        "-o",
        "a.map",
        "--start",
        "own",
        "--start",
        "start.crank=90deg",
    )
    assert done.exit_code == 0, done.stderr
    assert (
        "own start" in done.stdout
        and "start.crank = 1.571 rad" in done.stdout
        and "Companions: " in done.stdout
    )


def test_faults_of_starts_are_sentences(command):
    over = "--over", "joint.pin.clearance=0.2..0.3mm"
    for words, said in (
        ((PIN, *over, "--start", "start.pen.x=1mm"), "start.pin.x"),
        ((PIN, *over, "--start", "start.crank"), "neither own nor PATH=VALUE"),
        ((PIN, *over, "--start", "start.pin.x=1kg"), "--start start.pin.x=1kg"),
        ((PIN, *over, *BRIEF, "--start", "start.pin.x=1mm"), "outside its bearing"),
        (("section", PIN, "--impacts", "guide"), "joint with clearance"),
        (("section", PIN, "--turns", 5, "--drop", 5), "--drop 5: no turn of --turns 5 remains"),
        (
            (PIN, *over, "--turns", 4, "--drop", 80),
            "--drop 80: no turn of --turns 4 remains; allowed: 0 to 3",
        ),
        ((PIN, "--over", "start.crank=1..2deg"), "--over start.crank=1..2deg"),
        (("basins", PIN, *over), "name two numbers"),
        (("basins", PIN, *over, "--over", "start.crank=1deg"), "PATH=LOW..HIGH"),
        (("basins", PIN, *over, "--over", "start.crank=2..1deg"), "the range is empty"),
        (("basins", PIN, *over, "--over", "start.crank=0..90deg", "--count", "3xx"), "40x30"),
        (("basins", PIN, *over, "--over", "start.crank=0..90deg", "--count", "1"), "2 to"),
        (("show", "none.map"), "none.map"),
    ):
        done = command("map", *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), (words, done.stderr)
        assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("unrendered")
def test_what_it_will_cost_is_told_first_and_too_much_is_refused(command, tmp_path):
    """Members that a file has are not counted; what takes hours is begun with --yes alone."""
    over = "--over", "joint.pin.clearance=0.2..0.3mm"
    words = ("map", PIN, *over, *BRIEF, "--companions", 0, "-o", "a.map")
    assert "forecast: 2 values, about 18,852 steps each: " in command(*words).stderr
    assert (
        "forecast" not in command(*words).stderr
        and "forecast" not in command(*words[:-1], "b.map", "-q").stderr
    )
    long = command(
        "map",
        PIN,
        *over,
        "--count",
        40,
        "--turns",
        500,
        "--drop",
        499,
        "--companions",
        0,
        "-o",
        "d.map",
        "--of",
        "nope",
    )
    assert "note: for a first look: --count 30 --turns 45 -o first.map, about" in " ".join(
        long.stderr.split()
    ), long.stderr
    many = "--turns", 1_000_000, "--drop", 1, "-o", "c.map"
    for command_, more in (
        ((), over),
        (("section",), ()),
        (("basins",), (*over, "--over", "start.crank=0..90deg")),
    ):
        done = command("map", *command_, PIN, *more, *many)
        said = " ".join(done.stderr.split())
        assert done.exit_code == 2 and "add --yes" in said and "Nothing was started" in said, (command_, said)
    assert not (tmp_path / "c.map").exists()
