"""Figs. 8-10: a journal of 1 kg meets its fixed bearing at 1 m/s."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vfife.laws import ContactLaw, LankaraniNikravesh, Pereira
from vfife.laws.contact.damping import delivered
from vfife.report.document import Table

from .contents import Band, Chart, Item, Line, Panel, Parameter, Style, Verdict
from .mechanisms import BEARING_RADIUS, JOURNAL_RADIUS, STIFFNESS, journal

if TYPE_CHECKING:
    from .context import Context

Array = NDArray[np.float64]
RESTITUTIONS: dict[float, Style] = {1.0: "ideal", 0.9: "main", 0.7: "second", 0.5: "third", 0.3: "fourth"}
MASS, SPEED = 1.0, 1.0  # kg, m/s
STEP = 2e-8  # s
FIRST_CONTACT = (BEARING_RADIUS - JOURNAL_RADIUS) / SPEED  # s
LENGTH = 20e-3  # m, the axial length of Fig. 9 beside the inferred one

STATED = (
    Parameter("radii R_B, R_J", "10 mm, 9.5 mm", "stated", "Sect. 4.1"),
    Parameter("speed of the journal", "1 m/s, no gravity", "stated", "Sect. 4.1"),
    Parameter("stiffness K (Lankarani-Nikravesh)", "6.6e10 N/m^1.5", "stated", "Sect. 4.1"),
    Parameter(
        "E, ν", "207 GPa, 0.3", "inferred", "2.07 GPa is printed; K as printed follows from 207 GPa only"
    ),
    Parameter("mass of the journal", "1 kg", "chosen", "not in the text"),
)


@cache
def impact(law: ContactLaw, length: float, duration: float) -> tuple[Array, Array, Array, Array]:
    """Time (s), penetration (m), normal force (N) and velocity (m/s) of the journal, from its start at the
    bearing's centre.
    """
    from vfife.assembly.assemble import assemble
    from vfife.solvers.transient import run

    record = run(
        assemble(
            journal(law, axial_length=length, mass=MASS, speed=SPEED),
            STEP,
            duration=duration,
            outputs=round(duration / (10 * STEP)),
        )
    )
    time = np.asarray(record.steps * record.assembly.choice.step, dtype=float)
    return (
        time,
        record.block("contact_penetration")[:, 0],
        record.block("contact_normal_force")[:, 0],
        record.block("particle_u")[:, 1],
    )


def first_impact(law: ContactLaw, length: float) -> dict[str, Array]:
    """Compute the first contact of a journal: time since its start (s), penetration (m) and force (N)."""
    time, depth, force, _ = impact(law, length, 1.5 * FIRST_CONTACT)
    inside = depth >= 0.0
    return {"time": time[inside] - FIRST_CONTACT, "depth": depth[inside], "force": force[inside]}


def restitution_verdicts(impacts: list[dict[str, float]], rebounds: list[float]) -> list[Verdict]:
    """Judge the statements about impacts whose restitution decreases from one to the next.

    rebounds: share of the impact speed by which each differs from the closed form
    """
    losses, depths = [entry["loss"] for entry in impacts], [entry["depth"] for entry in impacts]
    return [
        Verdict(
            "The loops grow wider as the restitution falls: more energy is lost",
            losses == sorted(losses),
            f"losses {_series(losses, 1.0, 4)} J",
        ),
        Verdict(
            "Rebound speeds are those of the closed form of the law",
            max(rebounds) < 1e-3,
            f"largest difference {max(rebounds):.1e} m/s",
        ),
        Verdict(
            "Less restitution means a shallower impact",
            depths == sorted(depths, reverse=True),
            f"depths {_series(depths, 1e6, 2)} µm",
        ),
    ]


def fig8(context: Context) -> Item:
    """Contact force over time and hysteresis loops for several restitution coefficients."""
    lines: dict[str, list[Line]] = {"time": [], "depth": []}
    rows, data, rebounds = [], [], []
    for restitution, style in RESTITUTIONS.items():
        law = LankaraniNikravesh(restitution=restitution, stiffness=STIFFNESS)
        hit = first_impact(law, LENGTH)
        rebound = -float(impact(law, LENGTH, 1.5 * FIRST_CONTACT)[3][-1])
        chi = 0.75 * (1.0 - restitution**2)
        label = f"restitution {restitution:g}"
        lines["time"].append(Line(1e3 * hit["time"], 1e-3 * hit["force"], label, style))
        lines["depth"].append(Line(1e6 * hit["depth"], 1e-3 * hit["force"], label, style))
        loss = float(np.sum(0.5 * (hit["force"][1:] + hit["force"][:-1]) * np.diff(hit["depth"])))
        entry = {
            "restitution": restitution, "peak_force": float(hit["force"].max()),
            "depth": float(hit["depth"].max()),
            "contact_time": float(hit["time"][-1] + hit["depth"][-1] / rebound), "rebound": rebound,
            "delivered": delivered(chi), "loss": loss,
        }  # fmt: skip
        data.append(entry)
        rebounds.append(abs(entry["rebound"] / SPEED - entry["delivered"]))
        rows.append(
            [f"{restitution:g}", f"{entry['peak_force']:.0f}", f"{1e6 * entry['depth']:.2f}",
            f"{1e6 * entry['contact_time']:.1f}",
             f"{entry['rebound']:.4f}", f"{entry['delivered']:.4f}", f"{loss:.4f}"]
        )  # fmt: skip
    chart = Chart(
        "fig8",
        "Contact force of the journal: (a) over the time since the contact began, (b) over the penetration",
        [Panel("(a)", "time since contact began (ms)", "contact force (kN)", lines["time"]),
         Panel("(b)", "penetration (µm)", "contact force (kN)", lines["depth"])], 2,
    )  # fmt: skip
    table = Table(
        ["c_e", "peak (N)", "depth (µm)", "contact (µs)", "rebound (m/s)", "closed form", "loss (J)"], rows,
        "What each impact does; the last two columns: restitution the law promises to deliver"
        " (closed form), energy inside the loop",
    )  # fmt: skip
    text = [
        "The restitution coefficients of the paper's curves are not in its text; these five are chosen. The"
        " law delivers more restitution than its coefficient says (0.9132 for 0.9, 0.7252 for 0.5), as its"
        " authors derived it for coefficients near 1."
    ]
    chosen = Parameter("restitution coefficients", "1, 0.9, 0.7, 0.5, 0.3", "chosen", "not in the text")
    return Item(
        "fig8",
        "Fig. 8: contact force and hysteresis",
        text,
        (*STATED, chosen),
        [chart],
        [table],
        restitution_verdicts(data, rebounds),
        {"impacts": data},
    )


def length_parameters(inferred: float) -> list[Parameter]:
    """Parameters of the comparison of two laws at two axial lengths, of which one is ``inferred`` (m)."""
    return [
        *STATED,
        Parameter("restitution coefficient", "0.9", "chosen", "not in the text"),
        Parameter(
            "axial length L",
            "20 mm, a bearing as long as it is wide",
            "chosen",
            "the paper's is in the lost Table 2",
        ),
        Parameter("axial length L, second curve", f"{1e3 * inferred:.3g} mm", "inferred", "fit to Table 3"),
    ]


def fig9(context: Context) -> Item:
    """Force over penetration: the enhanced law beside Lankarani-Nikravesh."""
    restitution = 0.9
    inferred = context.parameters.axial_length
    sphere = first_impact(LankaraniNikravesh(restitution=restitution, stiffness=STIFFNESS), LENGTH)
    lines = [Line(1e6 * sphere["depth"], 1e-3 * sphere["force"], "Lankarani–Nikravesh", "second")]
    depths = {}
    styles: dict[float, Style] = {LENGTH: "main", inferred: "third"}
    for length, style in styles.items():
        hit = first_impact(Pereira(restitution=restitution), length)
        lines.append(
            Line(1e6 * hit["depth"], 1e-3 * hit["force"], f"enhanced, L = {1e3 * length:.3g} mm", style)
        )
        depths[length] = float(hit["depth"].max())
    deepest, analytic = float(sphere["depth"].max()), _same_depth(float(sphere["depth"].max()), restitution)
    numbers = (
        f"{1e6 * deepest:.1f} µm; enhanced {1e6 * depths[LENGTH]:.1f} µm (L = 20 mm),"
        f" {1e6 * depths[inferred]:.1f} µm (L = {1e3 * inferred:.3g} mm)"
    )
    verdicts = [
        Verdict(
            "The enhanced law penetrates less, L = 20 mm",
            depths[LENGTH] < deepest,
            f"Lankarani–Nikravesh {numbers}",
        ),
        Verdict(
            f"The same with the length inferred from Table 3, {1e3 * inferred:.3g} mm",
            depths[inferred] < deepest,
            f"equal at L = {1e3 * analytic:.3g} mm",
        ),
    ]
    chart = Chart(
        "fig9",
        "Contact force over penetration in the first impact",
        [Panel("", "penetration (µm)", "contact force (kN)", lines)],
        1,
    )
    text = [
        "The enhanced law's stiffness is proportional to the axial length, which Lankarani-Nikravesh does"
        " not know: which of the two penetrates less is a matter of that length. They are equally deep at L"
        f" = {1e3 * analytic:.3g} mm."
    ]
    data = {
        "depths": {
            "lankarani-nikravesh": deepest,
            "enhanced, 20 mm": depths[LENGTH],
            "enhanced, inferred": depths[inferred],
        },
        "equal_length": analytic,
    }
    return Item(
        "fig9",
        "Fig. 9: enhanced law and Lankarani-Nikravesh",
        text,
        length_parameters(inferred),
        [chart],
        [],
        verdicts,
        data,
    )


def _same_depth(depth: float, restitution: float) -> float:
    """Axial length (m) at which the enhanced law's first impact is as deep as ``depth`` (m), by bisection."""
    low, high = 1e-3, 5e-2
    for _ in range(12):
        middle = math.sqrt(low * high)
        low, high = (
            (middle, high)
            if float(first_impact(Pereira(restitution=restitution), middle)["depth"].max()) > depth
            else (low, middle)
        )
    return math.sqrt(low * high)


