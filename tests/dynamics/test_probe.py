"""What is found out before a map: the step that a run finds, and series that vary."""

import dataclasses

import numpy as np
import pytest

import vfife
from mechanisms import snapping
from vfife.assembly.assemble import assemble
from vfife.dynamics.basins import basins
from vfife.dynamics.bifurcation import bifurcation
from vfife.dynamics.maps import TurnRun, models_along
from vfife.dynamics.sections import poincare_section
from vfife.dynamics.series import default_series, variations
from vfife.dynamics.start_states import StartStates, refuse_contradiction
from vfife.errors import ModelError
from vfife.modelfile import load
from vfife.results.run_data import standing
from vfife.simulation import turn_steps
from vfife.simulation.turn_steps import SEARCH_TURNS, run_step, step_count

LOOSE, GUIDE = "examples/slider_crank_loose_pin.toml", "examples/slider_crank_loose_guide.toml"


def light(scale: float = 0.1) -> vfife.Mechanism:
    """The slider-crank with a loose pin whose parts have a tenth of their moments of inertia."""
    return load(
        LOOSE,
        set=[
            ("body.crank.inertia", 1e-4 * scale),
            ("body.rod.inertia", 2.5e-4 * scale),
            ("body.block.inertia", 1e-4 * scale),
        ],
    )


def steps_of_a_run(model: vfife.Mechanism) -> int:
    """Steps in a turn of a run of the model, which are more than those that it tries first."""
    choice = vfife.simulate(model, turns=SEARCH_TURNS).record.assembly.choice
    assert choice.tried and choice.tried[0][0] > 1.9 * choice.step, (
        "its run halves its step, or this test says nothing"
    )
    return round(choice.turn / choice.step)


@pytest.mark.system("runs a map and its runs one by one")
def test_a_map_takes_the_step_that_a_run_finds(monkeypatch) -> None:
    """Sections, sweeps and basins: not the step that a run tries first."""
    steps = steps_of_a_run(light())
    assert step_count([light()], None, search=True) == steps
    monkeypatch.setattr("vfife.dynamics.sections.Sectioning.pieces", lambda *_: iter(()))
    assert poincare_section(light(), turns=2, dropped=0).spec.steps == steps
    monkeypatch.setattr(turn_steps, "run_step", lambda model: 1e-5)
    assert poincare_section(light(0.2), turns=2, dropped=0).spec.steps == int(np.ceil(2e3 * np.pi))
    grid = ("start.crank", 0.0, 1.0), ("start.pin.vx", 0.0, 0.1)
    assert TurnRun("basins", 2, dropped=1).step_count(models_along(light(0.3), grid)) == int(
        np.ceil(2e3 * np.pi)
    )


def test_the_step_of_a_sweep_is_the_finest_of_ends_and_middle(monkeypatch) -> None:
    """Of a grid: of its corners and its middle. What was found is known when it is asked for again."""
    sizes = iter((4e-5, 3e-5, 1e-5))
    monkeypatch.setattr(turn_steps, "run_step", lambda model: next(sizes))
    monkeypatch.setattr(turn_steps, "COUNTS", type(turn_steps.COUNTS)())
    given = {"count": 2, "turns": 2, "dropped": 1, "companions": 0}
    turn = 2.0 * np.pi / 100.0
    assert bifurcation(light(), "joint.pin.clearance", 2e-4, 3e-4, **given).spec.steps == int(
        np.ceil(turn / 1e-5)
    )
    assert len(models_along(light(), (("joint.pin.clearance", 1e-4, 2e-4), ("body.rod.mass", 0.1, 0.2)))) == 5
    assert len(models_along(light(), (("start.crank", 0.0, 1.0), ("joint.pin.clearance", 1e-4, 2e-4)))) == 3
    known = step_count(models_along(light(), (("joint.pin.clearance", 2e-4, 3e-4),)), None, search=True)
    assert known == int(np.ceil(turn / 1e-5)), "a command asks for its forecast first"
    with pytest.raises(StopIteration):
        step_count([light(0.2)], None, search=True)


def test_what_is_not_written_out_is_refused_before_it_is_run(monkeypatch) -> None:
    monkeypatch.setattr("vfife.simulation.turn_steps.choose_loop", lambda *_: "data-driven")
    monkeypatch.setattr(
        "vfife.simulation.turn_steps.run_prepared", lambda *_: pytest.fail("a large frame takes minutes")
    )
    with pytest.raises(ModelError, match="not swept"):
        run_step(light())


