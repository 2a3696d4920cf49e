"""Every channel that is a component, a direction or a place says in which axes."""

import pytest

import mechanisms
from support import go
from vfife.results.channels import FRAMES
from vfife.simulation.result import Result

DIRECTED = ("_x", "_y", "angle", "theta", "_ax", "_ay", "_aw", "_u", "_v", "_w", "_vx", "_vy")


@pytest.fixture(scope="module")
def result() -> Result:
    return Result(go(mechanisms.everything(), 2e-6, duration=4e-4, outputs=4))


def test_every_direction_names_its_frame(result: Result) -> None:
    directed = [name for name in result.channels if name.endswith(DIRECTED)]
    assert {
        "joint_force_x",
        "contact_angle",
        "journal_contact_angle",
        "body_angle",
        "ground_shaking_force_x",
        "eccentricity_y",
    } <= set(directed)
    unnamed = [name for name in directed if result.channels[name].frame not in FRAMES]
    assert unnamed == []


def test_it_stands_in_the_data(result: Result) -> None:
    assert (
        result.data["contact_angle"]
        .attrs["frame"]
        .startswith("the axes of the body that carries the bearing")
    )
    assert result.data["slider_position"].attrs["frame"].startswith("along the guide")
    assert "frame" not in result.data["kinetic_energy"].attrs
