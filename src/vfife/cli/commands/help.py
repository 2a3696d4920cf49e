"""``vfife help``: search commands, options, laws, measures, keys and pages by a word."""

from __future__ import annotations

import difflib
import json
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from ...measures.catalogue import UNITS
from ...report.document import Document, Paragraph, Table
from ...report.laws import described
from ..arguments.models import HelpOptions
from ..registry import COMMANDS, PURPOSES, load_command
from ..terminal import answer, command, fail
from .new import description, templates

SCHEMA = Path(__file__).resolve().parents[2] / "modelfile" / "model.schema.json"
# Words that users search for, by command of a group; those of whole commands are in the registry.
SUBCOMMANDS = {
    "study tolerance": "scatter deviation miss target spread yield quantile monte carlo limit reject",
    "study indices": "sobol morris sensitivity variance",
    "study allocate": "ISO 286 fit tolerance cost cheapest",
    "study plot": "heat map pareto parallel",
    "study export": "excel csv parquet spreadsheet data",
    "map sweep": "bifurcation lyapunov speed sweep diagram",
    "map section": "poincare chaos attractor stroboscopic return",
    "map basins": "basin attraction attractor start",
    "fit measured": "rig data",
}
# Pages of the documentation by file: title, and words that users search for.
PAGES = {
    "zero": ("From zero to a design answer", "tutorial example begin compressor clearance"),
    "first-run": ("Reading a run", "summary ideal force begin blow knock motor flywheel torque rms size"),
    "install": ("Installation", "pip windows conda linux macos licence"),
    "designer": (
        "For the designer",
        "pressure loss efficiency shaking stroke dead centre stress measure design dry friction whirl",
    ),
    "study": ("Studies", "sweep parameter monte carlo speed"),
    "tolerance": ("Tolerances, fits, optimisation", "ISO 286 scatter allocation cost pareto"),
    "sensitivity": ("Sensitivities", "derivative gradient influence"),
    "wear": ("Wear", "life archard durability"),
    "spectra": (
        "Noise and vibration",
        "FFT spectrum frequency order modes waterfall resonance decibel dB level sound pressure",
    ),
    "fit": ("Identification", "measured calibrate fit parameter"),
    "live": ("Live pages", "browser editor"),
    "model-file": ("Model file", "toml unit body joint driver load csv table top dead centre crank angle"),
    "model-reference": ("Every key of a model file", "key unit limit default"),
    "statics": ("Statics", "static deflection buckling frame beam mesh relaxation"),
    "researcher": ("For the researcher", "own law section paper cite citation"),
    "motion": ("Periodic or chaotic", "bifurcation poincare lyapunov chaos basin"),
    "trust": (
        "How far a run can be trusted",
        "error accuracy uncertainty range step convergence exit code shock mesh damaged file",
    ),
    "method": ("Method", "VFIFE central difference integration algorithm explicit event"),
    "laws": ("Laws", "contact friction hertz restitution damping film"),
    "laws-gallery": ("The laws in pictures", "contact friction plot"),
    "accuracy": ("Accuracy", "error convergence"),
    "verification": ("Verification", "exact reference benchmark"),
    "measured": ("Comparison with measurements", "experiment validation"),
    "programmer": ("For the programmer", "python api controller script notebook"),
    "commands": ("Commands", "option reference command line"),
    "paper": ("The paper, recomputed", "publication source"),
}
# Words with the same meaning to a reader.
SYNONYMS = tuple(
    frozenset(group.split())
    for group in (
        "clearance play backlash gap slop looseness loose",
        "knock impact rattle collision hit strike bounce",
        "noise sound acoustic loud",
        "life lifetime durability endurance worn abrasion wear",
        "chaos chaotic nonlinear strange attractor bifurcation lyapunov poincare",
        "frequency resonance eigenfrequency eigenvalue modal mode",
        "fft fourier spectrum harmonic order",
        "speed rpm velocity",
        "excel spreadsheet xlsx csv table",
        "film movie video animation mp4 gif",
        "picture figure image diagram plot draw chart graph",
        "tolerance scatter iso fit",
        "target limit aim",
        "optimise optimize optimisation optimization best minimum",
        "calibrate identify identification estimate measurement measured",
        "uncertainty error accuracy trust reliable range",
        "lubrication film oil hydrodynamic",
        "simulate simulation solve run",
        "resume continue restart interrupted",
    )
)
# Words that users search for, by the last name of a key of a model.
KEY_WORDS = {
    "table": "csv excel pressure",
    "pressure": "gas cylinder indicator diagram absolute gauge vacuum",
    "ambient": "atmosphere absolute gauge vacuum barg",
    "zero_travel": "top bottom dead centre center tdc bdc stroke",
    "reverse": "top bottom dead centre center tdc bdc",
    "bore": "cylinder piston diameter",
    "clearance": "fit ISO 286",
    "driver": "motor drive actuator",
    "torque": "motor power",
    "speeds": "motor curve characteristic",
    "bearing": "bush housing",
    "journal": "shaft pin",
    "gravity": "weight",
    "mass": "weight",
    "start_inertia": "flywheel gear",
    "end_inertia": "flywheel gear",
    "points": "cam groove",
    "elements": "mesh",
    "kind": "external",
    "journal_radius": "external contact floor wall",
}
# Endings of measures by the words that find them.
MEASURE_WORDS = {
    "noise knock": ("approach_speed.max", "impacts", "impact_power.mean"),
    "motor size rating": (
        "torque.max",
        "torque.rms",
        "power.mean",
        "actuator_force.max",
        "actuator_power.mean",
    ),
    "flywheel inertia uniformity fluctuation": ("energy_fluctuation",),
    "top bottom dead centre center tdc bdc stroke end travel slider": ("position.low", "position.high"),
}
# Measures that only a static analysis has: what they are, and words that find them.
STATIC_MEASURES = {
    "displacement.max": (
        "in a static analysis, largest distance from the start of the centre of mass of a rigid body, of the"
        " ends of a two-particle link and of the nodes of an elastic body, in m",
        "deflection sag shift statics verschiebung",
    ),
    "unbalanced.max": ("in a static analysis, largest unbalanced force over the largest force, a number", ""),
}
# German words of the field, without accents, and what they are called here.
GERMAN = dict(
    re.findall(
        r"(\w+)\s+(\w+)",
        """
    anschlag stop, antrieb driver, arbeit energy, balken beam, befehl command, beispiel example, bericht
    report, beschleunigung acceleration, bild picture, bohrung bore, bolzen pin, buchse bearing, dampfung
    damping, daten data, dichte density, drehmoment torque, drehzahl speed, druck pressure, durchmesser
    diameter, eigenfrequenz modes, einheit unit, elastizitatsmodul modulus, empfindlichkeit sensitivity,
    energie energy, feder spring, fehler error, film film, frequenz frequency, fuhrung guide, gas gas,
    gelenk joint, genauigkeit accuracy, gerausch noise, geschwindigkeit velocity, getriebe mechanism,
    gleiten sliding, grenze limit, harte hardness, hub stroke, indikatordiagramm indicator, knicken
    buckling, kolben piston, kontakt contact, koppel link, kosten cost, kraft force, kurbel crank, kurve
    curve, lager bearing, lange length, larm noise, last load, lebensdauer life, leistung power, masse mass,
    messung measured, moment moment, ol oil, optimierung optimise, passung fit, pleuel link, reibung
    friction, reibwert friction, resonanz resonance, schlag impact, schmierung lubrication, schritt step,
    schub force, schwingung vibration, spannung stress, spektrum spectrum, spiel clearance, stahl steel,
    steifigkeit stiffness, stoss impact, streuung scatter, studie study, tabelle csv, toleranz tolerance,
    totpunkt dead, tragheit inertia, umdrehung turn, vergleich compare, verlust loss, verschleiss wear,
    vorlage template, weg travel, welle shaft, werkstoff material, winkel angle, wirkungsgrad efficiency,
    zahnrad gear, zapfen journal, zeit time, zylinder cylinder
""",
    )
)
STATISTICS = {"max": "largest", "mean": "mean", "total": "total", "low": "least", "high": "largest"}
FIT = re.compile(r"\b[A-Za-z]{1,2}[0-9]{1,2}\b")  # a zone of ISO 286, as H7 or g6
KEY, MODEL = "key of a model", "model to start from"
NAME, WORDS, TEXT, SYNONYM = 8.0, 5.0, 2.0, 0.4  # weight of a word by the place in which it is found
STEM = 4  # letters from which on the beginning of a word finds it
COMMON = frozenset(
    ("a", "an", "and", "at", "by", "for", "from", "in", "is", "it", "of", "on", "or", "the", "to", "with")
)


