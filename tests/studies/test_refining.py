"""The end of a search by derivatives: minima that are known, on limits and between them; what has no
derivatives; a search that is broken off.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import pytest
from scipy.optimize import brentq, minimize_scalar

import vfife
from vfife.errors import VfifeError
from vfife.studies.methods.local_search import Contradiction, measure_derivatives, refine
from vfife.studies.methods.optimise import (
    Axis,
    Candidate,
    Parameters,
    Search,
    Values,
    candidate,
    pareto_front,
    read_search,
)
from vfife.studies.spec.limits import Bound
from vfife.studies.spec.study_file import StudyTables

XY = (Axis("x", -2.0, 2.0), Axis("y", 0.01, 10.0, logarithmic=True))
DISK = Search(
    (*XY, Axis("word", values=("a", "b")), Axis("teeth", 5.0, 9.0, integer=True)),
    ("f",),
    (Bound("r", high=1.0),),
    1,
    refine=40,
)
EDGE = (
    0.7864,
    0.6177,
)  # the least of Rosenbrock's function on the unit disk (documentation of MATLAB's fmincon)


def valley(asked: Sequence[Parameters]) -> list[Values | None]:
    """Rosenbrock's function and the square of the radius."""
    at = [(float(one["x"]), float(one["y"])) for one in asked]
    return [{"f": (1.0 - x) ** 2 + 100.0 * (y - x * x) ** 2, "r": x * x + y * y} for x, y in at]


def slopes(one: Parameters) -> Mapping[str, Mapping[str, float]]:
    """Their derivatives."""
    x, y = float(one["x"]), float(one["y"])
    return {
        "f": {"x": 2.0 * (x - 1.0) - 400.0 * x * (y - x * x), "y": 200.0 * (y - x * x)},
        "r": {"x": 2.0 * x, "y": 2.0 * y},
    }


def begun(search: Search, ask: Any = valley) -> list[Candidate]:
    """A search whose only case lies in the valley."""
    numbers: Parameters = {"x": -0.5, "y": 0.3, "word": "b", "teeth": 7.0}
    return [candidate(search, 0, numbers, ask([numbers])[0])]


def test_a_valley_is_followed_to_its_limit() -> None:
    """Words and whole numbers are left as they are, cases are numbered on, and the last keeps the limit."""
    found = refine(DISK, begun(DISK), valley, slopes)
    (least,) = pareto_front(DISK, found.candidates)
    assert (least.parameters["x"], least.parameters["y"]) == pytest.approx(EDGE, abs=1e-4)
    assert least.values is not None and 1.0 - 1e-5 < least.values["r"] <= 1.0
    assert found.reason == "" and len(found.candidates) <= 40
    assert [one.number for one in found.candidates] == list(range(1, len(found.candidates) + 1))
    assert {(one.parameters["word"], one.parameters["teeth"]) for one in found.candidates} == {("b", 7.0)}


def test_the_most_is_found_as_the_least_is() -> None:
    """Without limits the most of 1 / (1 + f) is 1, where both are 1."""
    search = replace(DISK, minimised=(), maximised=("g",), bounds=(), refine=100)

    def ask(asked: Sequence[Parameters]) -> list[Values | None]:
        return [{"g": 1.0 / (1.0 + (one or {})["f"])} for one in valley(asked)]

    def steep(one: Parameters) -> Mapping[str, Mapping[str, float]]:
        (values,) = ask([one])
        return {"g": {name: -((values or {})["g"] ** 2) * slope for name, slope in slopes(one)["f"].items()}}

    found = refine(search, begun(search, ask), ask, steep)
    (most,) = pareto_front(search, found.candidates)
    assert (most.parameters["x"], most.parameters["y"]) == pytest.approx((1.0, 1.0), abs=1e-3)


def test_a_search_broken_off_asks_for_the_same_cases_again() -> None:
    whole, kept = refine(DISK, begun(DISK), valley, slopes), dict[tuple[Any, ...], Values | None]()

    def through(asked: Sequence[Parameters]) -> list[Values | None]:
        (one,) = asked
        if (key := tuple(one.items())) not in kept:
            if len(kept) == 6 and key:
                kept[()] = None
                raise KeyboardInterrupt
            (kept[key],) = valley([one])
        return [kept[key]]

    with pytest.raises(KeyboardInterrupt):
        refine(DISK, begun(DISK), through, slopes)
    assert refine(DISK, begun(DISK), through, slopes) == whole
    assert len(kept) == len(whole.candidates) + 1


