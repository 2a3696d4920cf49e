"""Ranges of runs against the same runs with an eighth of the step: what `vfife run` says of its own error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import vfife
from vfife import gallery
from vfife.measures.error_ranges import sizes
from vfife.measures.trust import trust
from vfife.model.mechanism import Mechanism
from vfife.modelfile.parameter import with_values
from vfife.simulation.result import Result

from .case import Nudge, Row, Rows, verified

FINER = 8  # times as many steps for the truth
INSIDE = 0.995  # share of the measures whose range contains the truth (docs/trust.md)
OUTSIDE = 0.005  # of a measure's size, by which none may lie outside
# Sensitive runs: mechanism and factors of clearances, speeds, frictions. In the first all steps of the last
# try agree by chance. They are compared with so many times as many steps, for this share of the measures.
SENSITIVE: tuple[tuple[Callable[[], Mechanism], float, float, float], ...] = (
    (gallery.four_bar_case_c, 1.0, 1.2, 3.0), (gallery.four_bar_case_c, 1.0, 0.7, 4.0),
    (gallery.four_bar_case_c, 1.2, 1.0, 3.0), (gallery.four_bar_case_c, 0.5, 1.0, 3.0),
)  # fmt: skip
FINER_OF_SENSITIVE, INSIDE_OF_SENSITIVE = (3, 5, 8), 0.97
# Chaotic motions, whose measures are means over the last ten of twenty turns: loose pin and piston.
CHAOTIC: tuple[Callable[[], Mechanism], ...] = (
    lambda: gallery.slider_crank_loose_pin(turns=20), lambda: gallery.piston_slap(turns=20),
)  # fmt: skip
INSIDE_OF_CHAOTIC = 0.95
ROUNDING = 1e-9  # of a share of the time, which sums of times leave
# Factors of all clearances and of all constant speeds; the first is the mechanism as it stands.
VARIANTS = ((1.0, 1.0), (0.7, 1.0), (1.4, 1.0), (2.0, 1.0), (1.0, 0.7), (1.0, 0.5), (1.0, 1.2))
MECHANISMS: tuple[Callable[[], Mechanism], ...] = (
    gallery.four_bar_case_b, gallery.four_bar_case_c, gallery.journal_in_bearing,
    gallery.slider_crank_loose_pin, gallery.slider_crank_loose_guide, gallery.piston_slap,
    gallery.block_on_incline, gallery.quick_return, gallery.double_pendulum, gallery.elastic_pendulum,
    gallery.scotch_yoke, gallery.squeezer, gallery.six_bar_press, gallery.slider_crank, gallery.jansen_leg,
)  # fmt: skip


def numbers(m: Mechanism, clearance: float, speed: float, friction: float) -> dict[str, float]:
    """Return what changes in a mechanism by factors of its clearances, constant speeds and frictions, by
    path.
    """
    values: dict[str, float] = {}
    for name, joint in m.contacts.items():
        values[f"joint.{name}.clearance"] = clearance * (getattr(joint, "clearance", None) or 0.0)
        law = getattr(joint, "friction", None)
        values[f"joint.{name}.friction.coefficient"] = friction * getattr(law, "coefficient", 0.0)
    for name, driver in m.drivers.items():
        values[f"driver.{name}.speed"] = speed * (driver.steady_speed or 0.0)
    factors = {"clearance": clearance, "coefficient": friction, "speed": speed}
    return {
        path: value for path, value in values.items() if value and factors[path.rpartition(".")[2]] != 1.0
    }


def variants(m: Mechanism, friction: float) -> Iterator[tuple[bool, Mechanism]]:
    """Yield a mechanism as it stands, and those with other numbers; True marks the first."""
    for clearance, speed in VARIANTS:
        changes = numbers(m, clearance, speed, friction)
        if (clearance, speed) == VARIANTS[0]:
            yield True, with_values(m, changes) if changes else m
        elif numbers(m, clearance, speed, 1.0):
            yield False, with_values(m, changes)


def misses(result: Result, width: float, finer: int = FINER) -> Mapping[str, float]:
    """Return by how much of its size each measure of a run with ``finer`` times as many steps lies outside of
    its range, whose ``width`` is multiplied. Measures without a size that lie outside count with half of
    OUTSIDE.
    """
    step = result.record.assembly.choice.step
    model = result.record.assembly.mechanism
    truth = vfife.simulate(model, step=step / finer, companions=0, reference=False).measures
    size, outside = sizes(result.measures, step), {}
    for name, measure in result.measures.items():
        if measure.estimated and name in truth:
            low, high = (measure + width * (end - measure) for end in (measure.low, measure.high))
            distance = max(truth[name] - high, low - truth[name], 0.0)
            if ".share." in name and distance < ROUNDING:
                distance = 0.0
            outside[name] = distance / size[name] if name in size else 0.5 * OUTSIDE * (distance > 0.0)
    return outside


@verified(
    "Ranges of runs",
    "the same runs with an eighth of the step; 99.5 % of the measures of runs that are not sensitive",
    nudges={"width": 0.0, "friction": 3.0},
    quick=False,
)
def ranges_of_runs(nudge: Nudge) -> Rows:
    """Compare 63 runs of fifteen mechanisms of the gallery, as they stand and with other clearances and
    speeds, at the automatic step: how many of the fifteen are robust to the step size, how many of some 1,800
    measures of the runs that are not sensitive have a range that contains the truth, and the largest distance
    outside.
    """
    outside: list[float] = []
    robust = compared = runs = 0
    for build in MECHANISMS:
        for first, m in variants(build(), nudge("friction")):
            runs += 1
            result = vfife.simulate(m, reference=False)
            estimate = trust(result.record, result.measures)
            if estimate is not None and not estimate.sensitive:
                robust, compared = robust + first, compared + 1
                outside.extend(misses(result, nudge("width")).values())
    inside, measures = sum(miss == 0.0 for miss in outside), len(outside)
    yield Row(
        "share of the fifteen that are not sensitive", "1", 1.0, robust / len(MECHANISMS), 1e-2,
        counts={"mechanisms as they stand": (robust, len(MECHANISMS)), "runs": (compared, runs)},
    )  # fmt: skip
    yield Row(
        "share of the measures inside their range", "1", 1.0, inside / max(measures, 1), 1.0 - INSIDE,
        counts={"measures inside": (inside, measures)},
    )  # fmt: skip
    yield Row("largest distance outside, over the size", "1", 0.0, max(outside, default=1.0), OUTSIDE, 1.0)


@verified(
    "Ranges of sensitive runs",
    "the same runs with 3, 5 and 8 times as many steps; 97 % of the measures of four sensitive runs",
    nudges={"width": 0.0, "friction": 0.01},
    quick=False,
)
def ranges_of_sensitive_runs(nudge: Nudge) -> Rows:
    """Compare four runs of a four-bar with three to four times its friction, whose motion depends on the step
    size: how many are called sensitive, and how many of 660 measures at other steps lie in their ranges. Do
    the same with two chaotic motions of twenty turns, whose measures are means over turns.
    """
    outside: list[float] = []
    sensitive = 0
    for build, clearance, speed, friction in SENSITIVE:
        changes = numbers(build(), clearance, speed, friction * nudge("friction"))
        result = vfife.simulate(with_values(build(), changes), reference=False)
        estimate = trust(result.record, result.measures)
        sensitive += estimate is not None and estimate.sensitive
        for finer in FINER_OF_SENSITIVE:
            outside.extend(misses(result, nudge("width"), finer).values())
    inside, measures = sum(miss == 0.0 for miss in outside), len(outside)
    yield Row("share of the four that are called sensitive", "1", 1.0, sensitive / len(SENSITIVE), 1e-2)
    yield Row(
        "share of the measures inside their range", "1", 1.0, inside / max(measures, 1),
        1.0 - INSIDE_OF_SENSITIVE, counts={"measures inside": (inside, measures)},
    )  # fmt: skip
    means: list[float] = []
    for build in CHAOTIC:
        result = vfife.simulate(build(), reference=False)
        for finer in FINER_OF_SENSITIVE:
            means.extend(misses(result, nudge("width"), finer).values())
    inside, measures = sum(miss == 0.0 for miss in means), len(means)
    yield Row(
        "share of the means of two chaotic motions inside their range", "1", 1.0, inside / max(measures, 1),
        1.0 - INSIDE_OF_CHAOTIC, counts={"means inside": (inside, measures)},
    )  # fmt: skip