@dataclass(frozen=True)
class Topic:
    """Something that a search may find: its ``kind`` (heading of the answer), ``name`` as it is typed, a
    sentence, and words that find it.
    """

    kind: str
    name: str
    text: str
    words: str = ""

    def score(self, query: Iterable[str], part: bool = False) -> float:
        """Return how well the topic answers all of these words; 0 if one is absent, or with ``part`` if all
        are.
        """
        fields = ((NAME, self.name), (WORDS, self.words), (TEXT, self.text))
        weights = [
            (weight / len(tokens(text)) ** 0.2, token) for weight, text in fields for token in tokens(text)
        ]
        best = [
            max((weight * likeness(word, token) for weight, token in weights), default=0.0) for word in query
        ]
        return sum(best) if part or all(best) else 0.0


@cache
def tokens(text: str) -> tuple[str, ...]:
    """Return the words of a text: lower case, without accents and plural endings."""
    bare = unicodedata.normalize("NFKD", text.replace("ß", "ss")).encode("ascii", "ignore").decode().lower()
    words = [re.sub(r"ies$", "y", word) for word in re.findall(r"[a-z0-9]+", bare)]
    return tuple(
        word[:-1] if len(word) > STEM and word.endswith("s") and not word.endswith("ss") else word
        for word in words
        if word not in COMMON
    )


