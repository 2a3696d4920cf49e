"""Dead centres of bodies on guides: their positions, against those of the ideal mechanism."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import vfife
from vfife import gallery
from vfife.measures.output_intervals import missed_end
from vfife.modelfile import loads
from vfife.report import dead_centres
from vfife.report.overview import overview
from vfife.report.run import document
from vfife.report.run_file import info
from vfife.report.terminal import as_text

PRESS = """
name = "crank press"
gravity = [0, "-9.81 m/s^2"]
[run]
turns = 2
outputs = 360
[ground]
O = [0, 0]
[body.crank]
length = "25 mm"
mass = "3 kg"
angle = "90 deg"
[body.rod]
length = "265 mm"
mass = "4 kg"
angle = "-90 deg"
[body.ram]
mass = "30 kg"
inertia = "0.1 kg m^2"
position = [0, "-240 mm"]
[joint.main]
bearing = "ground.O"
journal = "crank.start"
[joint.big]
bearing = "rod.start"
journal = "crank.end"
[joint.small]
kind = "clearance"
bearing = "rod.end"
journal = "ram.center"
clearance = "0.2 mm"
bearing_radius = "20 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.3 }
friction = { law = "none" }
[joint.guide]
kind = "slider"
bearing = "ground.O"
journal = "ram.center"
direction = [0, 1]
[driver.crank]
speed = "10 rad/s"
"""


@cache
def press() -> vfife.Result:
    return vfife.simulate(loads(PRESS), companions=1)


def entry(summary: dict[str, Any], end: str) -> dict[str, Any]:
    (one,) = (one for one in summary["dead_centres"] if one["name"] == f"{end} dead centre")
    return one


def test_a_hanging_ram_ends_its_stroke_below_the_ideal_ends_by_the_clearance() -> None:
    summary = press().summary
    bottom, top = entry(summary, "bottom"), entry(summary, "top")
    assert (bottom["ideal"], top["ideal"]) == pytest.approx((-0.29, -0.24), abs=1e-6)
    assert bottom["body"] == "ram" and bottom["position"] == press().measures["guide.position.low"]
    # The ram hangs on its pin, too low by the clearance at both ends.
    assert bottom["short"] == pytest.approx(-0.2e-3, abs=0.03e-3)
    assert top["short"] == pytest.approx(0.2e-3, abs=0.03e-3)
    assert 0.0 < bottom["missed"] < 1e-4


def test_the_answers_state_the_ends_and_their_error() -> None:
    summary = press().summary
    short, long = (as_text(make(summary), 250) for make in (overview, document))
    assert short.count("Dead centres ram") == 1 and "not estimated" in short
    file = {"file": "run.sqlite", "bytes": 1, "model": "", "source": None, "status": "complete", "damage": []}
    file |= {
        "finished": "now",
        "created": "now",
        "written_by": None,
        "step": None,
        "static": False,
        "laws": {},
    }
    file |= {"outputs": 1, "channels": [], "checkpoint": None, "reference": True, "wall_s": None}
    file |= {
        "loop": "machine",
        "versions": {},
        "own_laws": [],
        "checked": True,
        "events": [],
        "summary": summary,
    }
    measures = " ".join(as_text(info(file, measures=True), 250).split())
    for answer in (" ".join(long.split()), measures):
        assert "bottom dead centre" in answer and "outputs miss up to" in answer
        assert "beyond the ideal" in answer and "short of the" in answer


def test_digits_follow_the_difference_and_end_at_the_error() -> None:
    summary = copy.deepcopy(press().summary)
    one = entry(summary, "bottom")
    one |= {"position": -0.289_834_567, "ideal": -0.290_004_5, "short": 0.169_933e-3, "missed": 1e-7}
    text = dict(dead_centres.facts(summary))["Dead centres ram"]
    assert "bottom -289.83 mm (ideal -290.00)" in text
    one["missed"] = 0.2e-3
    assert "bottom -289.8 mm (ideal -290.0)" in dict(dead_centres.facts(summary))["Dead centres ram"]


def test_an_end_at_the_origin_is_no_negative_zero() -> None:
    """A top dead centre 2 µm below the origin is at 0.00 mm where the digits end at hundredths."""
    summary = copy.deepcopy(press().summary)
    entry(summary, "top").update(position=-2e-6, ideal=-1e-6, short=1e-6, missed=1e-5)
    assert "top 0.00 mm (ideal 0.00)" in dict(dead_centres.facts(summary))["Dead centres ram"]


def test_only_bodies_on_guides_have_dead_centres() -> None:
    four_bar = vfife.simulate(gallery.four_bar(), turns=0.1).summary
    assert four_bar["dead_centres"] == [] and "Dead centres" not in as_text(overview(four_bar))
    part = vfife.simulate(loads(PRESS), turns=0.25, companions=1).summary
    assert {one["name"] for one in part["dead_centres"]} == {"lowest position", "highest position"}
    del part["dead_centres"]  # as in a summary of a former version
    assert "Travel" not in as_text(overview(part))


def test_an_error_does_not_name_steps_whose_changes_are_unknown() -> None:
    summary = copy.deepcopy(press().summary)
    one = entry(summary, "bottom")
    at = one["position"]
    spread = {"low": at, "high": at, "lowest": at, "highest": at + 1e-6}
    summary["turns"] = summary["turns"] | {"motion": "periodic", "period": 1}
    summary["ranges"] = summary["ranges"] | {one["measure"]: spread}
    summary["not_estimated"] = [one["measure"]]
    (text,) = (text for _, text in dead_centres.lines(summary) if one["measure"] in text)
    assert "over turns, outputs miss" in text and "change with the step not estimated" in text
    assert "steps" not in text
    summary["not_estimated"] = []
    (text,) = (text for _, text in dead_centres.lines(summary) if one["measure"] in text)
    assert "over turns or steps, outputs miss" in text and "not estimated" not in text


@pytest.mark.parametrize("phase", [0.0, 0.13, 0.5, 0.77])
@pytest.mark.parametrize(
    "curve", [lambda x: -x * x, lambda x: -np.abs(x), lambda x: -np.maximum(x, -2.0 * x)]
)
def test_outputs_miss_an_end_by_no_more_than_is_said(curve: Callable[[Any], Any], phase: float) -> None:
    """A parabola, and slopes that jump; the true end is 0."""
    values = curve(np.arange(-6.0, 7.0) + phase)
    for sign in (1.0, -1.0):
        bound = missed_end(sign * values, slice(0, len(values)), sign)
        assert -values.max() <= bound <= 2.0 * np.abs(np.diff(values)).max()


def test_impacts_elsewhere_do_not_blur_the_ends_of_a_stroke() -> None:
    """The largest acceleration is that of an impact; around the ends the stroke is smooth."""
    fine = vfife.simulate(loads(PRESS), companions=0, outputs=7200).summary
    coarse = vfife.simulate(loads(PRESS), companions=0).summary
    for end in ("bottom", "top"):
        shown, truth = entry(coarse, end), entry(fine, end)
        assert shown["missed"] < 20e-6
        assert abs(shown["position"] - truth["position"]) <= shown["missed"]


def test_a_difference_smaller_than_rounding_of_the_turns_is_not_shown() -> None:
    summary = copy.deepcopy(press().summary)
    one = entry(summary, "bottom")
    spread = {"low": one["position"], "high": one["position"] + 1e-15, "lowest": 0.0, "highest": 0.0}
    summary["ranges"] = summary["ranges"] | {one["measure"]: spread}
    (text,) = (text for _, text in dead_centres.lines(summary) if one["measure"] in text)
    assert "e-1" not in text and "(outputs miss up to" in text
