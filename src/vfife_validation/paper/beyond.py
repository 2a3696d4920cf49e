"""What the paper could not show: how its results move with the step, the links, friction, the contact law and
the start.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vfife.laws import ContactLaw
from vfife.laws.contact.damping import DAMPING
from vfife.report.document import Table

from .contents import Chart, Item, Line, Panel, Verdict
from .context import described
from .influence import MOST_TURNS, STEP, Case, Influence
from .mechanisms import CLEARANCE, CLEARANCES, FASTEST, LINKS, SPEEDS, Parameters
from .search import GOAL, TABLE_3

if TYPE_CHECKING:
    from .context import Context

STEPS = (1.25e-6, 1e-6, 5e-7, 2.5e-7, 1.25e-7)  # s
ANGLES = 12  # of the crank at the start
DAMPED = "lankarani-nikravesh"  # the paper's damping, Eq. 26
MOST_NAMED = 8  # variants in a sentence
KEYS = [(c, FASTEST) for c in CLEARANCES] + [(CLEARANCE, speed) for speed in SPEEDS[:-1]]
SOFT_STEP = {
    "frames of 4": 5e-7,
    "frames of 8": 2.5e-7,
}  # s, of links whose elements ask for less than the contacts
CONCLUSIONS = ("contact kept", "LIPs rise with c", "LIPs fall with speed", "maxima rise with speed")


def damped_laws(p: Parameters) -> dict[str, ContactLaw]:
    """Every contact law of the package with a restitution, at that of the set; with the paper's damping where
    a law has a choice of it.
    """
    damped: dict[str, ContactLaw] = {}
    laws: list[tuple[str, Any]] = sorted(ContactLaw.registry.items())
    for name, kind in laws:
        fields = {f.name: f for f in dataclasses.fields(kind)}
        if "restitution" not in fields or not kind.__module__.startswith("vfife."):
            continue
        if any(
            f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
            for f in fields.values()
            if f.name != "restitution"
        ):
            continue  # it wants a number that no paper gives
        damped[name] = kind(
            restitution=p.contact.restitution,  # type: ignore[attr-defined]
            **({"damping": DAMPED} if "damping" in fields else {}),
        )
    return damped


def dampings(p: Parameters) -> dict[str, ContactLaw]:
    """Return the set's own law with every available damping, if the law offers a choice."""
    if not hasattr(p.contact, "damping"):
        return {}
    return {name: dataclasses.replace(p.contact, damping=name) for name in DAMPING}  # type: ignore[call-arg]


def groups(p: Parameters) -> dict[str, dict[str, Parameters]]:
    """Return the sets that differ from the best set in one respect, grouped by it."""
    return {
        "links": {link: dataclasses.replace(p, link=link) for link in LINKS},
        "friction": {
            "at the particles": dataclasses.replace(p, friction_moment="off"),
            "with moments, mid-overlap": dataclasses.replace(p, friction_moment="mid-overlap"),
            "with moments, surface": dataclasses.replace(p, friction_moment="surface"),
            "none": dataclasses.replace(p, friction=0.0),
        },
        "contact law": {name: dataclasses.replace(p, contact=law) for name, law in damped_laws(p).items()},
        "damping": {name: dataclasses.replace(p, contact=law) for name, law in dampings(p).items()},
        "branch": {
            "joint 2 below": dataclasses.replace(p, below=True),
            "joint 2 above": dataclasses.replace(p, below=False),
        },
    }


def beyond(context: Context) -> Item:
    """All variations, and which conclusions survive them."""
    p = context.parameters
    results = run_groups(context, groups(p))
    steps = run_steps(context)
    angles = run_angles(context)
    charts = [group_chart(name, runs) for name, runs in results.items()] + [angle_chart(angles)]
    tables = [group_table(name, runs) for name, runs in results.items()] + [step_table(steps)]
    data = {
        name: {label: [influence.lips for influence in runs] for label, runs in members.items()}
        for name, members in results.items()
    }
    text = [
        (
            "One thing is changed at a time in the set that fits Table 3. A conclusion survives a change if"
            " it still holds at all clearances and speeds. The contact laws are those that take a restitution"
            " coefficient, with the paper's damping where they have a choice."
        ),
        (
            "The start decides part of the settled motion: the damping of a contact that never ends is scaled"
            " by the speed of its onset (Eq. 26), so the way into contact is remembered for ever, and another"
            " start angle of the crank gives other local influence parameters."
        ),
    ]
    return Item("beyond", "Beyond the paper: what its results depend on", text, described(p), charts, tables,
                [*survival(results), *step_verdicts(steps), angle_verdict(angles)],
                data | {"start": angles_data(angles)})  # fmt: skip


