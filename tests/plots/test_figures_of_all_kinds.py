"""Pictures, tables and exports of every mechanism of the gallery, and of one that has every kind of joint and spring."""

from functools import cache
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import vfife
from vfife import gallery
from vfife.model.bodies import Section
from vfife.model.drivers import Torque
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.strokes import tangent, zigzag
from vfife.plots import figures
from vfife.plots.outlines import outline
from vfife.report.summary import show
from vfife.result import Result


def everything() -> Mechanism:
    """Every kind of joint, spring, gear and load beside each other."""
    m = Mechanism("everything", gravity=(0.0, -9.81))
    for name, x, y in (("A", 0.0, 0.0), ("B", 1.0, 0.0), ("C", 2.0, 0.0), ("W", 0.0, -0.5), ("G", 1.5, -0.8), ("E", 0.3, 0.8), ("F", 0.6, 0.8)):
        m.point(name, x, y)
    m.link("one", length=0.3, mass=1.0, angle=-0.3)
    m.link("two", length=0.3, mass=1.0, angle=0.5)
    m.revolute("a", "ground.A", "one.start")
    m.revolute("b", "ground.B", "two.start")
    m.gear("wheels", "one", "two", ratio=-0.5)
    for name, at in (("e", "E"), ("f", "F")):
        m.rigid_body(name, mass=1.0, inertia=0.01, position=m.points[at])
        m.revolute(name, f"ground.{at}", f"{name}.center")
    m.gear("belt", "e", "f", ratio=2.0)
    m.spring("coil", "one.end", "two.end", stiffness=300.0, damping=2.0, free_length=0.9)
    m.torsional_spring("spiral", "ground", "two", stiffness=2.0, damping=0.01)
    m.link("beam", length=0.5, model="elastic", elements=3, section=Section.round(0.004))
    m.weld("clamp", "ground.C", "beam.start")
    m.rigid_body("tip", mass=0.2, inertia=1e-3, position=(2.5, 0.0), pins={"q": (0.05, 0.02)})
    m.bushing("rubber", "beam.end", "tip.center", stiffness=(2e4, 2e4, 5.0), damping=(3.0, 3.0, 0.01))
    m.rigid_body("ball", mass=0.5, inertia=2e-4, position=(0.1, -0.44), velocity=(0.5, 0.0, 0.0))
    m.rigid_body("other", mass=0.5, inertia=2e-4, position=(0.5, -0.44), velocity=(-0.5, 0.0, 0.0))
    m.external_contact("floor", "ground.W", "ball.center", journal_radius=0.05, direction=(1.0, 0.0))
    m.external_contact("ledge", "ground.W", "other.center", journal_radius=0.05, direction=(1.0, 0.0))
    m.external_contact("balls", "ball.center", "other.center", journal_radius=0.05, bearing_radius=0.05)
    m.rigid_body("block", mass=0.5, inertia=1e-3, position=(1.5, -0.8))
    m.clearance_slider("guide", "ground.G", "block.center", clearance=1e-3, length=0.1, height=0.06)
    m.stop("cheeks", "ground", "one", low=-0.5, high=-0.2, stiffness=50.0, damping=0.1)
    m.loads["f"] = PointForce(name="f", at="tip.q", force=(0.0, 3.0), moment=0.1)
    m.drivers["one"] = Torque(body="one", value=(1.0, 0.0), speeds=(0.0, 50.0))
    return m


@cache
def run(name: str) -> Result:
    """A short run of it."""
    if name == "everything":
        return vfife.simulate(everything(), duration=0.02, step=2e-6, outputs=50, loop="data-driven")
    return vfife.simulate(getattr(gallery, name)(), loop="data-driven", reference=False)


def words(result: Result) -> set[str]:
    """What the legend of its drawing says."""
    return {text.get_text() for text in figures(result)["mechanism"].legends[0].get_texts()}