def fig10(context: Context) -> Item:
    """Contact force over time through the three modes."""
    time, depth, force, _ = impact(LankaraniNikravesh(restitution=0.9, stiffness=STIFFNESS), LENGTH, 3e-3)
    touching = depth > 0.0
    change = np.flatnonzero(np.diff(touching.astype(int)))
    begins, ends = time[change[~touching[change]] + 1], time[change[touching[change]] + 1]
    peaks = [float(force[(time >= a) & (time <= b)].max()) for a, b in zip(begins, ends, strict=False)]
    bands = [Band(1e3 * a, 1e3 * b, "continuous contact") for a, b in zip(begins, ends, strict=False)]
    marks = [Line(1e3 * begins, np.zeros(len(begins)), "impact: a contact begins", "second", True)]
    panel = Panel(
        "",
        "time (ms)",
        "contact force (kN)",
        [Line(1e3 * time, 1e-3 * force, "contact force (zero: free flight)", "main"), *marks],
        bands,
    )
    falls = all(b < a for a, b in zip(peaks, peaks[1:], strict=False))
    verdicts = [
        Verdict(
            "The journal goes through free flight, impact and continuous contact",
            len(peaks) >= 2,
            f"{len(peaks)} contacts in 3 ms",
        ),
        Verdict(
            "The second peak is lower than the first",
            len(peaks) >= 2 and falls,
            f"peaks {_series(peaks, 1e-3, 2)} kN",
        ),
    ]
    parameters = [*STATED, Parameter("restitution coefficient", "0.9", "chosen", "not in the text")]
    chart = Chart("fig10", "Contact force over time; shaded: continuous contact", [panel], 1)
    return Item(
        "fig10",
        "Fig. 10: contact force and the modes of motion",
        [],
        parameters,
        [chart],
        [],
        verdicts,
        {"peaks": peaks, "begins": begins.tolist()},
    )


def _series(values: list[float], factor: float, digits: int) -> str:
    return ", ".join(f"{factor * value:.{digits}f}" for value in values)