@cache
def likeness(word: str, token: str) -> float:
    """Return how alike two words are: 1 if equal, less for a beginning or a synonym, 0 if they differ."""
    if word == token:
        return 1.0
    if len(word) >= STEM and token.startswith(word):
        return 0.7
    return SYNONYM if any(word in group and token in group for group in SYNONYMS) else 0.0


def commands() -> Iterator[Topic]:
    """Yield all commands, and those of groups."""
    purposes = {name: purpose for purpose, group in PURPOSES.items() for name in group}
    for name, entry in COMMANDS.items():
        yield Topic("command", name, entry.aim, f"{entry.words} {purposes[name]}")
        for part, subcommand in getattr(load_command(name), "commands", {}).items():
            sentence = (subcommand.help or "").split("\n\n")[0]
            yield Topic("command", f"{name} {part}", sentence, SUBCOMMANDS.get(f"{name} {part}", ""))


def options() -> Iterator[Topic]:
    """Yield all options with the commands that have them."""
    owners: dict[tuple[str, str], list[str]] = {}
    for name in COMMANDS:
        command = load_command(name)
        parts = {
            f"{name} {part}": subcommand for part, subcommand in getattr(command, "commands", {}).items()
        }
        for words, subcommand in ({name: command} | parts).items():
            for option in subcommand.params:
                longest = max(option.opts, key=len)
                if longest.startswith("--") and longest != "--help":
                    owners.setdefault((longest, str(option.help)), []).append(words)
    for (longest, text), names in owners.items():
        listed = ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
        yield Topic("option", longest, f"{text} [{listed}]")


def laws() -> Iterator[Topic]:
    """Yield all contact and friction laws, with the names of their parameters."""
    for law in described():
        parameters = " ".join(parameter["name"] for parameter in law["parameters"])
        yield Topic("law", law["name"], f"{law['kind']}: {law['formula']}", parameters)


def measures() -> Iterator[Topic]:
    """Yield all measures of a run by the endings of their names, and those of a static analysis."""
    for name, (text, words) in STATIC_MEASURES.items():
        yield Topic("measure", name, text, words)
    for ending, unit in UNITS.items():
        words = next((words for words, endings in MEASURE_WORDS.items() if ending in endings), "")
        quantity, _, statistic = ending.rpartition(".")
        text = f"{STATISTICS[statistic]} {quantity}" if statistic in STATISTICS else ending
        text = text.replace("_", " ").replace(".", " ")
        yield Topic("measure", f"*.{ending}", f"{text}, {f'in {unit}' if unit != '1' else 'a number'}", words)


def keys() -> Iterator[Topic]:
    """Yield the tables and keys of a model file."""
    root = json.loads(SCHEMA.read_text(encoding="utf-8"))

    def inside(node: Any, path: tuple[str, ...], behind: tuple[str, ...]) -> Iterator[Topic]:
        name = node.get("$ref", "").rpartition("/")[2]
        if name and name not in behind:
            yield from inside(root["definitions"][name], path, (*behind, name))
        for choice in (*node.get("oneOf", ()), *node.get("anyOf", ())):
            yield from inside(choice, path, behind)
        if isinstance(entry := node.get("additionalProperties"), dict):
            yield from inside(entry, (*path, "NAME"), behind)
        for key, value in node.get("properties", {}).items():
            text = value.get("description", "")
            yield Topic(KEY, ".".join((*path, key)), text, KEY_WORDS.get(key, ""))
            yield from inside(value, (*path, key), behind)

    merged: dict[str, Topic] = {}  # kinds of drivers, joints or loads may have keys of one name
    for topic in inside(root, (), ()):
        former = merged.get(topic.name, topic).text
        text = former if topic.text in former else f"{former}; {topic.text}"
        merged[topic.name] = replace(topic, text=text)
    yield from merged.values()