def run_groups(
    context: Context, sets: Mapping[str, Mapping[str, Parameters]]
) -> dict[str, dict[str, list[Influence]]]:
    """Every set at the clearances and speeds of Sect. 5."""
    labels = [(group, label, p) for group, members in sets.items() for label, p in members.items()]
    cases = [Case(p, c, speed, SOFT_STEP.get(p.link, STEP)) for _, _, p in labels for c, speed in KEYS]
    done = context.influences(
        "beyond: links, friction, contact laws, branch", cases, turns=MOST_TURNS, outputs=180
    )
    results: dict[str, dict[str, list[Influence]]] = {}
    for k, (group, label, _) in enumerate(labels):
        results.setdefault(group, {})[label] = done[k * len(KEYS) : (k + 1) * len(KEYS)]
    return results


def conclusions(runs: Sequence[Influence]) -> list[bool]:
    """Which of the conclusions hold for runs at the keys."""
    sizes, speeds = runs[:3], [*runs[3:], runs[1]]
    up = np.diff([influence.lips for influence in sizes], axis=0)
    down = np.diff([influence.lips for influence in speeds], axis=0)
    largest = np.diff([(influence.force, influence.acceleration) for influence in speeds], axis=0)
    return [
        all(influence.keeps_contact for influence in runs),
        bool((up > 0).all()),
        bool((down < 0).all()),
        bool((largest > 0).all()),
    ]


def survival(results: Mapping[str, Mapping[str, Sequence[Influence]]]) -> list[Verdict]:
    """How many variants each conclusion survives."""
    survival = {
        f"{group}: {label}": conclusions(runs)
        for group, members in results.items()
        for label, runs in members.items()
    }
    verdicts = []
    for k, words in enumerate(CONCLUSIONS):
        failures = [label for label, results in survival.items() if not results[k]]
        numbers = f"{len(survival) - len(failures)} of {len(survival)} variants"
        numbers += (
            f"; not {'; '.join(failures)}"
            if 0 < len(failures) <= MOST_NAMED
            else "; see the tables"
            if failures
            else ""
        )
        verdicts.append(Verdict(f"Survives every change: {words}", not failures, numbers))
    return verdicts


def group_table(name: str, members: Mapping[str, Sequence[Influence]]) -> Table:
    """LIPs of a group, and what holds."""
    rows = []
    for label, runs in members.items():
        results = conclusions(runs)
        speeds = [*runs[3:], runs[1]]
        settled = sum(influence.run.settled is not None for influence in runs)
        rows.append([label, *(_triple([influence.lips[j] for influence in chosen]) for chosen in (runs[:3],
        speeds) for j in (0, 1)), f"{settled}/{len(runs)}",
                     *("yes" if h else "no" for h in results)])  # fmt: skip
    headings = [name, "LIP(F) at c", "LIP(a) at c", "LIP(F) at n", "LIP(a) at n", "settled", *CONCLUSIONS]
    return Table(
        headings,
        rows,
        f"{name.capitalize()}: at c = 0.1, 0.2, 0.5 mm (50π rad/s), and at n = 10π, 20π, 50π rad/s (0.2 mm);"
        " per cent",
    )


def _triple(values: Sequence[float]) -> str:
    return " ".join(f"{value:.1f}" if abs(value) < 1e4 else "–" for value in values)


def group_chart(name: str, members: Mapping[str, Sequence[Influence]]) -> Chart:
    """LIPs of a group over clearance and crank speed."""
    panels = []
    for j, kind in enumerate(("LIP(F)", "LIP(a)")):
        lines = [Line([1e3 * c for c in CLEARANCES], TABLE_3[j], "paper, Table 3", "paper")]
        lines += [
            Line(
                [1e3 * c for c in CLEARANCES],
                [_bounded(influence.lips[j]) for influence in runs[:3]],
                label,
                str(k),
            )
            for k, (label, runs) in enumerate(members.items())
        ]
        panels.append(Panel(f"{kind}, 50π rad/s", "clearance (mm)", f"{kind} (%)", lines))
    for j, kind in enumerate(("LIP(F)", "LIP(a)")):
        lines = [
            Line(
                [speed / math.pi for speed in SPEEDS],
                [_bounded(influence.lips[j]) for influence in [*runs[3:], runs[1]]],
                label,
                str(k),
            )
            for k, (label, runs) in enumerate(members.items())
        ]
        panels.append(Panel(f"{kind}, c = 0.2 mm", "crank speed (π rad/s)", f"{kind} (%)", lines))
    return Chart(
        f"beyond-{name.replace(' ', '-')}",
        f"{name.capitalize()}: local influence parameters over clearance and crank speed",
        panels,
        2,
    )


