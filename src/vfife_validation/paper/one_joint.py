"""Figs. 12-13: the four-bar with one loose joint, between coupler and follower."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from vfife.laws import LankaraniNikravesh, Pereira

from . import curves
from .contents import Chart, Item, Line, Panel, Parameter, Verdict
from .context import settling
from .influence import JOINT, Case, Influence, ideal
from .mechanisms import BEARING_RADIUS, FASTEST, JOURNAL_RADIUS, LINK_WORDS, STIFFNESS, Parameters

if TYPE_CHECKING:
    from .context import Context

GAP = BEARING_RADIUS - JOURNAL_RADIUS  # m
RESTITUTION = 0.9
LINK = "uniform rods"  # Sect. 4.2 calls the bodies rigid, and compares with a program of rigid bodies
SPHERE = LankaraniNikravesh(restitution=RESTITUTION, stiffness=STIFFNESS)


def variants(context: Context) -> dict[str, Parameters]:
    """Return the parameters of each run: two laws, with and without friction. The friction speeds are those
    inferred for Sect. 5.
    """
    p = context.parameters
    base = Parameters(
        link=LINK, below=True, contact=SPHERE, friction=0.0, v0=p.v0, v1=p.v1, axial_length=20e-3
    )
    enhanced = dataclasses.replace(base, contact=Pereira(restitution=RESTITUTION))
    return {
        "Lankarani–Nikravesh": base,
        "enhanced with friction": dataclasses.replace(enhanced, friction=p.friction),
        "enhanced without friction": enhanced,
        "Lankarani–Nikravesh with friction": dataclasses.replace(base, friction=p.friction),
    }


def runs(context: Context) -> dict[str, Influence]:
    """One loose joint under either law."""
    laws = variants(context)
    cases = [Case(p, GAP, FASTEST, 5e-7, "C") for p in laws.values()]
    done = context.compute_once(
        "one joint", lambda: context.influences("one clearance joint, Sect. 4.2", cases, turns=6)
    )
    return dict(zip(laws, done, strict=True))


def parameters_of(context: Context) -> list[Parameter]:
    """Parameters of both figures."""
    p = context.parameters
    return [
        Parameter("lengths and masses", "Table 1", "stated", "Table 1"),
        Parameter("links", LINK_WORDS[LINK], "stated", "Sect. 4.2: rigid bodies; uniform is chosen"),
        Parameter("clearance", "0.5 mm, R_B = 10 mm", "inferred", "radii of Sect. 4.1; Table 2 is lost"),
        Parameter(
            "stiffness K (Lankarani-Nikravesh)",
            "6.6e10 N/m^1.5",
            "inferred",
            "stated in Sect. 4.1 for the same radii",
        ),
        Parameter("crank speed", "50π rad/s", "chosen", "lost Table 2"),
        Parameter("restitution c_e", f"{RESTITUTION:g}", "chosen", "lost Table 2"),
        Parameter("axial length L (enhanced law)", "20 mm", "chosen", "lost Table 2"),
        Parameter(
            "friction (Fig. 13)",
            f"0.1; v0, v1 = {p.v0:.4g}, {p.v1:.4g} m/s",
            "inferred",
            "0.1 is stated in Sect. 5; speeds from the fit to Table 3",
        ),
        Parameter("step", "0.5 µs", "chosen", ""),
    ]


def fig12(context: Context) -> Item:
    """Follower's angular velocity and acceleration, journal path."""
    influence = runs(context)["Lankarani–Nikravesh"]
    reference = ideal(LINK, True, FASTEST)
    panels = [
        curves.compared_with_ideal(
            curves.velocity(influence.run),
            curves.velocity(reference),
            1.0,
            "(a)",
            "angular velocity of follower (rad/s)",
        ),
        curves.compared_with_ideal(
            curves.acceleration(influence.run),
            curves.acceleration(reference),
            1e-3,
            "(b)",
            "acceleration of follower (10³ rad/s²)",
        ),
    ]
    path = curves.path_panel(influence.run, JOINT, "(c) joint 2")
    w, ideal_w = curves.velocity(influence.run)[1], curves.velocity(reference)[1]
    difference = float(np.abs(w - ideal_w).max() / np.abs(ideal_w).max())
    verdicts = [
        Verdict(
            "The angular velocity stays close to the ideal one",
            difference < 0.05,
            f"largest difference {100 * difference:.2f} % of the largest",
        ),
        Verdict(
            "The acceleration has peaks far above the ideal one",
            influence.lips[1] > 10.0,
            f"LIP(a) {influence.lips[1]:.1f} %",
        ),
    ]
    text = [
        f"Lankarani-Nikravesh without friction. {settling(influence).capitalize()}. The paper compares with a"
        " published figure, of which nothing is in its text but that they agree, so nothing more can be"
        " checked here."
    ]
    charts = [
        Chart("fig12", "Follower with one loose joint over the last turn, and with ideal joints", panels, 2),
        Chart("fig12-path", "Journal centre in joint 2", [path], 1),
    ]
    data = {
        "lip_force": influence.lips[0],
        "lip_acceleration": influence.lips[1],
        "velocity_apart": difference,
    }
    return Item(
        "fig12",
        "Fig. 12: follower and journal with one loose joint",
        text,
        parameters_of(context),
        charts,
        [],
        verdicts,
        data,
    )