def first(model: vfife.Mechanism, steps: int = 20_000):
    return assemble(model, 2.0 * np.pi / 20.0 / steps, turns=1, outputs=1, force_step=True)


def test_the_usual_series_varies() -> None:
    """The block does not turn, and the crank goes round at constant speed: what varies is
    where the block is.
    """
    assembly = first(snapping())
    assert default_series(assembly) == ("block.x",)
    found = variations(assembly, [("block.angular_velocity", "crank.angular_velocity"), ("block.x",)])
    assert (
        found["block.angular_velocity"] == 0.0
        and found["crank.angular_velocity"] < 1e-9
        and found["block.x"] > 0.1
    )


def test_a_driven_crank_is_looked_at_only_where_nothing_else_moves() -> None:
    m = vfife.Mechanism("fan")
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.1, mass=0.1)
    m.revolute("O", "ground.O", "crank.start")
    m.drive("crank", speed=20.0)
    assert default_series(first(m)) in {("crank.x",), ("crank.y",)}
    long = snapping()
    long.bodies["crank"] = dataclasses.replace(
        long.bodies["crank"], length=10.0
    )  # it moves further than the block
    assert default_series(first(long)) == ("block.x",)


@pytest.mark.parametrize(
    "path, said",
    [(LOOSE, ("pin.penetration", "pin.force_max")), (GUIDE, ("guide.1.penetration", "guide.force_max"))],
)
def test_the_usual_series_of_a_joint_with_play(path, said) -> None:
    """Also of one with several places of contact, which has no penetration of its own."""
    model = load(path)
    assert default_series(assemble(model, 1e-5, turns=1, outputs=1, force_step=True)) == said


def sides(path: str, low: float, high: float) -> np.ndarray:
    """On which side a block in a double well comes to rest, over its first velocity and another number, shape
    (velocities, numbers).
    """
    x, y = (path, low, high), ("body.block.velocity.0", -4.0, 4.0)
    found = basins(
        snapping(), x, y, count=(3, 4), turns=12, dropped=8, step=1e-3, companions=0, exponents=False
    )
    ends = np.array([found.points[k][-1, 0] for k in range(12)]).reshape(4, 3)
    assert np.abs(ends) == pytest.approx(np.sqrt(1.1**2 - 1.0), rel=1e-2)
    return np.sign(ends)


@pytest.mark.system("runs a map and its runs one by one")
def test_a_velocity_of_a_body_counts_beside_the_start_of_the_crank() -> None:
    """The block's velocity decides to which side it comes, wherever the crank stands, which has nothing to do
    with it.
    """
    alone = sides("body.crank.mass", 0.1, 0.2)
    turned = sides("start.crank", 0.0, 3.0)
    assert {*alone[:, 0]} == {-1.0, 1.0} and np.array_equal(turned, np.repeat(alone[:, :1], 3, axis=1))


def test_the_velocity_of_a_start_is_that_of_the_body() -> None:
    """With the crank turned on, the block has the velocity that the model gives it, and the crank its own."""
    model = snapping()
    model.bodies["block"] = dataclasses.replace(model.bodies["block"], velocity=(2.5, 0.0, 0.0))
    series = standing(StartStates(model, 2000).at({"start.crank": 1.0})).series
    assert float(series["block.u"][0]) == pytest.approx(2.5, rel=1e-6) and float(
        series["crank.w"][0]
    ) == pytest.approx(20.0, rel=1e-6)


def test_a_velocity_that_is_given_twice_is_refused() -> None:
    """Of a body as its own, and by that of its journal; the velocities of two bodies do not contradict each
    other.
    """
    model = load(LOOSE)
    for name in ("crank", "rod", "block"):
        model.bodies[name] = dataclasses.replace(model.bodies[name], velocity=(0.1, 0.0, 0.0))
    grid = {"count": (2, 2), "turns": 2, "dropped": 1, "step": 1e-5, "companions": 0}
    with pytest.raises(ModelError, match="follows from that of the body's journal"):
        basins(model, ("start.pin.vx", 0.0, 0.1), ("body.block.velocity.0", 0.0, 0.1), **grid)
    with pytest.raises(ModelError, match="follows from that of the body's journal"):
        starts = [{"start.pin.vy": 0.1, "body.rod.velocity.0": 0.2}]
        bifurcation(
            model,
            "joint.pin.clearance",
            2e-4,
            3e-4,
            count=2,
            turns=2,
            dropped=1,
            step=1e-5,
            companions=0,
            starts=starts,
        )
    refuse_contradiction(model, ("start.pin.vx", "body.crank.velocity.0"))
