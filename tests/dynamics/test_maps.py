"""Sweeps: exponents against the closed form of a damped oscillator, the way up against runs of their own,
files that go on.
"""

import importlib
import math

import numpy as np
import pytest

import vfife
from vfife.dynamics import load_map
from vfife.dynamics.bifurcation import bifurcation
from vfife.dynamics.maps import unit_at
from vfife.errors import ModelError, VfifeError
from vfife.modelfile import load
from vfife.simulation.turn_steps import step_count

EXAMPLES = "examples"
SPEED = 20.0


def oscillator(damping: float = 1.2) -> vfife.Mechanism:
    """A block on a spring beside a crank that turns: mass 2 kg, stiffness 800 N/m."""
    m = vfife.Mechanism("oscillator")
    m.point("O", 0.0, 0.0)
    m.point("P", 0.0, 1.0)
    m.link("crank", length=0.1, mass=0.1)
    m.revolute("O", "ground.O", "crank.start")
    m.drive("crank", speed=SPEED)
    m.rigid_body("block", mass=2.0, inertia=0.01, position=(0.3, 1.0), pins={"pin": (0.0, 0.0)})
    m.slider("guide", "ground.P", "block.pin")
    m.spring("spring", "ground.P", "block.pin", stiffness=800.0, damping=damping, free_length=0.2)
    return m


def test_a_damped_oscillator_forgets_as_its_closed_form_says():
    """Differences die with exp(-c t / 2 m), whatever the start: the exponent of a turn is -c T / 2 m."""
    found = bifurcation(
        oscillator(),
        "spring.spring.damping",
        1.0,
        2.0,
        count=3,
        turns=40,
        dropped=20,
        step=2e-4,
        series=["block.x"],
        companions=0,
    )
    for way in range(2):
        for k, damping in enumerate((1.0, 1.5, 2.0)):
            assert found.exponents[way, k, 0] == pytest.approx(
                -damping / 4.0 * 2.0 * math.pi / SPEED, rel=0.03
            )


def loose() -> vfife.Mechanism:
    """A slider-crank whose pin strikes its bearing, by coarse steps."""
    return load(f"{EXAMPLES}/slider_crank_loose_pin.toml", set=[("joint.pin.contact.restitution", 0.3)])


GIVEN = {"count": 3, "turns": 4, "dropped": 2, "step": 1e-5, "companions": 0}


def test_the_first_value_is_the_run_of_its_own() -> None:
    """The way up begins as a simulation does, whose first turn nobody looks at; the bits are those."""
    path = "joint.pin.clearance"
    found = bifurcation(loose(), path, 2e-4, 3e-4, **GIVEN, series=["pin.force_max", "rod.angular_velocity"])
    m = load(
        f"{EXAMPLES}/slider_crank_loose_pin.toml", set=[("joint.pin.contact.restitution", 0.3), (path, 2e-4)]
    )
    step = 2.0 * math.pi / 100.0 / found.spec.steps
    alone = vfife.simulate(m, turns=5, outputs=1, step=step, companions=0, reference=False, force_step=True)
    for name in found.spec.series:
        own = alone.series[name].values
        assert np.array_equal(found.points[name][0, 0], own[4:6])
    assert (
        found.points["pin.force_max"].shape == (2, 3, 2) and not np.isnan(found.points["pin.force_max"]).any()
    )


def test_a_phase_is_so_much_of_a_turn_later() -> None:
    """A quarter of a turn later stand the bits of a run's outputs a quarter of a turn later."""
    path = "joint.pin.clearance"
    found = bifurcation(
        loose(), path, 2e-4, 3e-4, **{**GIVEN, "count": 2}, series=["rod.angular_velocity"], phase=0.25
    )
    assert found.spec.steps % 4 == 0
    m = load(
        f"{EXAMPLES}/slider_crank_loose_pin.toml", set=[("joint.pin.contact.restitution", 0.3), (path, 2e-4)]
    )
    step = 2.0 * math.pi / 100.0 / found.spec.steps
    alone = vfife.simulate(m, turns=6, outputs=4, step=step, companions=0, reference=False, force_step=True)
    own = alone.series["rod.angular_velocity"].values
    assert np.array_equal(found.points["rod.angular_velocity"][0, 0], own[[4 * 4 + 1, 5 * 4 + 1]])


