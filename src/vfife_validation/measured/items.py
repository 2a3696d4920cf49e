"""What ``vfife verify measured`` shows: items with statements that are true or false, tables and charts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from vfife.report.document import Table
from vfife.results.fit import Fit, FitValue

from ..paper.contents import Chart, Item, Line, Panel, Verdict
from . import double as pendulums
from . import hysteresis as loops
from . import single

TITLE = "vfife beside measurements"
INTRODUCTION = (
    "Models of vfife compared with measured swings of a single and a double pendulum, and with synthetic"
    " hysteresis loops with noise. The numbers decide whether a statement is true or false; the page shows"
    " disagreement as openly as agreement."
)
SQUARES = (64.04, 64.14)  # 1/s2, of fits of each record by itself, with SciPy
LEFT = (0.002, 0.006)  # of a record's deviation, that such fits leave
GOAL, SEEDS = 0.01, 20
DEGREES = 180.0 / math.pi


def percent(value: float) -> str:
    """Format a share in per cent."""
    return f"{100.0 * value:.3g} %"


def row(value: FitValue) -> tuple[str, str, str]:
    """Return a parameter, its value and its 95 % limits as texts."""
    return value.name, f"{value.value:.5g} {value.unit}", f"{value.low:.4g} to {value.high:.4g}"


def residuals(fit: Fit) -> str:
    """List the residual of each record."""
    return ", ".join(percent(record.residual) for record in fit.records)


def single_pendulum() -> Item:
    """Four records of a single pendulum, one parameter set."""
    plain, curve = single.identify("viscous and dry"), single.identify("curve")
    square, error = single.frequency(plain.values[0].value, plain.values[0].error)
    left = [record.residual for record in plain.records]
    better = max(record.residual for record in curve.records)
    distance = single.difference(plain)
    authors = single.authors()
    verdicts = [
        Verdict(
            "a rigid pendulum with viscous and dry friction leaves at most 0.6 % of each record's deviation",
            max(left) <= LEFT[1], residuals(plain),
        ),
        Verdict(
            "its small swings have 64.04 to 64.14 1/s2, as fits of each record by SciPy have",
            SQUARES[0] <= square <= SQUARES[1], f"{square:.3f} ± {error:.3f} 1/s2",
        ),
        Verdict(
            "the data separate viscous and dry friction poorly, and the fit reports it", bool(plain.splits),
            f"correlation {plain.correlation[2, 1]:+.2f}; dry {plain.values[2].low:.1e} to"
            f" {plain.values[2].high:.1e} N m",
        ),
        Verdict(
            "friction as a curve over speed leaves at most 0.6 % of each record", better <= LEFT[1],
            residuals(curve),
        ),
        Verdict(
            "our swings are those of the equation of motion, integrated by SciPy, within 2 mrad",
            distance <= 2e-3, f"{1e3 * distance:.2f} mrad at most in 9.2 s at steps of 1 ms",
        ),
        Verdict(
            "the authors' numbers, from the first sample on, miss by 4 to 22 %",
            min(authors) > 0.03 and max(authors) < 0.23, ", ".join(map(percent, authors)),
        ),
    ]  # fmt: skip
    lines = [
        Line(part.places, DEGREES * (part.measured - part.model), part.record, str(k))
        for k, part in enumerate(curve.curves)
    ]
    chart = Chart(
        "single_pendulum", "What the model with friction over speed misses of each record",
        [Panel("left of four records", "time (s)", "angle (°)", lines)],
    )  # fmt: skip
    heads = ("number", "value", "95 % confidence")
    tables = [
        Table(heads, [row(value) for value in plain.values], title="Viscous and dry friction"),
        Table(
            heads,
            [row(value) for value in curve.values],
            title="Friction over speed: at 0.02, 7 and 14 rad/s",
        ),
    ]
    text = (
        "Four records of 9.2 s, each with its own start; inertia and friction are common. Friction that grows"
        " faster than the speed, as drag of air does, is not in the first model, and its dry friction ends at"
        " its bound of zero.",
    )
    data = {"square": square, "error": error, "left": left, "curve": [r.residual for r in curve.records]}
    return Item(
        "single-pendulum", "Single pendulum: one set of numbers", text, (), [chart], tables, verdicts, data
    )


def prediction() -> Item:
    """Report predictions of records with parameters identified from other records."""
    rows, verdicts, data = [], [], {}
    for friction in single.FRICTIONS:
        predictions = single.predicted(friction)
        worst = max(prediction.ours for prediction in predictions)
        rows += [
            (
                friction,
                prediction.name[-2:],
                " and ".join(name[-2:] for name in prediction.others),
                percent(prediction.ours),
            )
            for prediction in predictions
        ]
        good = sum(prediction.ours <= GOAL for prediction in predictions)
        verdicts.append(
            Verdict(
                f"friction {'over speed' if friction == 'curve' else friction}: records that were not fitted"
                " are predicted within 1 % of their deviation over 9 s",
                worst <= GOAL, f"{good} of {len(predictions)}; at worst {percent(worst)}",
            )
        )  # fmt: skip
        data[friction] = [prediction.ours for prediction in predictions]
    text = (
        "Numbers from two of the four records predict the other two, whose start is identified from their"
        " first half second alone. The authors' own records for validation are not available.",
    )
    table = Table(("friction", "record", "numbers of", "missed"), rows, title="Omitted and predicted")
    return Item(
        "prediction", "Single pendulum: records that no fit has seen", text, (), (), [table], verdicts, data
    )


def double_pendulum() -> Item:
    """26 records of a double pendulum, one parameter set."""
    fit = pendulums.identify()
    swings = pendulums.foretold_by_halves()
    rows, verdicts = comparison(swings)
    table = Table(
        ("motion", "records", "over", "missed, median", "at worst", "by the authors' numbers"), rows,
        title="Missed of the deviation, from starts known of the first 0.25 s",
    )  # fmt: skip
    numbers = Table(
        ("number", "value", "95 % confidence"), [row(value) for value in fit.values],
        title="One set for 26 records; masses, length and the lower arm are the authors'",
    )  # fmt: skip
    text = (
        f"The first {pendulums.EARLY:g} s of all records are fitted together, each with its own start: they"
        f" leave {percent(fit.share)}. No force was measured, so the data determine only ratios of masses"
        " and inertias. Predictions do not use these numbers: half of the records is fitted and predicts"
        " the other"
        " half, from starts identified in the first 0.25 s. A record is called chaotic if two"
        " simulations that start 1 µrad apart separate, within the record, to more than"
        f" {pendulums.CHAOTIC:g} times that distance.",
    )
    data = {
        "left": [record.residual for record in fit.records],
        "swings": [{**swing._asdict(), "lyapunov_time": swing.lyapunov_time} for swing in swings],
    }
    tables = [numbers, table, horizons(swings)]
    return Item(
        "double-pendulum", "Double pendulum: 26 records", text, (), [misses(swings)], tables, verdicts, data
    )


def comparison(swings: list[pendulums.Swing]) -> tuple[list[tuple[str, ...]], list[Verdict]]:
    """Rows and statements on what is missed of regular and of chaotic records."""
    groups = {
        "regular": [swing for swing in swings if not swing.chaotic],
        "chaotic": [swing for swing in swings if swing.chaotic],
    }
    rows, verdicts = list[tuple[str, ...]](), list[Verdict]()
    for name, members in groups.items():
        for k, end in enumerate(pendulums.SPANS):
            ours, authors = (
                float(np.median([getattr(swing, source)[k] for swing in members])) if members else math.nan
                for source in ("ours", "authors")
            )
            worst = max((swing.ours[k] for swing in members), default=math.nan)
            rows.append(
                (name, str(len(members)), f"{end:.1f} s", percent(ours), percent(worst), percent(authors))
            )
            verdicts.append(
                Verdict(
                    f"{name} records: over {end:.1f} s our numbers predict better than the authors'",
                    ours < authors if members else None, f"{percent(ours)} and {percent(authors)}, medians",
                )
            )  # fmt: skip
    return rows, verdicts


def horizons(swings: list[pendulums.Swing]) -> Table:
    """How long each record is foretold, and its Lyapunov time."""
    limits = [
        (swing.name[-2:], "chaotic" if swing.chaotic else "regular", f"{swing.lyapunov_time:.2f} s",
         seconds(swing.horizon), seconds(swing.horizon_of_authors))
        for swing in swings
    ]  # fmt: skip
    return Table(
        ("record", "motion", "Lyapunov time", "predicted for", "by the authors' numbers"), limits,
        title=f"Times until an angle is off by {pendulums.LIMIT:g} rad",
    )  # fmt: skip


def misses(swings: list[pendulums.Swing]) -> Chart:
    """Plot the error of the prediction of each record."""
    places = np.arange(1, 1 + len(swings))
    return Chart(
        "double_pendulum", "Missed over 1 s and over 2.7 s, records from the widest swing to the narrowest",
        [
            Panel(
                f"over {end:.1f} s", "record", "missed (%)",
                [
                    Line(places, [100.0 * getattr(swing, source)[k] for swing in swings], label, style, True)
                    for source, label, style in (
                        ("ours", "our numbers", "main"), ("authors", "authors' numbers", "second"))
                ],
                logarithmic="y",
            )
            for k, end in enumerate(pendulums.SPANS)
        ],
        2,
    )  # fmt: skip


def seconds(value: float) -> str:
    """Format the time until a prediction is lost."""
    return f"{value:.2f} s" if math.isfinite(value) else f"more than {pendulums.SPANS[-1]:.2f} s"


def hysteresis() -> Item:
    """Clearance, stiffness and drag from a loop with noise."""
    covered, worst = loops.coverage(SEEDS)
    fit = loops.identify(0)
    rows = [
        (name, f"{truth:g}", f"{value:.5g}", f"{low:.5g} to {high:.5g}", f"{covered[name]} of {SEEDS}",
         percent(worst[name]))
        for name, (value, low, high, truth) in loops.answers(fit).items()
    ]  # fmt: skip
    smallest = math.floor(0.8 * SEEDS)
    verdicts = [
        Verdict(
            "the clearance is recovered within 5 %", worst["clearance"] <= 0.05,
            f"{percent(worst['clearance'])} at worst of {SEEDS} loops",
        ),
        Verdict(
            f"95 % limits contain the truth in {smallest} of {SEEDS} loops or more",
            min(covered.values()) >= smallest,
            ", ".join(f"{name} {count}" for name, count in covered.items()),
        ),
    ]  # fmt: skip
    times, places, forces = loops.loop(0)
    model = fit.curves[0].model / loops.ARM
    lines = [
        Line(1e6 * places, forces, "loop with noise", "faint", True),
        Line(1e6 * places, model, "vfife", "main"),
    ]  # fmt: skip
    chart = Chart(
        "hysteresis", "Force over displacement of the first loop, and the model's",
        [Panel("backlash, stiffness and drag", "displacement (µm)", "force (N)", lines)],
    )  # fmt: skip
    heads = ("number", "truth", "found", "95 % confidence", "limits that hold", "largest error")
    table = Table(heads, rows, title="Clearance (m), stiffness (N/m) and drag (N)")
    text = (
        "A simple model computes the loops, with noise of 3 % of the force's deviation. No measured loop with"
        " a licence that permits redistribution was available.",
    )
    data = {"held": covered, "worst": worst, "samples": len(times)}
    return Item("hysteresis", "Clearance from a hysteresis loop", text, (), [chart], [table], verdicts, data)


ITEMS: dict[str, Callable[[], Item]] = {
    "single-pendulum": single_pendulum,
    "prediction": prediction,
    "double-pendulum": double_pendulum,
    "hysteresis": hysteresis,
}
# Processor time (s) of each item, on a common machine.
SECONDS = {"single-pendulum": 9.0, "prediction": 19.0, "double-pendulum": 51.0, "hysteresis": 15.0}