@pytest.mark.parametrize("name", [*gallery.__all__, "everything"])
def test_every_mechanism_is_drawn_told_and_exported(name: str, tmp_path: Path):
    result = run(name)
    found = figures(result)
    assert {"mechanism"} < set(found) and ("orbits" in found) == bool(result.record.assembly.mechanism.clearances)
    found["mechanism"].canvas.draw()
    for figure in found.values():
        assert all(line.get_xdata().size for ax in figure.axes if ax.get_visible() for line in ax.lines if not line.get_label().startswith("_"))
    console = Console(file=StringIO(), width=140)
    show(console, result)
    assert result.name in console.file.getvalue()
    result.to_netcdf(tmp_path / "out.nc")
    assert (tmp_path / "out.nc").stat().st_size > 1000


def test_every_kind_has_its_sign():
    assert words(run("everything")) >= {
        "ideal joint", "weld", "block with play", "contact", "spring", "torsional spring", "bushing", "stop", "gears, pitch circles",
        "wheels with a belt", "load", "one", "beam", "block",
    }  # fmt: skip
    assert {"ideal slider", "pin in a slot"} <= words(run("quick_return"))
    assert "joint with clearance" in words(run("four_bar_case_c"))


def test_joints_in_one_place_share_their_name():
    drawn = {text.get_text() for text in figures(run("squeezer"))["mechanism"].axes[0].texts}
    assert {"A5, A7", "E2, E4, E6", "O"} <= drawn


def test_forces_of_a_loose_guide_and_moments_of_gears_have_panels():
    assert figures(run("slider_crank_loose_guide"))["forces"].axes[0].get_title(loc="left") == "joint guide"
    assert {ax.get_title(loc="left") for ax in figures(run("gear_train"))["moments"].axes} == {"gear first-stage", "gear second-stage"}
    assert "forces" not in figures(run("elastica_circle"))  # what rounding leaves is no force


def test_a_large_frame_has_a_short_legend_and_no_more_panels_than_fit():
    result = vfife.simulate(gallery.williams_toggle(elements=60, drops=(0.05,)), loop="data-driven")
    assert words(result) == {"toggle", "weld", "load"}
    chain = Mechanism("chain", gravity=(0.0, -9.81))
    chain.point("O", 0.0, 0.0)
    for k in range(20):
        chain.link(f"l{k}", length=0.1, mass=0.1)
        chain.revolute(f"j{k}", "ground.O" if k == 0 else f"l{k - 1}.end", f"l{k}.start")
    found = figures(vfife.simulate(chain, duration=0.01, loop="data-driven"))
    legend = [text.get_text() for text in found["mechanism"].legends[0].get_texts()]
    assert "… and 9 more bodies" in legend and len(legend) < 15
    assert len(found["forces"].axes) == len(found["accelerations"].axes) == 16


def test_plates_are_convex_and_frames_do_not_run_across_gaps():
    corners = outline(run("jansen_leg"), "foot").path[0]
    assert len(corners) == 4 and np.array_equal(corners[0], corners[-1])
    path = outline(run("lee_frame"), "frame").path[0].reshape(-1, 3, 2)
    assert np.isnan(path[:, 2]).all()
    assert np.linalg.norm(path[:, 1] - path[:, 0], axis=1).max() < 0.13


def test_a_tangent_touches_both_circles_and_a_zigzag_ends_at_its_pins():
    first, second = (np.array([0.0, 0.0]), 0.3), (np.array([1.0, 0.4]), 0.1)
    ends = tangent(first, second, 1.0)
    along = ends[1] - ends[0]
    for (centre, radius), end in zip((first, second), ends, strict=True):
        assert np.linalg.norm(end - centre) == pytest.approx(radius)
        assert (end - centre) @ along == pytest.approx(0.0, abs=1e-12)
    line = zigzag(np.zeros(2), np.array([2.0, 0.0]), 0.1)
    assert line[0] == pytest.approx([0.0, 0.0]) and line[-1] == pytest.approx([2.0, 0.0])
    assert np.abs(line[:, 1]).max() == pytest.approx(0.1) and line[:, 1].sum() == pytest.approx(0.1, abs=0.11)