def fig13(context: Context) -> Item:
    """Force and penetration: the enhanced law with friction beside Lankarani-Nikravesh."""
    influences = runs(context)
    force, depth = [], []
    for name, style in (("Lankarani–Nikravesh", "second"), ("enhanced with friction", "main")):
        force.append(curves.over_angle(curves.force(influences[name].run), 1e-3, name, style))
        angle, values = curves.penetration(influences[name].run)
        depth.append(Line(angle, 1e6 * np.maximum(values, 0.0), name, style))
    deepest = {
        name: float(influence.run.turns.block("contact_penetration_max")[-1, 0])
        for name, influence in influences.items()
    }
    counted = {name: penetrations(influence) for name, influence in influences.items()}
    first, second = "Lankarani–Nikravesh", "enhanced with friction"
    pairs = [(first, "Lankarani–Nikravesh with friction"), ("enhanced without friction", second)]
    verdicts = [
        Verdict("The enhanced law penetrates less", deepest[second] < deepest[first],
                f"{1e6 * deepest[first]:.1f} µm; enhanced {1e6 * deepest[second]:.1f} µm"),
        Verdict("Enhanced with friction penetrates less often than Lankarani-Nikravesh without",
        counted[second] < counted[first],
                f"peaks of penetration in the turn: {counted[first]}; {counted[second]}"),
        *(Verdict(f"Friction alone lowers the frequency of penetration: {b.removesuffix(' with friction')}",
        counted[b] < counted[a],
                  f"peaks of penetration without friction {counted[a]}, with friction {counted[b]}") for a,
                  b in pairs),
    ]  # fmt: skip
    panels = [
        Panel("(a)", "crank angle (degrees)", "contact force of joint 2 (kN)", force),
        Panel("(b)", "crank angle (degrees)", "penetration in joint 2 (µm)", depth),
    ]
    text = ["; ".join(f"{name}: {settling(influence)}" for name, influence in influences.items()) + "."]
    data = {"deepest": deepest, "penetrations": counted}
    chart = Chart("fig13", "Contact force and penetration over the last turn", panels, 2)
    return Item(
        "fig13",
        "Fig. 13: enhanced law with friction and Lankarani-Nikravesh",
        text,
        parameters_of(context),
        [chart],
        [],
        verdicts,
        data,
    )


def penetrations(influence: Influence) -> int:
    """Peaks of the penetration within the last turn: how often the journal is pressed in, with or without
    leaving the wall between.
    """
    depth = np.maximum(curves.penetration(influence.run)[1], 0.0)
    return (curves.ripples(depth) + 1) // 2
