"""``vfife help WORD`` finds commands by purpose; the help groups every command once."""

import dataclasses
import json
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import vfife
from vfife import Mechanism
from vfife.cli.app import app
from vfife.cli.commands import help as topics
from vfife.cli.registry import COMMANDS, PURPOSES

DOCS = Path(__file__).resolve().parents[2] / "docs"
# A word of a user and a command that must be among the first three.
EXPECTED = {
    "noise": "impacts", "knocks": "impacts", "rattle": "impacts", "bifurcation": "map sweep",
    "Poincaré": "map section", "chaos": "map section", "basin": "map basins", "lyapunov": "map sweep",
    "frequencies": "modes", "eigenfrequency": "modes", "resonance": "modes", "FFT": "spectrum",
    "order": "waterfall", "life": "wear", "durability": "wear", "tolerance": "study tolerance",
    "ISO 286": "study allocate", "fit": "fit", "calibrate": "fit", "sobol": "study indices",
    "speed sweep": "map sweep", "gradient": "sensitivity", "excel": "export", "matlab": "export",
    "csv": "export", "video": "animate", "pdf": "report", "draw": "plot", "continue": "resume",
    "pareto": "optimise", "hardness": "materials", "hertz": "laws", "backlash": "run", "validation": "verify",
    "deviation": "study tolerance", "miss target": "study tolerance",
    "gallery": "new", "browser": "live", "autocomplete": "schema",
}  # fmt: skip


def test_the_help_groups_every_command_once() -> None:
    names = [name for group in PURPOSES.values() for name in group]
    assert len(set(names)) == len(names) and set(names) == set(get_command(app).commands)
    text = CliRunner().invoke(app, ["--help"]).stdout
    places = [text.find(f"─ {purpose} ") for purpose in PURPOSES]
    assert -1 not in places and places == sorted(places) and "─ Commands ─" not in text
    for k, group in enumerate(PURPOSES.values()):
        panel = text[places[k] : places[k + 1] if k + 1 < len(places) else None]
        assert [name for name in group if f"│ {name} " not in panel] == []
    assert COMMANDS["run"].aim == "a simulation"


@pytest.mark.parametrize(("word", "command"), EXPECTED.items())
def test_a_word_finds_its_command(word: str, command: str) -> None:
    assert command in [one.name for one in topics.search(word) if one.kind == "command"][:3]


def test_all_kinds_of_topics_are_found() -> None:
    names = {(one.kind, one.name) for word in ("play", "restitution") for one in topics.search(word)}
    for topic in (("key of a model", "joint.NAME.clearance"), ("law", "pereira"), ("option", "--clearance")):
        assert topic in names
    assert ("measure", "*.approach_speed.max") in {
        (one.kind, one.name) for one in topics.search("knock speed")
    }
    assert ("page", "wear.html") in {(one.kind, one.name) for one in topics.search("life")}


@pytest.mark.parametrize(
    ("text", "topic"),
    [
        ("whirl", "designer.html"), ("dry friction whirl", "designer.html"), ("whirl", "run"),
        ("blow", "first-run.html"), ("blow", "run"), ("shock", "trust.html"),
        ("external contact", "joint.NAME.kind"), ("mesh", "statics.html"),
        ("mesh", "trust.html"), ("mesh", "body.NAME.elements"),
    ],
)  # fmt: skip
def test_phenomena_that_cautions_and_pages_name_are_found(text: str, topic: str) -> None:
    """The page speaks of it, too."""
    assert topic in [one.name for one in topics.search(text)]
    if topic.endswith(".html"):
        page = (DOCS / topic).with_suffix(".md").read_text(encoding="utf-8").lower()
        assert text.removesuffix("s").split()[-1] in page


@pytest.mark.parametrize("word", ["gauge", "absolute"])
def test_kinds_of_pressure_find_the_keys_of_a_load(word: str) -> None:
    names = {one.name for one in topics.search(word) if one.kind == "key of a model"}
    assert {"load.NAME.pressure", "load.NAME.ambient"} <= names


