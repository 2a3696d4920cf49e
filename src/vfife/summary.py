"""What a run came to, as one object for scripts and as tables for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .bodies import Link
from .laws import Law

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from .result import Result

LARGEST_ERROR = 1e-3  # of the energy ledger, beyond which a run is not to be trusted
MODES = ("free_flight", "impact", "continuous_contact")
JOINT_KEYS = ("force.max", "penetration.max", "impacts", "grazing", "deep", "deepest", *(f"share.{mode}" for mode in MODES))


def report(result: Result, reference: Result | None = None) -> dict[str, Any]:
    """All that the summary of a run says: texts, numbers, lists and dictionaries only.

    ``status``, ``step`` (s), ``steps``, ``wall_s``, ``ns_per_step``, ``energy_error`` and ``measures`` stand at the top; ``model``,
    ``run``, ``energy``, ``joints``, ``lip``, ``laws`` and ``warnings`` are what the tables of :func:`show` are made of. The reference is
    the result's own unless another one is given.
    """
    reference = reference if reference is not None else result.reference
    record, choice = result.record, result.record.assembly.choice
    done = int(record.steps[-1])
    measures = dict(result.measures)
    if reference is not None and reference is not result.reference:
        from .analysis import influence

        driven = [body.name for body in record.assembly.bodies.values() if body.driven is not None]
        measures |= influence(measures, reference.measures, driven)
    return {
        "status": record.status,
        "step": choice.step,
        "steps": done,
        "wall_s": record.wall,
        "ns_per_step": 1e9 * record.wall / done if done else 0.0,
        "energy_error": result.ledger.error,
        "model": _model(result, measures, reference),
        "run": _run(result),
        "energy": {"largest": result.ledger.largest, "end": {k: float(v[-1]) for k, v in result.ledger.terms.items()}},
        "joints": _joints(measures, reference),
        "lip": {name.removeprefix("lip."): value for name, value in measures.items() if name.startswith("lip.")},
        "laws": _laws(result),
        "warnings": list(warnings(result)),
        "measures": measures,
    }


def _model(result: Result, measures: dict[str, float], reference: Result | None) -> dict[str, Any]:
    mechanism = result.record.assembly.mechanism
    ideal = {} if reference is None else reference.measures
    bodies: dict[str, dict[str, Any]] = {}
    for name, where in result.record.assembly.bodies.items():
        noun = mechanism.bodies[name]
        bodies[name] = {"model": where.model, "elements": len(where.elements), "mass": where.mass, "inertia": where.inertia}
        bodies[name] |= {"driven": where.driven is not None, "release": noun.release if isinstance(noun, Link) else "none"}
        for key in ("angular_acceleration.max", "torque.max"):
            bodies[name] |= {key: measures.get(f"{name}.{key}"), f"ideal_{key}": ideal.get(f"{name}.{key}")}
    return {"name": mechanism.name, "note": " ".join(mechanism.note.split()), "source": mechanism.source, "bodies": bodies}


def _run(result: Result) -> dict[str, Any]:
    record, choice = result.record, result.record.assembly.choice
    time = float(result.time[-1])
    return {
        "loop": record.loop,
        "time_s": time,
        "turns": None if choice.turn is None else time / choice.turn,
        "outputs": len(record.steps),
        "automatic": choice.automatic,
        "stable_step": choice.stable if choice.stable < float("inf") else None,
        "set_by": choice.culprit,
        "notes": list(record.assembly.notes),
    }


def _joints(measures: dict[str, float], reference: Result | None) -> dict[str, dict[str, float | None]]:
    ideal = {} if reference is None else reference.measures
    names = [key.removesuffix(".force.max") for key in measures if key.endswith(".force.max")]
    found: dict[str, dict[str, float | None]] = {}
    for name in names:
        found[name] = {"ideal_force.max": ideal.get(f"{name}.force.max")}
        found[name] |= {key: measures[f"{name}.{key}"] for key in JOINT_KEYS if f"{name}.{key}" in measures}
    return found


def _laws(result: Result) -> dict[str, dict[str, Any]]:
    from .assemble import surfaces

    mechanism = result.record.assembly.mechanism
    found = {}
    for name, joint in mechanism.clearances.items():
        pair = surfaces(mechanism, joint)
        found[name] = {
            kind: {"law": law.name, "formula": law.formula, "source": law.source, "derived": law.derived(pair)}
            for kind, law in _named(("contact", joint.contact), ("friction", joint.friction))
        }
    return found


def _named(*laws: tuple[str, Law]) -> tuple[tuple[str, Law], ...]:
    return laws


def warnings(result: Result) -> Iterable[str]:
    """Sentences about what makes a run doubtful, each with what to do."""
    record, choice, measures = result.record, result.record.assembly.choice, result.measures
    if record.status != "complete":
        yield STATUS.get(record.status, f"The run is {record.status}.").format(time=float(result.time[-1]))
    if choice.step > choice.stable:
        yield (
            f"The step of {choice.step:.4g} s is larger than the stable one, {choice.stable:.4g} s ({choice.culprit}): "
            'take a smaller step, or "auto".'
        )
    for name, joint in record.assembly.mechanism.clearances.items():
        deep, all_of_them = int(measures.get(f"{name}.deep", 0)), int(measures.get(f"{name}.impacts", 0))
        if deep:
            yield (
                f"Joint {name}: {deep} of {all_of_them} first contacts landed deeper than {joint.landing * 1e6:.4g} µm, the deepest at "
                f"{measures[f'{name}.deepest'] * 1e6:.4g} µm, so their impact speeds are coarse: halve the step "
                f"({0.5 * choice.step:.3g} s), or raise landing_depth if that is deep enough to know."
            )
    if result.ledger.error > LARGEST_ERROR:
        yield (
            f"The energy ledger is open by {100.0 * result.ledger.error:.2g} % of the largest energy: take a smaller step and see "
            "whether it closes."
        )


STATUS = {
    "interrupted": "The run was interrupted at {time:.4g} s; what is told here is what was computed until then.",
    "unfinished": "The run ended at {time:.4g} s without saying so (it was killed, or is still at work); this is what it had written.",
    "diverged": "The numbers were no longer finite after {time:.4g} s: take a smaller step, and look at the model there.",
}

# ------------------------------------------------------------------------------------------------------------ for people


def show(console: Console, result: Result, reference: Result | None = None) -> None:
    """Prints the summary."""
    from rich.text import Text

    told = report(result, reference)
    model, run = told["model"], told["run"]
    console.print()
    console.print(Text(model["name"], style="bold"))
    if model["note"]:
        console.print(Text(model["note"], style="italic"))
    console.print(_facts(told))
    for text in run["notes"]:
        console.print(Text(text))
    if told["joints"]:
        console.print(_joint_table(told))
    if any("impacts" in joint for joint in told["joints"].values()):
        console.print(_contact_table(told))
    if any(body["angular_acceleration.max"] for body in model["bodies"].values() if not body["driven"]):
        console.print(_body_table(told))
    for text in told["warnings"]:
        console.print(Text.assemble(("Warning: ", "bold yellow"), text))


def _facts(told: dict[str, Any]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    for name, text in (
        ("Bodies", "; ".join(f"{name}: {_body(body)}" for name, body in told["model"]["bodies"].items())),
        ("Step", _step(told)),
        ("Run", _pace(told)),
        ("Energy", _energy(told)),
        *(("Driver", line) for line in _torques(told)),
        *(("Laws" if k == 0 else "", line) for k, line in enumerate(_law_lines(told))),
    ):
        table.add_row(Text(name, style="cyan"), Text(text))
    return table


def _body(body: dict[str, Any]) -> str:
    said = str(body["model"])
    if body["elements"] > 1:
        said += f", {body['elements']} elements"
    if body["release"] != "none" and body["elements"]:
        said += ", a bar" if body["release"] == "both" else f", released at its {body['release']}"
    return said + (", driven" if body["driven"] else "")


def _step(told: dict[str, Any]) -> str:
    run = told["run"]
    size = f"{told['steps']:,} steps of {prefixed(told['step'], 's')}"
    length = prefixed(run["time_s"], "s") + (f", {run['turns']:.4g} turns" if run["turns"] is not None else "")
    if run["automatic"]:
        return f"{size} ({length}), set by {run['set_by']}"
    stable = f"; stable below {prefixed(run['stable_step'], 's')} ({run['set_by']})" if run["stable_step"] else ""
    return f"{size} ({length}), as asked for{stable}"


def _pace(told: dict[str, Any]) -> str:
    return f"{told['status']}, {told['run']['loop']} loop, {prefixed(told['wall_s'], 's')}, {told['ns_per_step']:.4g} ns a step"


def _energy(told: dict[str, Any]) -> str:
    end, largest = told["energy"]["end"], told["energy"]["largest"]
    put_in = end["driver"] + end["external"]
    lost = {kind: end[f"{kind}_loss"] for kind in ("contact", "friction", "damping")}
    parts = ", ".join(f"{kind} {value:.4g}" for kind, value in lost.items() if value)
    return (
        f"put in {put_in:.5g} J, lost {sum(lost.values()):.5g} J{f' ({parts})' if parts else ''}, largest {largest:.5g} J; "
        f"ledger closes to {told['energy_error']:.1e} of it"
    )


def _torques(told: dict[str, Any]) -> Iterable[str]:
    for name, body in told["model"]["bodies"].items():
        if body["torque.max"] is not None:
            ideal = body["ideal_torque.max"]
            yield f"{name}: largest torque {body['torque.max']:,.1f} N m" + (f", ideal {ideal:,.1f} N m" if ideal is not None else "")


def _law_lines(told: dict[str, Any]) -> Iterable[str]:
    """Laws and what they derive from radii and materials, joints alike in one line."""
    lines: dict[str, list[str]] = {}
    for joint, laws in told["laws"].items():
        said = []
        for law in laws.values():
            numbers = ", ".join(f"{name} {value}" for name, value in law["derived"].items())
            said.append(law["law"] + (f" ({numbers})" if numbers else ""))
        lines.setdefault("; ".join(said), []).append(joint)
    for text, joints in lines.items():
        yield f"{', '.join(joints)}: {text}"


def _grid(title: str, *headings: str) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if k else "left")
    return table


def _joint_table(told: dict[str, Any]) -> Table:
    table = _grid(f"Largest reactions ({_over(told)})", "joint", "reaction", "ideal", "LIP(F)", "penetration")
    for name, joint in told["joints"].items():
        lip, depth, ideal = told["lip"].get(f"{name}.force"), joint.get("penetration.max"), joint["ideal_force.max"]
        table.add_row(
            name,
            f"{joint['force.max']:,.1f} N",
            "" if ideal is None else f"{ideal:,.1f} N",
            _percent(lip),
            "" if depth is None else prefixed(depth, "m"),
        )
    return table


def _contact_table(told: dict[str, Any]) -> Table:
    headings = ("free flight", "impact", "contact", "impacts", "grazing", "landed too deep", "deepest landing")
    table = _grid("Contact (whole run)", "joint", *headings)
    for name, joint in told["joints"].items():
        if "impacts" in joint:
            shares = (f"{100.0 * joint[f'share.{mode}']:.3g} %" for mode in MODES)
            counts = (f"{joint[kind]:.0f}" for kind in ("impacts", "grazing", "deep"))
            table.add_row(name, *shares, *counts, prefixed(joint["deepest"], "m"))
    return table


def _body_table(told: dict[str, Any]) -> Table:
    table = _grid(f"Largest angular accelerations ({_over(told)})", "body", "acceleration", "ideal", "LIP(a)")
    for name, body in told["model"]["bodies"].items():
        largest, lip = body["angular_acceleration.max"], told["lip"].get(f"{name}.angular_acceleration")
        if largest is not None and not body["driven"]:
            ideal = body["ideal_angular_acceleration.max"]
            table.add_row(name, f"{largest:,.1f} rad/s²", "" if ideal is None else f"{ideal:,.1f} rad/s²", _percent(lip))
    return table


def _percent(value: float | None) -> str:
    return "" if value is None else f"{value:.2f} %"


def _over(told: dict[str, Any]) -> str:
    return "last turn" if (told["run"]["turns"] or 0.0) >= 1.0 - 1e-9 else "whole run"


def prefixed(value: float, unit: str) -> str:
    """A quantity with a prefix that leaves one to three digits before the point."""
    size = abs(value)
    for factor, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")):
        if size >= factor and not (prefix == "k" and unit in ("s", "m")):
            return f"{value / factor:.4g} {prefix}{unit}"
    return f"{value:.4g} {unit}"
