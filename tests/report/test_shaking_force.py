"""The largest force on the ground is that at the outputs: with contact the text says so, and its bound."""

from __future__ import annotations

import math

import pytest

import vfife
from vfife.modelfile import loads
from vfife.numerics.outward import UP
from vfife.report.amounts import prefixed
from vfife.report.digits import shaking_text
from vfife.report.run import document
from vfife.report.summary import run_summary, summary_text
from vfife.report.terminal import as_text

PAIR = "examples/slider_crank_loose_pin.toml"
SOLE = """
name = "hanging body"
gravity = [0, "-9.81 m/s^2"]
[run]
duration = "0.1 s"
outputs = 50
[ground]
O = [0, 0]
[body.a]
length = "200 mm"
mass = "0.5 kg"
angle = "-60 deg"
[joint.O]
kind = "clearance"
bearing = "ground.O"
journal = "a.start"
clearance = "0.1 mm"
bearing_radius = "10 mm"
contact = { law = "lankarani-nikravesh", restitution = 0.7 }
friction = { law = "ambrosio", coefficient = 0.1, v0 = "1e-4 m/s", v1 = "1e-2 m/s" }
"""


def shaking(text: str) -> str:
    return next(line for line in text.splitlines() if line.startswith("Shaking force"))


def test_the_force_of_the_only_joint_on_the_ground_is_the_shaking_force() -> None:
    """Fifty outputs miss the impacts; the joint keeps its largest force of all steps."""
    result = vfife.simulate(loads(SOLE))
    force, sampled = result.measures["O.force.max"], result.measures["ground.shaking_force.max"]
    assert sampled < 0.5 * force
    summary = run_summary(result)
    assert summary["ground"] == {"at_most": force.high, "joint": "O", "estimate": pytest.approx(force)}
    line = shaking(summary_text(result))
    assert "(that of O)" in line and f"{sampled:.3g}" not in line


def test_outputs_bound_the_shaking_force_from_below_and_forces_of_joints_from_above() -> None:
    """The truth by forty times the outputs lies between both."""
    few = vfife.simulate(vfife.load(PAIR, {"run.outputs": 90}), turns=1)
    many = vfife.simulate(vfife.load(PAIR, {"run.outputs": 7200}), turns=1)
    name = "ground.shaking_force.max"
    bound = run_summary(few)["ground"]
    assert bound["joint"] is None and math.isfinite(bound["at_most"])
    assert few.measures[name] < many.measures[name] <= bound["at_most"]
    long = " ".join(as_text(document(run_summary(few)), 250).split())
    assert "shaken by at least" in long and "N (not estimated)" in long
    assert few.measures[name] < 0.5 * many.measures[name] < bound["estimate"] <= bound["at_most"]


@pytest.mark.parametrize("model", ["compressor", "slider_crank_loose_pin", "piston_slap"])
def test_peaks_between_outputs_are_estimated(model: str) -> None:
    """With 360 outputs a turn, the estimate is above the truth by twenty times as many, and by less than a
    tenth; the sum of all largest forces says nothing, where gas and main bearing cancel.
    """
    path, name = f"examples/{model}.toml", "ground.shaking_force.max"
    few, many = (vfife.simulate(vfife.load(path, {"run.outputs": n}), turns=1) for n in (360, 7200))
    summary = run_summary(few)
    ground, truth = summary["ground"], many.measures[name]
    assert truth <= ground["estimate"] < 1.1 * truth
    assert ground["estimate"] <= ground["at_most"]
    if model == "compressor":
        assert ground["at_most"] > 3.0 * truth
    assert f"about {prefixed(ground['estimate'], 'N', 0.0, UP)}" in shaking_text(summary)


def test_without_contact_the_value_has_a_range() -> None:
    result = vfife.simulate(vfife.gallery.four_bar_ideal(), duration=0.01)
    assert run_summary(result)["ground"] == {}
    assert "up to" in shaking(summary_text(result))
    assert result.measures["ground.shaking_force.max"] == pytest.approx(
        run_summary(result)["measures"]["ground.shaking_force.max"]
    )