@pytest.mark.parametrize("word", ["dB", "decibel", "sound pressure"])
def test_levels_of_sound_lead_to_the_page_on_noise(word: str) -> None:
    assert ("page", "spectra.html") in {(one.kind, one.name) for one in topics.search(word)}


@pytest.mark.parametrize(
    ("word", "kind", "name"),
    [
        ("film", "command", "animate"), ("motor", "key of a model", "driver.NAME.torque"),
        ("motor curve", "key of a model", "driver.NAME.speeds"),
        ("weight", "key of a model", "gravity"), ("weight", "key of a model", "body.NAME.mass"),
        ("cam", "key of a model", "joint.NAME.points"),
        ("bearing", "key of a model", "joint.NAME.bearing"), ("gear", "key of a model", "gear"),
        ("shaft", "key of a model", "joint.NAME.journal"),
    ],
)  # fmt: skip
def test_a_word_of_a_designer_finds_its_topic_first(word: str, kind: str, name: str, command) -> None:
    """Among the first of its kind, in the table that the answer begins with, unless a model has the word."""
    data = json.loads(command("help", word, "--json").stdout)
    names = [topic["name"] for topic in data if topic["kind"] == kind]
    assert name in names[:3]
    text = command("help", word).stdout
    assert f"vfife {name}" in text if kind == "command" else name in text
    heads = [line.split("  ")[0].strip() for line in text.splitlines() if "what it is" in line]
    assert heads[0].startswith((kind, topics.MODEL))


def test_a_fit_of_iso_286_is_no_identification(command) -> None:
    data = json.loads(command("help", "H7", "--json").stdout)
    names = [topic["name"] for topic in data if topic["kind"] == "command"]
    assert "fit" not in names and {"study allocate", "design"} <= {*names}


@pytest.mark.parametrize(
    ("word", "names"),
    [("toggle", {"toggle_press", "williams_toggle"}), ("press", {"toggle_press", "six_bar_press"})],
)
def test_a_word_finds_the_models_to_start_from(word: str, names: set[str]) -> None:
    assert names <= {one.name for one in topics.search(word) if one.kind == topics.MODEL}
    text = CliRunner().invoke(app, ["help", word]).stdout
    for name in names:
        assert f"vfife new {name} " in text


def test_a_word_without_a_hit_is_answered_in_one_line() -> None:
    result = CliRunner().invoke(app, ["help", "bifurkation"])
    assert result.exit_code == 2 and "did you mean bifurcation" in result.stderr
    assert len(result.stderr.splitlines()) == 1 and not result.stdout
    result = CliRunner().invoke(app, ["help", "qqqq", "--json"])
    assert json.loads(result.stdout)["status"] == "refused"
    assert all(purpose in CliRunner().invoke(app, ["help"]).stdout for purpose in PURPOSES)


def test_words_without_a_topic_of_all_find_topics_of_each() -> None:
    """As "cutting force": the measures and keys of forces, after a sentence that says so."""
    result = CliRunner().invoke(app, ["help", "cutting", "force"])
    assert result.exit_code == 0 and "Nothing has all words of 'cutting force'." in result.stdout
    assert "*.force.max" in result.stdout and "load.NAME.force" in result.stdout
    names = {
        topic["name"]
        for topic in json.loads(CliRunner().invoke(app, ["help", "motor power", "--json"]).stdout)
    }
    assert {"driver.NAME.torque", "*.power.mean"} <= names
    assert CliRunner().invoke(app, ["help", "qqqq", "wwww"]).exit_code == 2


# What a German engineer types, and what must be found.
GERMAN_FINDS = {
    "Lebensdauer": "wear", "Spiel": "joint.NAME.clearance", "Lagerspiel": "joint.NAME.clearance",
    "Kraft": "*.force.max", "Lager": "joint.NAME.bearing", "Verschleiß": "wear",
    "Verschleissrate": "wear", "Schwingung": "modes", "Eigenschwingung": "modes", "Drehzahl": "map sweep",
    "Reibung": "laws", "Wirkungsgrad": "*.efficiency", "Passung": "design", "Toleranz": "study tolerance",
    "Bericht": "report", "Hub": "load.NAME.zero_travel", "Druck": "load.NAME.table", "Lärm": "impacts",
    "Stoß": "impacts", "Einheit": "model-file.html", "Feder": "spring", "Dämpfung": "spring.NAME.damping",
    "Totpunkt": "load.NAME.zero_travel", "Tabelle": "export", "Werkstoff": "materials",
}  # fmt: skip