def models() -> Iterator[Topic]:
    """Yield the models that ``vfife new`` writes."""
    for name, path in templates().items():
        yield Topic(MODEL, name, description(path))


def pages() -> Iterator[Topic]:
    """Yield the pages of the documentation."""
    for file, (title, words) in PAGES.items():
        yield Topic("page", f"{file}.html", title, words)


def topics() -> Iterator[Topic]:
    """Yield everything that can be searched for, commands first."""
    for source in (commands, models, options, laws, measures, keys, pages):
        yield from source()


def search(text: str, part: bool = False) -> list[Topic]:
    """Return the topics that contain all words of a text (with ``part``, some), or words with the same
    meaning, the best first.
    """
    query = tokens(text)
    scores = [(topic.score(query, part), topic) for topic in topics()] if query else []
    return [topic for score, topic in sorted(scores, key=lambda pair: -pair[0]) if score > 0.0]


def in_english(text: str) -> str:
    """Return the words of a text with German ones translated; of a compound its last known part counts."""
    words = []
    for token in tokens(text):
        parts = [german for german in GERMAN if token.endswith(german)] or [
            german for german in GERMAN if token.startswith(german) and len(german) >= STEM
        ]
        words.append(GERMAN[max(parts, key=len)] if parts else token)
    return " ".join(words)


def vocabulary() -> set[str]:
    """Return all words by which a topic can be found."""
    words = {word for topic in topics() for part in (topic.name, topic.words) for word in tokens(part)}
    return words.union(*SYNONYMS)


KINDS = ("command", MODEL, "option", "measure", KEY, "law", "page")  # in the order of an answer
PREFIXES = {"command": "", MODEL: "new "}  # of kinds whose names are typed as commands
MOST_TOPICS = 6  # topics of each kind in an answer


def help_(options: HelpOptions) -> None:
    """Run ``vfife help``."""
    text = " ".join(options.words or ())
    if not text:
        data = {
            purpose: {name: entry.aim for name, entry in group.items()} for purpose, group in PURPOSES.items()
        }
        answer(Document([purposes()], data=data), options.as_json)
        return
    queries = dict.fromkeys((text, FIT.sub("ISO 286 fit", text), in_english(text)))
    for part in (False, True):
        for query in queries:
            if (hits := search(query, part)) and not (part and len(tokens(query)) == 1):
                answer(document(query, hits, part), options.as_json)
                return
    words = vocabulary()
    suggestions = [
        match for token in tokens(text) for match in difflib.get_close_matches(token, words, 3, 0.6)
    ]
    advice = f"did you mean {' or '.join(suggestions)}?" if suggestions else "try another word."
    fail(f"nothing found for {text!r}; {advice} All commands: {command()} help")


def purposes() -> Table:
    """Return the purposes of all commands in the order of work."""
    rows = [
        (purpose if k == 0 else "", f"{command()} {name}", entry.aim)
        for purpose, group in PURPOSES.items()
        for k, (name, entry) in enumerate(group.items())
    ]
    return Table(("purpose", "command", "what for"), rows, names=(0, 1))


def document(text: str, hits: Sequence[Topic], part: bool = False) -> Document:
    """Return a document of the topics that a search found, in a table of each kind; with ``part``, no topic
    has all words.
    """
    tables: list[Any] = [Paragraph(f"Nothing has all words of {text!r}. Topics with one of them:")] * part
    # A key comes before commands if words that are chosen for it make it a better topic, as a table for csv.
    best = next(
        (topic for topic in hits if topic.kind in KINDS[:1] or (topic.kind == KEY and topic.words)), None
    )
    leading = KINDS[0] if best is None else best.kind
    for kind in sorted(KINDS, key=lambda kind: kind != leading):
        entries = [topic for topic in hits if topic.kind == kind]
        if not entries:
            continue
        rows = [
            (f"{command()} {PREFIXES[kind]}{topic.name}" if kind in PREFIXES else topic.name, topic.text)
            for topic in entries[:MOST_TOPICS]
        ]
        heading = f"{kind}, {MOST_TOPICS} of {len(entries)}" if len(entries) > MOST_TOPICS else kind
        tables.append(Table((heading, "what it is"), rows, names=(0,)))
    first = next((topic.name for topic in hits if topic.kind == "command"), "")
    hint = [Paragraph(f"Arguments and options: {command()} {first} --help")] if first else []
    if not first and any(topic.kind == MODEL for topic in hits):
        hint = [Paragraph(f"Write a model with: {command()} new NAME -o FILE")]
    data = [{"kind": topic.kind, "name": topic.name, "text": topic.text} for topic in hits]
    return Document([*tables, *hint], f"vfife help {text}", data)