def _bounded(value: float) -> float:
    return value if abs(value) < 1e3 else math.nan


def run_steps(context: Context) -> dict[float, list[Influence]]:
    """Run the best set with several steps: the clearances of Table 3, and the slowest crank."""
    keys = [*KEYS[:3], (CLEARANCE, SPEEDS[0])]
    cases = [Case(context.parameters, c, speed, step) for step in STEPS for c, speed in keys]
    done = context.influences("beyond: steps", cases, outputs=200)
    return {step: done[len(keys) * k : len(keys) * (k + 1)] for k, step in enumerate(STEPS)}


def step_table(steps: Mapping[float, Sequence[Influence]]) -> Table:
    """LIPs of the best set over the step."""
    rows = [
        [f"{1e6 * step:g}", *(_triple([influence.lips[j] for influence in runs]) for j in (0, 1))]
        for step, runs in steps.items()
    ]
    caption = (
        "Step: the best set at c = 0.1, 0.2, 0.5 mm with 50π rad/s, then 0.2 mm with 10π rad/s; per cent"
    )
    return Table(["step (µs)", "LIP(F)", "LIP(a)"], rows, caption)


def step_verdicts(steps: Mapping[float, Sequence[Influence]]) -> list[Verdict]:
    """Whether the numbers are those of the equations, not of the step."""
    lips = np.array([[influence.lips for influence in runs] for runs in steps.values()])
    changes = np.abs(lips[1:] - lips[-1]).max(axis=(1, 2))
    numbers = ", ".join(
        f"{1e6 * step:g} µs: {value:.2f}" for step, value in zip(list(steps)[1:], changes, strict=True)
    )
    words = f"From 1 µs on the step moves no number by more than {GOAL / 2:g} points"
    return [Verdict(words, bool(changes.max() <= GOAL / 2), f"largest change from the last, {numbers}")]


def run_angles(context: Context) -> dict[float, list[Influence]]:
    """Run the best set from several start angles of the crank."""
    p = context.parameters
    angles = [2.0 * math.pi * k / ANGLES for k in range(ANGLES)]
    cases = [Case(dataclasses.replace(p, crank_angle=angle), c) for angle in angles for c in CLEARANCES]
    done = context.influences("beyond: start angles", cases, outputs=180)
    return {angle: done[3 * k : 3 * k + 3] for k, angle in enumerate(angles)}


def angle_chart(angles: Mapping[float, Sequence[Influence]]) -> Chart:
    """LIPs over the start angle."""
    degrees = [math.degrees(angle) for angle in angles]
    panels = []
    for j, kind in enumerate(("LIP(F)", "LIP(a)")):
        lines = [
            Line(
                degrees,
                [_bounded(runs[k].lips[j]) for runs in angles.values()],
                f"c = {1e3 * c:g} mm",
                str(k),
            )
            for k, c in enumerate(CLEARANCES)
        ]
        panels.append(Panel(kind, "crank angle at the start (degrees)", f"{kind} (%)", lines))
    return Chart("beyond-start", "The settled turn after starts at other crank angles, 50π rad/s", panels, 2)


def angles_data(angles: Mapping[float, Sequence[Influence]]) -> list[dict[str, Any]]:
    """Return the influences for all start angles as numbers for JSON."""
    return [
        {"start_degrees": math.degrees(angle), "lips": [influence.lips for influence in runs]}
        for angle, runs in angles.items()
    ]


def angle_verdict(angles: Mapping[float, Sequence[Influence]]) -> Verdict:
    """Whether the settled motion forgets its start."""
    lips = np.array([[influence.lips for influence in runs] for runs in angles.values()])
    spread = lips.max(axis=0) - lips.min(axis=0)
    numbers = "; ".join(
        f"c = {1e3 * c:g} mm: LIP(F) {spread[k, 0]:.1f}, LIP(a) {spread[k, 1]:.1f}"
        for k, c in enumerate(CLEARANCES)
    )
    return Verdict(
        "The settled turn does not depend on the start angle (within a point)",
        bool(spread.max() <= 1.0),
        f"spread over {len(lips)} starts, points: {numbers}",
    )
