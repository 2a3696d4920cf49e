"""``vfife check``: what would run, and what it would cost."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, ModelArgument, SetOption, overrides, read_model
from .terminal import amount_of_bytes, grid, output, print_json, row, sentences, span

if TYPE_CHECKING:
    from rich.console import Console

    from ..model.mechanism import Mechanism


LongOption = Annotated[
    bool, typer.Option("--long", help="With all that was filled in by default, all limits of the step, and all rows of long tables.")
]
LIMITS = 3  # of the step that are told at once
ROWS = 30  # of a table


def check(model: ModelArgument, set_: SetOption = None, laws: LawsOption = None, long: LongOption = False, as_json: JsonOption = False) -> None:
    """What would run: bodies, joints, masses, degrees of freedom, step, cost in steps, time and bytes.

    Nothing of the run itself is computed; the ideal mechanism is, for the forces that the joints have to expect.
    """
    with sentences(str(model)):
        found = examine(model, set_, laws)
    if as_json:
        print_json(found)
    else:
        show(output(), found, long)


def examine(model: Path, texts: list[str] | None, laws: list[Path] | None = None) -> dict[str, Any]:
    """Everything that is known before a run."""
    mechanism = read_model(model, texts, laws)
    from ..assembly.assemble import assemble
    from ..assembly.possible import outlook
    from ..assembly.timestep import CONTACT_STEPS
    from ..job.cost import BRIEF, run_cost
    from ..report import described
    from ..simulation import expected_forces, first_contact_steps, ideal_of, referred, repeated
    from ..solvers.companions import number
    from ..solvers.transient import choose_loop
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


def show(console: Console, found: Mapping[str, Any], long: bool = False) -> None:
    """The same for people."""
    from rich.text import Text

    console.print(Text.assemble((found["model"], "bold"), f"  ({found['file']})"))
    for note in (found["note"], *found["notes"]):
        if note:
            console.print(Text(note.strip(), style="yellow"))
    console.print()
    most = None if long else ROWS
    show_bodies(console, found["bodies"], most)
    show_joints(console, found["joints"], most)
    show_couplings(console, found["couplings"])
    for name, words in found.get("laws", {}).items():
        console.print(Text(f"Law {name} of your own: {words}."))
    lasting = (*statics(found), *told(found["estimate"])) if found["load_factors"] else (*steps(found, long), *cost(found))
    for sentence in (*freedom(found["degrees_of_freedom"]), *lasting):
        console.print(Text(sentence))
    if long:
        show_defaults(console, found["defaults"])
    elif found["defaults"]:
        console.print(Text(f"{len(found['defaults'])} values that the file does not give are taken by default; --long lists them."))


def show_bodies(console: Console, bodies: list[dict[str, Any]], most: int | None = None) -> None:
    """Table of bodies, the first ``most`` of them."""
    table = grid("body", "model", "mass, kg", "inertia, kg m²", "centre of mass, m", "driver", right=(2, 3))
    for body in bodies[:most]:
        elements = f", {body['elements']} elements" if body["elements"] > 1 else ""
        center = f"({body['center'][0]:.6g}, {body['center'][1]:.6g})"
        row(
            table,
            body["name"],
            body["model"] + elements,
            f"{body['mass']:.6g}",
            f"{body['inertia']:.6g}",
            center,
            body["driver"] or "",
        )
    console.print(table)
    left_out(console, len(bodies), most, "bodies")


def left_out(console: Console, count: int, most: int | None, what: str) -> None:
    """A line on what a table does not list."""
    if most is not None and count > most:
        console.print(f"and {count - most:,} more {what}; --long lists them.\n", highlight=False)


def show_joints(console: Console, joints: list[dict[str, Any]], most: int | None = None) -> None:
    """Table of joints, the first ``most`` of them, then the laws of those with clearance; joints with the same laws share their lines."""
    from rich.text import Text

    table = grid("joint", "kind", "bearing", "journal", "clearance, mm", "radius, mm", "ideal force, N", right=(4, 5, 6))
    laws: dict[str, list[str]] = {}
    for k, joint in enumerate(joints):
        clear = "contact" in joint
        sizes = [f"{1e3 * joint[key]:.6g}" if key in joint else "" for key in ("clearance", "bearing_radius")]
        force = "" if joint["expected_force"] is None else f"{joint['expected_force']:.5g}"
        if most is None or k < most:
            row(table, joint["name"], joint["kind"], joint["bearing"], joint["journal"], *sizes, force)
        for kind in ("contact", "friction") if clear else ():
            laws.setdefault(law(kind, joint[kind]), []).append(joint["name"])
        for side, entry in joint.get("wear", {}).items():
            laws.setdefault(wears(side, entry), []).append(joint["name"])
    console.print(table)
    left_out(console, len(joints), most, "joints")
    for text, names in laws.items():
        console.print(Text(f"{', '.join(names[:most])}{'' if most is None or len(names) <= most else ', ...'}: {text}"))
    if laws:
        console.print()


def show_couplings(console: Console, couplings: list[dict[str, str]]) -> None:
    """Table of gears, springs and drivers with a name of their own."""
    if not couplings:
        return
    table = grid("name", "what", "acts on")
    for one in couplings:
        row(table, one["name"], one["what"], one["first"] + (f" and {one['second']}" if one["second"] else ""))
    console.print(table)


def law(kind: str, entry: Mapping[str, Any]) -> str:
    """A law in words: what is set, and what follows from it and the surfaces."""
    given = ", ".join(f"{name} {points(value) or shown(value)}" for name, value in entry["parameters"].items() if value is not None)
    derived = [f"{name} {with_unit(value, entry['units'].get(name, ''))}" for name, value in entry["derived"].items()]
    if "modulus" in entry:
        derived += [f"exponent {entry['exponent']:.4g}", f"composite modulus E* {1e-9 * entry['modulus']:.4g} GPa"]
    return f"{kind} {entry['law']}" + (f" ({given})" if given else "") + (f"; {', '.join(derived)}" if derived else "")


def wears(side: str, entry: Mapping[str, Any]) -> str:
    """How a surface wears, and how much it has."""
    pair = f", {entry['pair']} ({entry['source']}) over its hardness" if "pair" in entry else ""
    worn = f"; worn already, up to {1e6 * entry['worn']:.4g} µm" if "worn" in entry else ""
    return f"{side} wears by {entry['coefficient']:.4g} 1/Pa{pair}{worn}"


def points(value: Any) -> str:
    """A curve by its number of points and its last one; nothing of other values."""
    curve = isinstance(value, list | tuple) and len(value) > 0 and isinstance(value[-1], list | tuple)
    return f"{len(value)} points up to {value[-1][1]:.4g} N at {value[-1][0]:.4g} m" if curve else ""


def with_unit(value: str, unit: str) -> str:
    """A number with its unit, if it has one."""
    return value if unit in ("", "1") else f"{value} {unit}"


def freedom(found: Mapping[str, Any]) -> list[str]:
    """Degrees of freedom in words."""
    lines = [f"Degrees of freedom with ideal joints: {found['free']}; {found['after_drives']} with the drivers at work."]
    if found["redundant"]:
        count, named = found["redundant"], ", ".join(found["redundant_joints"])
        many = f"{count} redundant constraint{'s' * (count > 1)}, at {named}"
        lines.append(f"{many}: rigid links do not determine how these joints share their load.")
    if found["shared"]:
        lines.append(f"Shared by least norm, not unique: {', '.join(found['shared'])}.")
    if found["singular"]:
        lines.append(
            f"The start is a singular position (a change point or dead centre), at {', '.join(found['singular'])}: beside it these hold "
            "something of their own. The branch that the motion takes from here is not determined; start a little aside."
        )
    if found["blocked"]:
        lines.append("A motion that the joints allow leads nowhere: links lie in line, where no force along them holds anything across.")
    if found["four_bar"]:
        lines.append(f"Four-bar: {found['four_bar']}.")
    return lines


def steps(found: Mapping[str, Any], long: bool = False) -> list[str]:
    """The step and its limits in words."""
    step = found["step"]
    endless = step["stable"] == float("inf")
    how = (
        f"chosen; set by {step['set_by']}" + ("; a run halves it while runs with other step sizes disagree" if step["searched"] else "")
        if step["automatic"]
        else "as given"
        if endless
        else f"as given; the stable one is set by {step['set_by']}"
    )
    turns = f" = {found['turns']:.6g} turns" if found["turns"] else ""
    until = f", or less: until turns repeat within {100.0 * found['settle']:.3g} %" if found["settle"] else ""
    limits = sorted(step["limits"].items(), key=lambda item: float(item[1]))
    told = limits if long or len(limits) <= LIMITS + 1 else limits[:LIMITS]
    more = [f"  and {len(limits) - len(told)} larger ones (--long)"] if len(told) < len(limits) else []
    return [
        f"Step {step['size']:.4g} s, {how}.",
        "There is no largest stable step: nothing here limits it but accuracy."
        if endless
        else f"The largest stable step is {step['stable']:.4g} s:",
        *(f"  {value:.4g} s  {name}" for name, value in told),
        *more,
        f"{found['steps']:,} steps make {found['duration']:.6g} s{turns}{until}; an output every {found['steps_between_outputs']:,} steps.",
    ]


def statics(found: Mapping[str, Any]) -> list[str]:
    """What a static analysis goes through, in words."""
    factors = found["load_factors"]
    again = ", other numbers of elements with it" if found["repeated"] else "; errors of the mesh are not estimated"
    lasting = (
        f"Time, a rough estimate: {span(found['estimate']['seconds'])}{again}; each equilibrium ends after {found['iterations']:,} iterations."
    )
    if len(factors) == 1:
        return [f"Static analysis: equilibrium under load factor {factors[0]:g}, by dynamic relaxation.", lasting]
    return [
        f"Static analysis: equilibria under {len(factors)} load factors from {factors[0]:g} to {factors[-1]:g}, by dynamic relaxation.",
        lasting,
    ]


def cost(found: Mapping[str, Any]) -> list[str]:
    """What it costs, in words."""
    from ..job.cost import BRIEF, MOST_TRIES

    cost = found["estimate"]
    pace, compiling = f"{cost['ns_per_step']:.0f} ns a step, {cost['loop']} loop", span(cost["compile_seconds"])
    again = f"; {span(MOST_TRIES * cost['seconds'])} if the step has to be halved twice" if found["step"]["searched"] else ""
    again += "; half and a quarter of the step with it, for the errors" if found["repeated"] else ""
    lines = [
        f"Time, an estimate from a table of costs: {span(cost['seconds'])} ({pace}){again},",
        f"  and some {compiling} to compile that loop if it was never used here.",
        f"The record takes {amount_of_bytes(cost['bytes'])}, which is packed to about half of it in the run file; to be read, it takes",
        f"  some {amount_of_bytes(cost['memory'])} of memory.",
    ]
    if cost["ideal_seconds"] > BRIEF:
        lines.append(f"The ideal mechanism alone takes {span(cost['ideal_seconds'])}: what forces its joints carry is told by the run.")
    return lines + told(cost)


def told(cost: Mapping[str, Any]) -> list[str]:
    """What vfife run asks about."""
    return [f"That is {cost['asks_for_yes']}: vfife run wants --yes for it."] if cost["asks_for_yes"] else []


def show_defaults(console: Console, defaults: list[dict[str, Any]]) -> None:
    """Table of what was filled in; bodies or joints that take the same value share a row."""
    if not defaults:
        return
    alike: dict[tuple[str, str, str], list[str]] = {}
    for entry in defaults:
        section, _, rest = entry["path"].partition(".")
        name, _, key = rest.partition(".") if rest.count(".") else ("", "", rest)
        unit = "" if entry["unit"] == "1" else f" {entry['unit']}"
        same = (f"{section}.*.{key}" if name else entry["path"], f"{shown(entry['value'])}{unit}", entry["meaning"])
        alike.setdefault(same, []).append(name)
    table = grid("filled in", "of", "value", "meaning", title="Not in the file, so taken by default")
    for (path, value, meaning), names in alike.items():
        row(
            table,
            path.replace("*", names[0]) if len(names) == 1 else path,
            ", ".join(names) if len(names) > 1 else "",
            value,
            meaning,
        )
    console.print(table)


def shown(value: Any) -> str:
    """A default as a model file has it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(shown, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