@pytest.mark.system("breaks a map off")
def test_a_map_goes_on_where_it_was_broken_off(tmp_path) -> None:
    """To the bit; what asks something else is not touched."""
    given = {**GIVEN, "companions": 1}
    whole = bifurcation(loose(), "joint.pin.clearance", 2e-4, 3e-4, **given, file=tmp_path / "whole.map")

    def stop(done: int, count: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    part = bifurcation(
        loose(), "joint.pin.clearance", 2e-4, 3e-4, **given, file=tmp_path / "a.map", progress=stop
    )
    assert part.done == 1 and np.isnan(part.points["pin.force_max"][0, 1:]).all()
    calls = []
    rest = bifurcation(
        loose(),
        "joint.pin.clearance",
        2e-4,
        3e-4,
        **given,
        file=tmp_path / "a.map",
        progress=lambda *at: calls.append(at),
    )
    assert calls == [(2, 3), (3, 3)]
    again = load_map(tmp_path / "a.map")
    for found in (rest, again):
        assert all(np.array_equal(found.points[name], whole.points[name]) for name in whole.points)
        assert (
            np.array_equal(found.exponents, whole.exponents)
            and found.kinds == whole.kinds
            and found.companions == whole.companions
        )
    before = (tmp_path / "a.map").read_bytes()
    with pytest.raises(VfifeError, match="with another specification"):
        bifurcation(loose(), "joint.pin.clearance", 2e-4, 4e-4, **given, file=tmp_path / "a.map")
    assert (tmp_path / "a.map").read_bytes() == before


def test_a_map_without_a_complete_value_is_shown(tmp_path, monkeypatch) -> None:
    """The call returns it although Ctrl-C came before its first value."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(importlib.import_module("vfife.dynamics.bifurcation"), "from_neighbours", stop)
    part = bifurcation(loose(), "joint.pin.clearance", 2e-4, 3e-4, **GIVEN, file=tmp_path / "a.map")
    for found in (part, load_map(tmp_path / "a.map")):
        assert found.done == 0 and "nothing recorded yet: none of 3 values is complete" in str(found)
        assert found.plot() and len(list(found.table())) == 1


def test_values_go_side_by_side_as_each_does_alone(monkeypatch) -> None:
    """Points to the bit, growth to what the order of sums leaves, wherever their clocks are."""
    path, given = "joint.pin.clearance", {**GIVEN, "companions": 1}
    both = bifurcation(loose(), path, 2e-4, 3e-4, **given)
    monkeypatch.setattr("vfife.solvers.turn_runner.VALUES_AT_ONCE", 1)
    alone = bifurcation(loose(), path, 2e-4, 3e-4, **given)
    assert (
        all(np.array_equal(both.points[name], alone.points[name]) for name in both.points)
        and both.companions == alone.companions
    )
    assert np.allclose(both.growth, alone.growth, rtol=0.0, atol=1e-9) and len(both.companions) == 4


def test_a_table_has_every_point(tmp_path) -> None:
    found = bifurcation(loose(), "joint.pin.clearance", "0.2 mm", "0.3 mm", **GIVEN)
    assert (found.spec.values[0], found.spec.values[-1]) == (2e-4, 3e-4)
    found.write_csv(tmp_path / "all.csv")
    lines = (tmp_path / "all.csv").read_text().splitlines()
    assert len(lines) == 1 + 2 * 3 * 2 and lines[0].startswith("joint.pin.clearance,way,turn,pin.penetration")


@pytest.mark.parametrize("path, words, said", [
    ("body.rod.length", {}, "have moved in their bodies"),
    ("joint.pin.clearance", {"series": ["pin.forc"]}, "pin.force"),
    ("joint.pin.clearance", {"turns": 2}, "no turn remains"),
    ("joint.pin.clearence", {}, "clearance"),
    ("joint.pin.clearance", {"turns": "10"}, "turns"),
    ("joint.pin.clearance", {"low": "2 s"}, "low"),
])  # fmt: skip
def test_what_cannot_be_swept_is_told(path, words, said) -> None:
    with pytest.raises(ModelError, match=said):
        ends = {"low": 2e-4, "high": 3e-4} if "pin" in path else {"low": 0.12, "high": 0.13}
        bifurcation(loose(), path, **{**GIVEN, **ends, **words})


def test_a_number_has_its_unit_wherever_it_stands() -> None:
    places = {
        "ground.P.0": "m",
        "material.steel.density": "kg/m^3",
        "spring.spring.damping": "N s/m",
        "driver.crank.speed": "rad/s",
    }
    assert {path: unit_at(oscillator(), path) for path in places} == places
    with pytest.raises(ValueError, match="density"):
        unit_at(oscillator(), "material.steel.densty")


def test_steps_are_counted_anew_for_another_question() -> None:
    """What is known of one model is not said of another, nor of another step."""
    one, stiff = (
        load(f"{EXAMPLES}/slider_crank_loose_pin.toml", set=[("joint.pin.contact.stiffness", value)])
        for value in (1e9, 4e9)
    )
    counts = [
        step_count([model], step) for model, step in ((one, None), (stiff, None), (one, 1e-5), (one, None))
    ]
    assert counts[0] == counts[3] and counts[1] > 1.5 * counts[0] and counts[2] == math.ceil(2e3 * math.pi)
