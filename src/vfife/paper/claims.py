"""Every claim of the paper's text, each true or false with its numbers."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ..ensemble import placed
from ..simulation import run
from .contents import Chart, Item, Line, Panel, Table, Verdict
from .context import described, settling
from .impact import fig9, fig10
from .influence import BODY
from .one_joint import fig12, fig13
from .three_joints import falling, fig15, fig16, fig17, fig18, fig19, fig20, rising, size_title, speed_title, table3

if TYPE_CHECKING:
    from .context import Context

FIRST_TURNS = 3


def claims(context: Context) -> Item:
    """All of them in one place, with the run-up that leads to the settled turn."""
    found: list[tuple[str, Verdict]] = []
    for figure in (fig9, fig10, fig12, fig13, table3, fig15, fig18, fig16, fig17, fig19, fig20):
        made = context.once(figure.__name__, partial(figure, context))
        found += [(made.title.partition(":")[0], verdict) for verdict in made.verdicts]
    found += [("Table 4", verdict) for verdict in [*falling(context.speeds), rising(context.speeds)]]
    found += [("Sect. 5.1", verdict) for verdict in run_up(context)]
    rows = [[verdict.word, where, verdict.statement, verdict.numbers] for where, verdict in found]
    held = sum(verdict.holds is True for _, verdict in found)
    table = Table(f"{held} of {len(found)} hold", ["", "where", "claim, in our words", "numbers"], rows)
    data = {"claims": [{"holds": v.holds, "where": where, "claim": v.statement, "numbers": v.numbers} for where, v in found]}
    text = [
        "Claims about one loose joint depend on parameters that are chosen, not known; those about three, on the set that was fitted to Table 3."
    ]
    return Item("claims", "Claims of the text", text, described(context.parameters), [decline(context)], [table], [], data)


def run_up(context: Context) -> list[Verdict]:
    """How the motion settles."""
    runs = [*context.sizes, *context.speeds[:-1]]
    peaks = [one.member.turns.block("body_alpha_max")[1:, one.member.assembly.bodies[BODY].row] for one in runs]
    first = [float(p[0] / one.ideal_acceleration) for p, one in zip(peaks, runs, strict=True)]
    last = [float(p[-1] / one.ideal_acceleration) for p, one in zip(peaks, runs, strict=True)]
    falls = ", ".join(f"{a:.2f} to {b:.2f}" for a, b in zip(first, last, strict=True))
    onsets = [one.member.turns.block("clearance_onsets").sum(axis=1) for one in runs]
    settled = all(one.member.settled is not None for one in runs)
    ends = "; ".join(f"{size_title(one)}, {speed_title(one)}: {settling(one)}" for one in runs)
    sizes = first[: len(context.sizes)]
    return [
        Verdict("Strong vibration after the start declines", all(b < a for a, b in zip(first, last, strict=True)),
                f"largest acceleration over the ideal one, first turn to last: {falls}"),
        Verdict("The motion becomes periodic", settled, ends),
        Verdict("The vibration at the start grows with the clearance", sizes == sorted(sizes),
                "largest acceleration of the first turn over the ideal one: " + ", ".join(f"{value:.2f}" for value in sizes)),
        Verdict("Contact is lost at the start only", all(float(n[-1]) == float(n[1]) for n in onsets),
                "contacts begun, first turn and later: " + ", ".join(f"{n[1]:.0f} and {n[-1] - n[1]:.0f}" for n in onsets)),
    ]  # fmt: skip


def decline(context: Context) -> Chart:
    """The follower's acceleration over the first turns, which repeat from the second or third on."""
    panels = []
    for one in context.sizes:
        record = run(placed(one.member.assembly.mechanism, one.case.step, FIRST_TURNS, 720))
        turns = record.steps / record.steps[-1] * FIRST_TURNS
        values = record.block("body_alpha")[:, record.assembly.bodies[BODY].row]
        panels.append(Panel(size_title(one), "turns of the crank", "acceleration of follower ($10^3$ rad/s²)", [Line(turns, 1e-3 * values)]))
    return Chart("settling", "From the start to the settled turn, 50π rad/s", panels, 3)
