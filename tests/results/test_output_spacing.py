"""Errors of what is reduced over outputs: those of contact forces depend on the outputs, not on the step
alone.
"""

from __future__ import annotations

import vfife
from vfife.report.study import document
from vfife.results.output_spacing import depends_on_outputs
from vfife.store.studyfile import REPEATS

MODEL = "examples/slider_crank_loose_pin.toml"
NAMES = ("pin.force.max", "rms(pin.force)", "range(rod.angle)", "max(pin.force_max)")


def test_only_forces_and_accelerations_of_mechanisms_with_contact_depend_on_outputs() -> None:
    units = {
        "rms(C.force)": "N",
        "mean(crank.torque)": "N m",
        "range(follower.angle)": "rad",
        "mean(kinetic_energy)": "J",
        "max(C.force_max)": "N",
        "C.force.max": "N",
        "ground.shaking_force.max": "N",
        "rod.angular_acceleration.max": "rad/s^2",
    }
    sampled = ["rms(C.force)", "mean(crank.torque)", "ground.shaking_force.max"]
    assert depends_on_outputs(units, {REPEATS: {"order": 1}}) == sampled
    assert depends_on_outputs(units, {REPEATS: {"order": 2}}) == depends_on_outputs(units, {}) == []


def test_a_study_gives_no_error_of_the_step_for_what_outputs_decide() -> None:
    """Twelve times the outputs change the rms by 40 %; its error by the step alone would be some per cent."""
    varied = {"joint.pin.clearance": [2e-4, 3e-4]}
    base = vfife.load_model(MODEL)
    coarse = vfife.study(base, varied, NAMES, turns=1)
    fine = vfife.study(vfife.load(MODEL, {"run.outputs": 8640}), varied, NAMES, turns=1)
    changes = abs(fine.values("rms(pin.force)") / coarse.values("rms(pin.force)") - 1.0)
    assert changes.max() > 0.1
    assert set(coarse.errors) == {"pin.force.max", "range(rod.angle)", "max(pin.force_max)"}
    told = document(coarse)
    assert told.data["sampled"] == ["rms(pin.force)"] and "rms(pin.force)" not in told.data["errors"]
    assert any("they depend on the outputs" in getattr(part, "text", "") for part in told.parts)
