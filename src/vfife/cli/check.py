"""``vfife check``: what would run, and what it would cost."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, ModelArgument, SetOption, overrides, read_model
from .terminal import answer, sentences

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

LongOption = Annotated[
    bool, typer.Option("--long", help="With all that was filled in by default, all limits of the step, and all rows of long tables.")
]


def check(model: ModelArgument, set_: SetOption = None, laws: LawsOption = None, long: LongOption = False, as_json: JsonOption = False) -> None:
    """What would run: bodies, joints, masses, degrees of freedom, step, cost in steps, time and bytes.

    Nothing of the run itself is computed; the ideal mechanism is, for the forces that the joints have to expect.
    """
    with sentences(str(model)):
        found = examine(model, set_, laws)
    from ..report.check import document

    answer(document(found, long), as_json)


def examine(model: Path, texts: list[str] | None, laws: list[Path] | None = None) -> dict[str, Any]:
    """Everything that is known before a run."""
    mechanism = read_model(model, texts, laws)
    from ..assembly.assemble import assemble
    from ..assembly.possible import outlook
    from ..assembly.timestep import CONTACT_STEPS
    from ..job.cost import BRIEF, run_cost
    from ..report import check as described
    from ..simulation import repeated
    from ..solvers.companions import number
    from ..solvers.transient import choose_loop
    from ..start import expected_forces, first_contact_steps, ideal_of, referred
    from .filled import filled_in

    seen = outlook(mechanism)
    ideal = ideal_of(mechanism) if seen.through else None
    long = ideal is not None and run_cost(ideal).seconds > BRIEF
    expected = {} if long else expected_forces(referred(ideal))
    begin = first_contact_steps(mechanism, mechanism.settings.companions)
    assembly = assemble(mechanism, expected=expected, contact_steps=begin)
    choice, again = assembly.choice, repeated(assembly, mechanism.settings.companions)
    companions = number(assembly, choose_loop(assembly, "auto"), mechanism.settings.companions)
    cost = run_cost(assembly, ideal, companions=companions, refined=again)
    return {
        "model": mechanism.name,
        "file": str(model),
        "note": mechanism.note,
        "bodies": described.bodies(assembly),
        "joints": described.joints(assembly, expected),
        "couplings": described.couplings(assembly),
        "degrees_of_freedom": described.freedom(assembly),
        "load_factors": list(mechanism.settings.load_factors) if mechanism.settings.analysis == "static" else [],
        "iterations": mechanism.settings.iterations,
        "step": described.step(assembly) | {"searched": assembly.choice.automatic and begin != CONTACT_STEPS},
        "steps": choice.steps,
        "outputs": choice.outputs + 1,
        "steps_between_outputs": choice.outputs_every,
        "duration": choice.steps * choice.step,
        "turns": choice.steps * choice.step / choice.turn if choice.turn else None,
        "settle": mechanism.settings.settle,
        "repeated": again,
        "estimate": dataclasses.asdict(cost) | {"asks_for_yes": cost.forecast(choice.steps).excess(Path())},
        "defaults": filled_in(model, overrides(texts)),
        "notes": [*assembly.notes, *seen.notes],
        **({"laws": compared_laws(mechanism)} if laws else {}),
    }


def compared_laws(mechanism: Mechanism) -> dict[str, str]:
    """In which loops laws of the user's own were compared with Python, by name."""
    from ..laws.check import comparison
    from ..model.surfaces import surfaces

    joints = mechanism.contacts.values()
    return comparison([(law, surfaces(mechanism, joint)) for joint in joints for law in (joint.contact, joint.friction)])
