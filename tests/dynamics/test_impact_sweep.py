"""A sweep of an impact oscillator, whose model has no contact in its first turns."""

from __future__ import annotations

import numpy as np
import pytest

import vfife
from vfife.dynamics.series import motion_ranges


def impact_oscillator(speed: float = 24.0) -> vfife.Mechanism:
    """A mass of 1 kg on a spring of 400 N/m to a base that a scotch yoke shakes by 2 mm, between walls at
    8 mm.
    """
    m = vfife.Mechanism("impact oscillator")
    wall = {"law": "kelvin-voigt", "stiffness": 4e5, "damping_coefficient": 40.0}
    m.point("O", 0.0, 0.0)
    m.link("rotor", length=2e-3, mass=0.1, angle="-90 deg")
    m.revolute("O", "ground.O", "rotor.start")
    m.rigid_body("base", mass=1.0, inertia=1e-3, pins={"slot": (0, 0), "far": (0.2, 0), "anchor": (-0.5, 0)})
    m.slider("slot", "base.slot", "rotor.end", direction=(0, 1), turning=True)
    m.slider("guide", "ground.O", "base.far")
    m.rigid_body("mass", mass=1.0, inertia=1e-3, position=(0, 0), pins={"c": (0, 0)})
    m.point("T", -1.0, 0.0)
    m.slider("track", "ground.T", "mass.c")
    m.spring("k", "base.anchor", "mass.c", stiffness=400.0, damping=2.0, free_length=0.5)
    for name, side in (("right", 1.0), ("left", -1.0)):
        m.point(name, side * 0.018, 0.0)
        m.external_contact(
            name, f"ground.{name}", "mass.c", journal_radius=0.01, direction=(0, side), contact=wall,
            friction="none",
        )  # fmt: skip
    m.drive("rotor", speed=speed)
    return m


def test_points_that_scatter_with_the_step_have_one_period_along_a_whole_sweep() -> None:
    """Its own integration with events has two impacts a turn there, equal in all turns within 1e-5."""
    result = vfife.bifurcation(
        impact_oscillator(), "driver.rotor.speed", 21.0, 22.0, count=6, turns=60, companions=0
    )
    ranges = motion_ranges(result.spec, np.array([[0.0, 26.0], [0.0, 28.0]]))
    assert result.spec.series == ("left.penetration", "left.force_max") and ranges[1] == 28.0
    assert {kind for way in result.kinds for kind in way} == {"period 1"}
    scattered = [motion.scatter for way in result.verdicts for motion in way]
    assert 0.0 < np.nanmax(scattered) < 1e-3, "some values scatter, or nothing is tested"


@pytest.mark.parametrize(("speed", "turns"), [(21.0, 16), (21.0, 20), (22.0, 20)])
def test_a_run_that_still_approaches_its_limit_is_not_called_not_periodic(speed: float, turns: int) -> None:
    """Its turns had nothing in common for ten turns, and their distances halve every other turn then."""
    result = vfife.simulate(impact_oscillator(speed), turns=turns, outputs=720, companions=0)
    assert result.motion.motion == "settling" and result.motion.first == turns
    assert "The motion still settles: its turns do not repeat yet" in str(
        result
    ) and "longer transient" not in str(result)