def refusing(one: Parameters) -> Mapping[str, Mapping[str, float]]:
    raise VfifeError("derivatives of f mean nothing")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"refine": 3}, "refine = 3 cases are used up"),
        ({"bounds": (Bound("C.impacts", high=4.0),)}, "C.impacts has no derivatives"),
        ({"minimised": ("mean(C.force)",)}, "has no derivatives"),
        ({"minimised": ("f", "r")}, "several aims"),
        ({"axes": DISK.axes[2:]}, "nothing varies continuously"),
    ],
)
def test_what_derivatives_cannot_do_is_a_sentence(change: dict[str, Any], said: str) -> None:
    search = replace(DISK, **change)
    assert said in refine(search, begun(search), valley, slopes).reason


def test_where_no_case_keeps_the_limits_derivatives_lead_back_from_the_nearest() -> None:
    """The least at a radius of 0.3, by the angle along that circle."""
    search = replace(DISK, bounds=(Bound("r", high=0.09),))
    cases = [
        *begun(search),
        candidate(search, 1, {"x": 2.0, "y": 5.0, "word": "b", "teeth": 7.0}, {"f": 101.0, "r": 29.0}),
    ]
    (least,) = pareto_front(search, refine(search, cases, valley, slopes).candidates)
    circle = minimize_scalar(
        lambda a: (1.0 - 0.3 * math.cos(a)) ** 2 + 100.0 * (0.3 * math.sin(a) - 0.09 * math.cos(a) ** 2) ** 2,
        (0.0, 0.5),
        options={"xtol": 1e-10},
    )
    assert least.values is not None and least.values["f"] == pytest.approx(circle.fun, rel=1e-4)
    refinement = refine(search, [candidate(search, 0, {}, None)], valley, slopes)
    assert "all measures of the search" in refinement.reason


def test_where_derivatives_mean_nothing_or_a_case_fails_the_search_has_ended() -> None:
    assert refine(DISK, begun(DISK), valley, refusing) == refine(
        DISK, begun(DISK), lambda asked: pytest.fail("asked"), refusing
    )
    assert "mean nothing" in refine(DISK, begun(DISK), valley, refusing).reason
    found = refine(DISK, begun(DISK), lambda asked: [None], slopes)
    assert "failed" in found.reason and len(found.candidates) == 1 and not found.candidates[0].feasible


def contradicted(one: Parameters) -> Mapping[str, Mapping[str, float]]:
    raise Contradiction("finite changes of x contradict the derivative of f")


def test_where_finite_changes_contradict_derivatives_the_search_goes_on_by_values() -> None:
    """A bent valley: a tenth of the start is reached, the limit kept, and no more cases taken than there
    may be.
    """
    search = replace(DISK, refine=400)
    found = refine(search, begun(search), valley, contradicted)
    (least,) = pareto_front(search, found.candidates)
    start = begun(search)[0].values or {}
    assert least.values is not None and least.values["f"] < 0.1 * start["f"] and least.values["r"] <= 1.0
    assert "finite changes of x contradict" in found.reason and "values alone" in found.reason
    few = refine(replace(DISK, refine=7), begun(DISK), valley, contradicted)
    assert len(few.candidates) == 7 and "refine = 7 cases" in few.reason
    assert [one.parameters for one in few.candidates] == [one.parameters for one in found.candidates[:7]]
    assert [one.number for one in found.candidates] == list(range(1, len(found.candidates) + 1))


@pytest.mark.system("displaced runs of a chaotic motion")
def test_derivatives_of_a_chaotic_motion_are_contradicted_by_finite_changes() -> None:
    """The largest force of a slider-crank with a loose guide by the restitution there."""
    pytest.importorskip("optuna")
    study = {
        "model": "examples/slider_crank_loose_guide.toml",
        "measures": ["O.force.max"],
        "turns": 1,
        "optimise": {"minimise": ["O.force.max"]},
        "vary": {"e": {"path": "joint.guide.contact.restitution", "from": 0.5, "to": 0.95}},
    }
    plan, search = read_search(StudyTables(study, "here"))
    with pytest.raises(VfifeError, match="contradict the derivative of O.force.max|time steps disagree"):
        measure_derivatives(plan, search, {"e": 0.9})


