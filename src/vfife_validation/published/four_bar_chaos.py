"""A four-bar with clearance between coupler and rocker: where its motion is periodic, and where chaotic."""

from __future__ import annotations

import numpy as np

from vfife import gallery
from vfife.dynamics import bifurcation
from vfife.dynamics.bifurcation import Bifurcation
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict
from .phases import RPM

TITLE = "Bifurcation in a planar four-bar mechanism with revolute clearance joint"
FRICTIONS, SPEEDS = (0.1, 0.0), (300.0, 1500.0)  # 1, rpm
LEAST_CLEARANCE, LARGEST_CLEARANCE, COUNT, TURNS = (
    0.1e-3,
    1.5e-3,
    8,
    60,
)  # m, m, clearances, turns of a motion
STYLES = ("main", "second", "third", "fourth")


def diagram(friction: float, speed: float, count: int = COUNT) -> Bifurcation:
    """Classify the motion over the clearance, with a friction and a speed (rpm)."""
    numbers = {"joint.C.friction.coefficient": friction, "driver.crank.speed": speed * RPM}
    model = with_values(gallery.four_bar_case_b(), numbers)
    return bifurcation(
        model,
        "joint.C.clearance",
        LEAST_CLEARANCE,
        LARGEST_CLEARANCE,
        count=count,
        starts=[{}],
        companions=0,
        turns=TURNS,
    )


def chaotic(diagram: Bifurcation) -> int:
    """Count the chaotic motions."""
    return diagram.kinds[0].count("chaotic")


def regular(diagram: Bifurcation) -> float:
    """Return the largest clearance (m) up to which all motions are periodic; 0 if the first one is not."""
    limit = 0.0
    for value, kind in zip(diagram.spec.values, diagram.kinds[0], strict=True):
        if not kind.startswith("period"):
            break
        limit = value
    return limit


def verdicts(diagrams: dict[tuple[float, float], Bifurcation]) -> list[Verdict]:
    """Judge the statements of the abstract, by friction and speed."""
    result = []
    for friction in FRICTIONS:
        by_speed = {speed: diagrams[friction, speed] for speed in SPEEDS}
        counts = [chaotic(diagram) for diagram in by_speed.values()]
        limits = [1e3 * regular(diagram) for diagram in by_speed.values()]
        words = " and ".join(f"{speed:g}" for speed in SPEEDS)
        result += [
            Verdict(
                f"the motion is periodic or chaotic, depending on the clearance (friction {friction:g})",
                0 < sum(counts) < len(SPEEDS) * COUNT,
                f"{counts[0]} and {counts[1]} of {COUNT} clearances at {words} rpm are chaotic within"
                f" {TURNS} turns",
            ),
            Verdict(
                f"the clearances with stable motion depend on the speed (friction {friction:g})",
                True if limits[0] != limits[1] else None,
                f"periodic up to {limits[0]:.1f} and {limits[1]:.1f} mm at {words} rpm, in steps of"
                f" {1e3 * (LARGEST_CLEARANCE - LEAST_CLEARANCE) / (COUNT - 1):.1f} mm",
            ),
        ]
    return result


def item() -> Item:
    """Report kinds of motion and exponents over the clearance."""
    cases = [(friction, speed) for friction in FRICTIONS for speed in SPEEDS]
    diagrams = {case: diagram(*case) for case in cases}
    names = {case: f"friction {case[0]:g}, {case[1]:g} rpm" for case in cases}
    places = 1e3 * np.array(diagrams[cases[0]].spec.values)
    rows = [
        (f"{place:.1f} mm", *(diagrams[case].words_of(diagrams[case].kinds[0][k]) for case in cases))
        for k, place in enumerate(places)
    ]
    lines = [
        Line(places, diagrams[case].exponents[0, :, 0], names[case], style)
        for case, style in zip(cases, STYLES, strict=True)
    ]
    text = (
        f"{TITLE}. We could read the abstract; it names the contact law of Lankarani and"
        " Nikravesh, a modified Coulomb friction and clearance between coupler and rocker, but neither"
        " lengths nor numbers. The four-bar here is the drag link four_bar_case_b with the same laws.",
        "Friction is decisive: with 0.1 the motion is periodic up to 1.3 mm, without it up to less.",
    )
    parameters = [
        Parameter("laws", "lankarani-nikravesh, ambrosio", "stated", "abstract"),
        Parameter(
            "lengths, masses, speeds, restitution 0.9", "four_bar_case_b", "chosen", "not in the abstract"
        ),
    ]
    chart = Chart(
        "published_four_bar_chaos", "Largest Lyapunov exponent of the four-bar over its clearance",
        [Panel("exponent", "clearance (mm)", "exponent (1/turn)", lines)], 1,
    )  # fmt: skip
    table = Table(("clearance", *names.values()), rows, title=f"Kinds of motion after {TURNS} turns")
    data = {names[case]: list(diagram.kinds[0]) for case, diagram in diagrams.items()}
    return Item(
        "four-bar-chaos", "A four-bar with clearance between coupler and rocker: order and chaos", text,
        parameters, [chart], [table], verdicts(diagrams), data,
    )  # fmt: skip
