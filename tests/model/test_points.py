"""Points of bodies are all their pins, those that are given and those that every body of its kind has."""

from __future__ import annotations

from vfife.model.bodies import Link, RigidBody

PIN = {"p": (0.1, 0.0)}


def test_points_are_all_and_pins_are_those_given() -> None:
    link, plate = (
        Link(name="a", length=2.0, pins=PIN),
        RigidBody(name="b", mass=1.0, inertia=1.0, pins=PIN, center=(0.5, 0.0)),
    )
    assert link.points == {"start": (0.0, 0.0), "end": (2.0, 0.0), **PIN}
    assert plate.points == {"center": (0.5, 0.0), **PIN}
