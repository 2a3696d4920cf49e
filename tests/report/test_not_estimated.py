"""What has no estimate of its error says so, wherever it is shown."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from functools import cache

import pytest
from rich.console import Console

import vfife
from support import with_settings
from vfife import Mechanism, gallery
from vfife.plots.notebook import result_html
from vfife.report.digits import is_estimated, range_text
from vfife.report.pages import run_page as document
from vfife.report.summary import show
from vfife.report.trust import missing_mesh_estimate
from vfife.simulation.result import Result

WORDS = "not estimated"


def text(result: Result) -> str:
    console = Console(file=io.StringIO(), width=160)
    show(console, result)
    return console.file.getvalue()


@cache
def loose() -> Result:
    return vfife.simulate(
        with_settings(gallery.four_bar_case_c(), turns=1.0), step=1e-5, companions=1, reference=False
    )


def line(said: str, begin: str) -> str:
    return next(line for line in said.replace("<tr>", "\n").splitlines() if begin in line)


@pytest.mark.parametrize(
    "shown",
    [text, lambda result: document(result, {}, None, None), result_html],
    ids=["terminal", "report", "notebook"],
)
def test_a_measure_without_a_range_says_so(shown: Callable[[Result], str]) -> None:
    """Companions keep no rows for sliding and shaking forces; those of forces and mean powers have ranges."""
    said, result = shown(loose()), loose()
    assert (
        not result.measures["B.sliding_velocity.max"].estimated
        and result.measures["crank.power.mean"].estimated
    )
    assert (
        result.measures["B.force.max"].estimated
        and WORDS not in line(said, "mean power").split("mean power")[1]
    )
    if shown is result_html:
        assert line(said, "Shaking force").count(WORDS) == 1
        return
    assert line(said, "shaken by at least").count(WORDS) >= 1  # the moment's may stand on the next line
    if shown is text:
        assert WORDS not in line(said, " B  ").split("mm/s")[0].split("m/s")[0]


def test_in_json() -> None:
    told = json.loads(json.dumps(loose().summary))
    assert "B.sliding_velocity.max" in told["not_estimated"] and "B.force.max" not in told["not_estimated"]
    assert (
        told["ranges"]["B.sliding_velocity.max"]["estimated"] is False
        and told["ranges"]["B.force.max"]["estimated"] is True
    )
    assert isinstance(told["ranges"]["B.sliding_velocity.max"]["low"], float)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (
            {"companions": 0},
            "it was not repeated with smaller steps, because its settings exclude that (companions = 0)",
        ),
        ({"loop": "data-driven"}, "that takes the generated loop, and this was the data-driven one"),
    ],
)
def test_a_smooth_run_without_any_says_why(options: dict, why: str) -> None:
    result = vfife.simulate(gallery.scotch_yoke(), **options)
    said = text(result)
    assert f"{WORDS}: {why}" in " ".join(said.split()) and set(result.summary["not_estimated"]) == set(
        result.measures
    )
    assert WORDS in document(result, {}, None, None)


def test_a_run_with_play_in_another_loop_says_what_that_changes() -> None:
    """It has no ranges and another automatic step; with a number of companions it has both."""
    m = with_settings(gallery.four_bar_case_c(), turns=0.05)
    default, other, same = (
        vfife.simulate(m, reference=False, **options)
        for options in ({}, {"loop": "data-driven"}, {"loop": "data-driven", "companions": 3})
    )
    assert "data-driven loop runs companions only if" in " ".join(text(other).split())
    assert default.record.assembly.choice.step != other.record.assembly.choice.step
    assert default.record.assembly.choice.step == same.record.assembly.choice.step
    assert {name: (one, one.low, one.high) for name, one in default.measures.items()} == {
        name: (one, one.low, one.high) for name, one in same.measures.items()
    }


def rigid_statics() -> Mechanism:
    """A mass that rests on a spring."""
    m = Mechanism("bob", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point_mass("bob", mass=2.0, position=(0.0, -0.5))
    m.spring("coil", "ground.O", "bob.center", stiffness=2e4, free_length=0.5)
    return with_settings(m, analysis="static")


@pytest.mark.parametrize(
    ("build", "options", "why"),
    [
        (gallery.lee_frame, {"companions": 0}, "companions = 0 excludes the repetition on other meshes."),
        (rigid_statics, {}, "no body is cut into elements"),
    ],
)
def test_statics_without_ranges_name_the_one_reason(build, options: dict, why: str) -> None:
    said = " ".join(text(vfife.simulate(build(), **options)).split())
    assert f"Errors are not estimated: {why}" in said and "or it is long" not in said


def test_a_run_with_play_and_no_companions_says_why() -> None:
    result = vfife.simulate(
        with_settings(gallery.four_bar_case_c(), turns=0.2), step=1e-5, companions=0, reference=False
    )
    assert f"{WORDS}: it has no companions" in " ".join(text(result).split())


def test_ranges_of_elastic_bodies_are_those_of_the_step() -> None:
    said = " ".join(text(vfife.simulate(gallery.elastic_pendulum())).split())
    clause = "the mesh of rod (12 elements) is not covered: compare --set body.rod.elements=24"
    assert f"ranges are those of the step; {clause}" in said
    assert "mesh" not in text(vfife.simulate(gallery.scotch_yoke()))


@pytest.mark.system("runs with companions of several widths")
def test_a_small_range_is_no_range_of_nothing() -> None:
    said = text(vfife.simulate(gallery.six_bar_press()))
    assert "within 0.01 %" in said and "± 0.00 %" not in said


def test_bounds_in_words() -> None:
    ranges = {
        "a": {"low": 9.94, "high": 10.06},
        "b": {"low": 3.0, "high": 3.0},
        "c": {"low": 1.0, "high": 1.0},
    }
    told = {"measures": {"a": 10.0, "b": 3.0, "c": 1.0, "d": 2.0}, "ranges": ranges}
    assert [range_text(told | {"not_estimated": ["b", "d"]}, name) for name in "abcd"] == [
        "9.94 to 10.06",
        WORDS,
        "exact",
        WORDS,
    ]
    assert [is_estimated(told, name) for name in "abcd"] == [
        True,
        False,
        False,
        False,
    ]  # a file of a former version


def test_statics_whose_other_meshes_failed_say_that() -> None:
    """Asked for, but without an estimate; also of a run file."""
    summary = vfife.simulate(gallery.lee_frame(), companions=0).summary
    said = missing_mesh_estimate(summary | {"run": summary["run"] | {"refined": True}})
    assert said == "the repetition with twice the elements found no equilibrium or was interrupted"
    assert summary["run"]["refined"] is False