def fastest(crank: float, rod: float) -> float:
    """Largest speed (m/s) of the block of a slider-crank at 100 rad/s, from its closed form."""
    share = crank / rod

    def speed(angle: float) -> float:
        sine = math.sin(angle)
        return -100.0 * crank * (sine + share * sine * math.cos(angle) / math.sqrt(1.0 - (share * sine) ** 2))

    return -float(minimize_scalar(speed, (1.0, 1.3), options={"xtol": 1e-12}).fun)


CRANK: dict[str, Any] = {
    "model": "examples/slider_crank.toml",
    "measures": ["pin.force.max"],
    "turns": 1,
    "optimise": {"minimise": ["pin.force.max"]},
    "vary": {
        "rod": {"path": "body.rod.length", "from": 0.1, "to": 0.2},
        "speed": {"path": "driver.crank.speed", "from": 50, "to": 200},
        "masses": {"path": ["body.block.mass", "body.crank.mass"], "from": 0.1, "to": 0.3},
    },
}


def test_slopes_are_those_of_the_cases_and_of_all_numbers_that_a_parameter_is() -> None:
    """m w² r (1 + r/l), of which a crank's mass is no part."""
    plan, search = read_search(StudyTables(CRANK, "here"))
    found = measure_derivatives(plan, search, {"rod": 0.12, "speed": 80.0, "masses": 0.2})
    force = 0.2 * 80.0**2 * 0.05 * (1.0 + 0.05 / 0.12)
    expected = {
        "rod": -0.2 * 80.0**2 * (0.05 / 0.12) ** 2,
        "speed": 2.0 * force / 80.0,
        "masses": force / 0.2,
    }
    assert found["pin.force.max"] == pytest.approx(expected, rel=1e-4)


def test_means_of_several_turns_and_runs_that_diverge_have_no_slopes() -> None:
    plan, search = read_search(StudyTables({**CRANK, "turns": 3, "last": 2}, "here"))
    with pytest.raises(VfifeError, match="means of several turns"):
        measure_derivatives(plan, search, {"rod": 0.12, "speed": 80.0, "masses": 0.2})
    with pytest.raises(VfifeError, match="the run ended as (diverged|energy) after step"):
        vfife.sensitivity(
            vfife.load("examples/four_bar_case_c.toml"), turns=1, step=1e-4, force_step=True, companions=0
        )


@pytest.mark.system("a search of hundreds of runs")
def test_a_slider_crank_has_its_least_force_where_two_limits_meet() -> None:
    """m w² r (1 + r/l), least with the block as fast as 5 m/s and no farther out than 180 mm: one root in r,
    found in a handful of runs.
    """
    pytest.importorskip("optuna")
    vary = {
        "rod": {"path": "body.rod.length", "from": "100 mm", "to": "200 mm"},
        "crank": {"path": "body.crank.length", "from": 0.03, "to": 0.06},
    }
    found = vfife.optimise(
        "examples/slider_crank.toml",
        vary,
        ["pin.force.max", "guide.velocity.max", "guide.position.high"],
        turns=1,
        optimise={"minimise": ["pin.force.max"], "cases": 8, "batch": 8},
        limit={"guide.velocity.max": {"low": "5 m/s"}, "guide.position.high": "180 mm"},
    )
    crank = brentq(lambda r: fastest(r, 0.18 - r) - 5.0, 0.03, 0.06)
    (least,) = found.best
    assert least.values is not None and found.refined <= 12 and found.reason == ""
    assert least.values["pin.force.max"] == pytest.approx(
        0.14 * 1e4 * crank * (1.0 + crank / (0.18 - crank)), rel=1e-4
    )
    assert (least.parameters["crank"], least.parameters["rod"]) == pytest.approx(
        (crank, 0.18 - crank), rel=1e-4
    )
    assert len(found.study.done) == 8 + found.refined
