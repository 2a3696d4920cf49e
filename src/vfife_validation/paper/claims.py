"""Every claim of the paper's text, each true or false with its numbers."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from vfife.report.document import Table
from vfife.solvers.ensemble import placed
from vfife.solvers.record import Record
from vfife.solvers.transient import run

from .contents import Chart, Item, Line, Panel, Verdict
from .context import described, settling
from .impact import fig9, fig10
from .influence import BODY, Influence
from .one_joint import fig12, fig13
from .three_joints import (
    falling,
    fig15,
    fig16,
    fig17,
    fig18,
    fig19,
    fig20,
    rising,
    size_title,
    speed_title,
    table3,
)

if TYPE_CHECKING:
    from .context import Context

FIRST_TURNS, OUTPUTS = 3, 720


def claims(context: Context) -> Item:
    """All of them in one place, with the run-up that leads to the settled turn."""
    verdicts: list[tuple[str, Verdict]] = []
    for figure in (fig9, fig10, fig12, fig13, table3, fig15, fig18, fig16, fig17, fig19, fig20):
        item = context.compute_once(figure.__name__, partial(figure, context))
        verdicts += [(item.title.partition(":")[0], verdict) for verdict in item.verdicts]
    verdicts += [("Table 4", verdict) for verdict in [*falling(context.speeds), rising(context.speeds)]]
    verdicts += [("Sect. 5.1", verdict) for verdict in run_up(context)]
    rows = [[verdict.word, section, verdict.statement, verdict.numbers] for section, verdict in verdicts]
    confirmed = sum(verdict.holds is True for _, verdict in verdicts)
    table = Table(
        ["", "where", "claim, in our words", "numbers"], rows, f"{confirmed} of {len(verdicts)} hold"
    )
    data = {
        "claims": [
            {"holds": v.holds, "where": section, "claim": v.statement, "numbers": v.numbers}
            for section, v in verdicts
        ]
    }
    text = [
        "Claims about one loose joint depend on parameters that are chosen, not known; those about three, on"
        " the set that was fitted to Table 3."
    ]
    return Item(
        "claims",
        "Claims of the text",
        text,
        described(context.parameters),
        [decline(context)],
        [table],
        [],
        data,
    )


def run_up(context: Context) -> list[Verdict]:
    """How the motion settles."""
    runs = [*context.sizes, *context.speeds[:-1]]
    changes = [astray(influence, first_turns(context, influence)) for influence in runs]
    onsets = [np.diff(influence.run.turns.block("contact_onsets").sum(axis=1)) for influence in runs]
    ends = "; ".join(
        f"{size_title(influence)}, {speed_title(influence)}: {settling(influence)}" for influence in runs
    )
    sizes = [turns[0] for turns in changes[: len(context.sizes)]]
    measure = "largest acceleration apart from the settled turn's, over the largest ideal one"
    return [
        Verdict("Strong vibration after the start declines",
                all(min(turns[0], 0.1) > turns[-1] for turns in changes),
                f"{measure}, turn by turn: "
                + "; ".join(", ".join(f"{value:.2g}" for value in turns) for turns in changes)),
        Verdict("The motion becomes periodic", all(influence.run.settled is not None for influence in runs),
                ends),
        Verdict("The vibration at the start grows with the clearance", sizes == sorted(sizes),
                f"{measure}, first turn: " + ", ".join(f"{value:.2f}" for value in sizes)),
        Verdict("Contact is lost while the motion settles only", all(not n[-1] for n in onsets),
                "contacts begun, turn by turn: "
                + "; ".join(", ".join(f"{count:.0f}" for count in n) for n in onsets)),
    ]  # fmt: skip


def first_turns(context: Context, influence: Influence) -> Record:
    """Run the first turns from the start, with all outputs."""
    mechanism, step = influence.run.assembly.mechanism, influence.case.step
    record: Record = context.compute_once(
        f"start {influence.case}", lambda: run(placed(mechanism, step, FIRST_TURNS, OUTPUTS))
    )
    return record


def astray(influence: Influence, record: Record) -> list[float]:
    """Largest difference of the follower's acceleration from the settled turn at the same crank angle, over
    the ideal maximum, turn by turn.
    """
    row = influence.run.assembly.bodies[BODY].row
    settled = influence.run.last.block("body_alpha")[1:, row]
    turns = record.block("body_alpha")[1:, row].reshape(FIRST_TURNS, OUTPUTS)
    return [float(np.abs(turn - settled).max() / influence.ideal_acceleration) for turn in turns]


def decline(context: Context) -> Chart:
    """Plot the follower's acceleration over the first turns."""
    panels = []
    for influence in context.sizes:
        record = first_turns(context, influence)
        turns = record.steps / record.steps[-1] * FIRST_TURNS
        values = record.block("body_alpha")[:, record.assembly.bodies[BODY].row]
        panels.append(
            Panel(
                size_title(influence),
                "turns of the crank",
                "acceleration of follower (10³ rad/s²)",
                [Line(turns, 1e-3 * values)],
            )
        )
    return Chart("settling", "From the start to the settled turn, 50π rad/s", panels, 3)