@pytest.mark.parametrize(("word", "name"), GERMAN_FINDS.items())
def test_german_words_of_the_field_are_understood(word: str, name: str, command) -> None:
    done = command("help", word, "--json")
    assert done.exit_code == 0, done.stderr
    assert name in [topic["name"] for topic in json.loads(done.stdout)]


def test_german_words_lead_to_words_of_the_search() -> None:
    """Some topic answers each of them: a search returns the topics with a score above zero."""
    all_topics = list(topics.topics())
    queries = {word: topics.tokens(topics.in_english(word)) for word in topics.GERMAN}
    found = {query: any(topic.score(query) > 0.0 for topic in all_topics) for query in set(queries.values())}
    assert [word for word, query in queries.items() if not found[query]] == []


def test_tables_of_a_model_come_first_for_csv(command) -> None:
    said = command("help", "csv").stdout
    assert said.index("load.NAME.table") < said.index("vfife export")
    assert "driver.NAME.table" in said


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("top dead centre", "load.NAME.zero_travel"),
        ("top dead centre", "model-file.html"),
        ("pressure", "load.NAME.table"),
        ("pressure", "*.contact_pressure.max"),
        ("two runs", "plot"),
    ],
)
def test_words_of_a_designer(text: str, name: str) -> None:
    assert name in [topic.name for topic in topics.search(text)]


def test_measures_are_explained_in_words() -> None:
    found = {topic.name: topic.text for topic in topics.measures()}
    assert found["*.contact_pressure.max"] == "largest contact pressure, in Pa"
    assert found["*.share.free_flight"] == "share free flight, a number"


def test_the_answer_of_one_word() -> None:
    result = CliRunner().invoke(app, ["help", "noise"])
    assert result.exit_code == 0 and result.stdout.index("vfife impacts") < result.stdout.index(
        "spectra.html"
    )
    data = json.loads(CliRunner().invoke(app, ["help", "noise", "--json"]).stdout)
    assert {"kind": "command", "name": "spectrum", "text": "frequencies and orders"} in data


def test_pages_have_the_titles_of_the_documentation() -> None:
    for file, (title, _) in topics.PAGES.items():
        assert (DOCS / f"{file}.md").read_text(encoding="utf-8").startswith(f"# {title}\n")


def test_a_zone_of_iso_286_finds_what_a_fit_finds(command) -> None:
    done = command("help", "H7")
    assert done.exit_code == 0 and "tolerance" in done.stdout


def test_measures_of_a_static_analysis_are_found() -> None:
    found = {one.name: one.text for one in topics.search("displacement")}
    assert "centre of mass of a rigid body" in found["displacement.max"]
    mechanism = Mechanism("stretched")
    mechanism.point("O", 0.0, 0.0)
    mechanism.link("bar", length=1.0, mass=1.0)
    mechanism.revolute("A", "ground.O", "bar.start")
    mechanism.spring("s", "ground.O", "bar.end", stiffness=1.0)
    settings = dataclasses.replace(mechanism.settings, analysis="static")
    measures = vfife.simulate(dataclasses.replace(mechanism, settings=settings)).measures
    assert set(topics.STATIC_MEASURES) <= set(measures)


def test_a_motor_and_a_flywheel_lead_to_what_sizes_them() -> None:
    motor, flywheel = ({topic.name for topic in topics.search(word)} for word in ("motor", "flywheel"))
    assert {"*.torque.rms", "*.torque.max", "first-run.html"} <= motor
    assert {"*.energy_fluctuation", "first-run.html", "body.NAME.end_inertia"} <= flywheel
