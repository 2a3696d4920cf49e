"""``vfife check``: what would run, and what it would cost; what was filled in by default."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ...assembly.timestep import CONTACT_STEPS
from ...files import read_bytes
from ...job.cost import run_cost
from ...laws.check import comparison
from ...laws.law import LAWS
from ...model.mechanism import Mechanism
from ...model.readers import DEFAULTS
from ...model.surfaces import law_facts, surface_facts, surfaces
from ...modelfile.csvtables import expand
from ...modelfile.paths import override
from ...modelfile.reader import Written
from ...modelfile.tables import Table
from ...report import check as described
from ...report.check_page import document
from ...report.freedom import freedom
from ...report.loads import loads
from ...schema import Chosen, described_fields, meaning_of
from ...simulation.simulate import repeated
from ...simulation.start import examination
from ...solvers.companions import companion_count
from ...solvers.transient import choose_loop
from ..arguments.models import CheckOptions
from ..terminal import answer, sentences
from ..values import overrides, read_model, with_options


def check(options: CheckOptions) -> None:
    """Run ``vfife check``."""
    lengths = [("step", options.step), ("turns", options.turns)]
    changes = [f"run.{name}={value}" for name, value in lengths if value is not None]
    options.set_ = [*(options.set_ or ()), *changes] or None
    with sentences(str(options.model)):
        data = examine(options)
    answer(document(data, options.long), options.as_json)


def examine(options: CheckOptions) -> dict[str, Any]:
    """Everything that is known before a run."""
    mechanism = with_options(read_model(options.model, options.set_, options.laws), options)
    facts = examination(mechanism, options.force_step)
    assembly, expected = facts.assembly, facts.expected
    choice, refined = assembly.choice, repeated(assembly, mechanism.settings.companions)
    companions = companion_count(assembly, choose_loop(assembly, "auto"), mechanism.settings.companions)
    reader = reader_of(options.model, overrides(options.set_))
    count = mechanism.crank_turns(choice.turn, choice.steps * choice.step)
    cost = run_cost(assembly, facts.ideal, companions=companions, refined=refined)
    return {
        "model": mechanism.name,
        "file": str(options.model),
        "note": mechanism.note,
        "bodies": described.bodies(assembly),
        "joints": described.joints(assembly, expected),
        "couplings": described.couplings(assembly),
        "loads": loads(mechanism, facts.outlook.motion, facts.outlook.turn),
        **({} if mechanism.loads or mechanism.springs or any(mechanism.gravity) else {"unloaded": True}),
        "degrees_of_freedom": freedom(assembly),
        "load_factors": (
            list(mechanism.settings.load_factors) if mechanism.settings.analysis == "static" else []
        ),
        "iterations": mechanism.settings.iterations,
        "step": described.step(assembly)
        | {"searched": assembly.choice.automatic and facts.contact_steps != CONTACT_STEPS},
        "steps": choice.steps,
        "outputs": choice.outputs + 1,
        "steps_between_outputs": choice.outputs_every,
        "duration": choice.steps * choice.step,
        "turns": choice.steps * choice.step / choice.turn if choice.turn else None,
        **({} if count is None else {"crank_turns": count}),
        "settle": mechanism.settings.settle,
        "repeated": refined,
        "estimate": dataclasses.asdict(cost) | {"asks_for_yes": cost.forecast(choice.steps).excess(Path())},
        "defaults": defaults_of(reader, lengths(options)),
        "notes": [*assembly.notes, *facts.outlook.cautions, *unused_materials(reader)],
        "law_facts": list(law_facts(mechanism)),
        "surface_facts": list(surface_facts(mechanism)),
        **({"laws": compared_laws(mechanism)} if options.laws else {}),
    }


def compared_laws(mechanism: Mechanism) -> dict[str, str]:
    """In which loops laws of the user's own were compared with Python, by name."""
    joints = mechanism.contacts.values()
    return comparison(
        [(law, surfaces(mechanism, joint)) for joint in joints for law in (joint.contact, joint.friction)]
    )


DefaultRow = dict[str, Any]
LENGTHS = ("step", "turns", "duration", "companions")  # options that replace what a model file says


def lengths(options: CheckOptions) -> list[str]:
    """Paths of the settings that options replace."""
    return [f"run.{key}" for key in LENGTHS if getattr(options, key) is not None]


def reader_of(path: Path, items: Iterable[tuple[str, Any]]) -> Written:
    """Read a model file without faults, with values set by path; return its reader."""
    raw = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    _, values = override(raw, items)
    expand(raw, str(path))
    reader = Written(raw, values)
    reader.mechanism()
    return reader


def unused_materials(reader: Written) -> list[str]:
    """Return a remark on each material that the file defines and that nothing is made of."""
    return [
        f'Nothing is made of [material.{name}]: give a body material = "{name}", or a joint'
        " bearing_material or journal_material, or leave the table out."
        for name in reader.raw.get("material", {})
        if name not in reader.materials_used
    ]


def defaults_of(reader: Written, options: Iterable[str] = ()) -> list[DefaultRow]:
    """Return the keys that neither the file that was read, ``--set`` nor one of the ``options`` (paths)
    gives, with the value that is taken instead.
    """
    rows = list(left_out("", Table(Mechanism), reader.raw))
    for place, table, holder in sorted(reader.shapes, key=lambda shape: shape[0][0] not in ("run", "start")):
        if len(place) > 2:
            continue
        rows += left_out(".".join(map(str, place)), table, holder)
        for key in table.fields:
            if isinstance(choice := table.value(key), Chosen):
                rows += law(".".join(map(str, (*place, key))), choice.word, holder.get(key, {}))
    return [row for row in rows if row["path"] not in set(options)]


def left_out(path: str, table: Table, holder: dict[str, Any]) -> Iterator[DefaultRow]:
    """Keys with a default that a table leaves out; neither empty tables nor derived values."""
    if table.tag and table.optional and table.tag not in holder:
        yield {
            "path": f"{path}.{table.tag}",
            "value": table.word,
            "unit": "1",
            "meaning": f"the {table.tag} of it",
        }
    for key, field in table.fields.items():
        default = getattr(field.default_factory, "name", field.default)  # of a material, its name
        if (
            key not in holder
            and isinstance(default, str | float | int | tuple)
            and default not in ("", ())
            and not table.idle(key, holder)
        ):
            unit = getattr(table.value(key), "unit", "1")
            yield {
                "path": f"{path}.{key}".lstrip("."),
                "value": default,
                "unit": unit,
                "meaning": meaning_of(field, table.is_linear),
            }


def law(path: str, kind: str, values: dict[str, Any]) -> Iterator[DefaultRow]:
    """Yield the law and the law parameters that a joint leaves at their defaults."""
    name = values.get("law", DEFAULTS[kind].name)
    if "law" not in values:
        yield {"path": f"{path}.law", "value": name, "unit": "1", "meaning": f"{kind} law"}
    for field in described_fields(LAWS[kind].known()[name]):
        if field.name not in values and isinstance(field.default, str | float | int):
            yield {
                "path": f"{path}.{field.name}",
                "value": field.default,
                **{key: field.metadata[key] for key in ("unit", "meaning")},
            }
