"""Pictures, tables and exports of every mechanism of the gallery, and of one that has every kind of joint and
spring.
"""

from functools import cache
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure
from rich.console import Console

import gallery_runs
import vfife
from choice import default_cases
from drawn_texts import faults
from mechanisms import everything
from vfife import gallery
from vfife.model.drawing.strokes import tangent, zigzag
from vfife.plots import figures
from vfife.plots.motion import loose_guides
from vfife.plots.symbols import outline_of
from vfife.report.summary import show
from vfife.results.export import write_netcdf
from vfife.simulation.result import Result

# By default the model of every kind, and an ideal mechanism; other tests of this file draw four more.
DRAWN = ("everything", "quick_return")


@cache
def run(name: str) -> Result:
    """A short run of it."""
    if name == "everything":
        return vfife.simulate(everything(), duration=0.02, step=2e-6, outputs=50)
    return gallery_runs.run(name)


@cache
def drawn(name: str) -> dict[str, Figure]:
    """Its figures, which no test changes."""
    return figures(run(name))


def words(found: dict[str, Figure]) -> set[str]:
    """What the legend of its drawing says."""
    return {text.get_text() for text in found["mechanism"].legends[0].get_texts()}


def slim(data: xarray.Dataset) -> xarray.Dataset:
    """All names, the variables that the model of every kind has not, and of the others over the same names
    the first: each takes its time.
    """
    known = run("everything").data.data_vars
    first = {data[name].dims: name for name in reversed(list(data.data_vars))}
    return data[[name for name in data.data_vars if name not in known or first[data[name].dims] == name]]


@pytest.mark.parametrize(
    "name",
    default_cases([*gallery.__all__, "everything"], lambda name: name in DRAWN, "draws every mechanism"),
)
def test_every_mechanism_is_drawn_told_and_exported(name: str, tmp_path: Path):
    result, found = run(name), drawn(name)
    assert {"mechanism"} < set(found) and ("orbits" in found) == bool(
        result.record.assembly.mechanism.clearances
    )
    for figure in found.values():
        assert figure not in (found["mechanism"], found.get("forces")) or not faults(
            figure
        )  # the others are laid out like these
        assert all(
            line.get_xdata().size
            for ax in figure.axes
            if ax.get_visible()
            for line in ax.lines
            if not line.get_label().startswith("_")
        )
    console = Console(file=StringIO(), width=140)
    show(console, result)
    assert result.name in console.file.getvalue()
    if name == "everything":
        result.to_netcdf(tmp_path / "out.nc")
    else:
        write_netcdf(slim(result.data), tmp_path / "out.nc")
    assert (tmp_path / "out.nc").stat().st_size > 1000


def test_every_kind_has_its_sign():
    assert words(drawn("everything")) >= {
        "ideal joint", "weld", "block with clearance", "contact", "spring", "torsional spring", "bushing",
        "stop", "gears, pitch circles", "wheels with a belt", "load", "one", "beam", "block",
    }  # fmt: skip
    assert {"ideal slider", "pin in a slot"} <= words(drawn("quick_return"))
    assert "joint with clearance" in words(drawn("four_bar_case_c"))


def test_joints_in_one_place_share_their_name():
    said = {text.get_text() for text in drawn("squeezer")["mechanism"].axes[0].texts}
    assert {"A5, A7", "E2, E4, E6", "O"} <= said


@pytest.mark.slow("draws two mechanisms")
def test_forces_of_a_loose_guide_and_moments_of_gears_have_panels():
    assert [ax.get_title(loc="left") for ax in drawn("slider_crank_loose_guide")["forces"].axes][
        -1
    ] == "joint guide"
    assert {ax.get_title(loc="left") for ax in drawn("gear_train")["moments"].axes} == {
        "gear first-stage",
        "gear second-stage",
    }
    assert "forces" not in drawn("elastica_circle")  # what rounding leaves is no force


@pytest.mark.system("draws a frame of sixty elements")
def test_a_large_frame_has_a_short_legend_and_no_more_panels_than_fit():
    result = vfife.simulate(gallery.williams_toggle(elements=60, drops=(0.05,)))
    assert words(figures(result)) == {"toggle", "weld", "load"}
    chain = vfife.Mechanism("chain", gravity=(0.0, -9.81))
    chain.point("O", 0.0, 0.0)
    for k in range(20):
        chain.link(f"l{k}", length=0.1, mass=0.1)
        chain.revolute(f"j{k}", "ground.O" if k == 0 else f"l{k - 1}.end", f"l{k}.start")
    found = figures(vfife.simulate(chain, duration=0.01, loop="data-driven"))
    legend = [text.get_text() for text in found["mechanism"].legends[0].get_texts()]
    assert "… and 9 more bodies" in legend and len(legend) < 15
    # The far end is still at rest: links whose acceleration is about zero have no panel.
    assert len(found["forces"].axes) == 16 > len(found["accelerations"].axes) >= 8


def test_plates_are_convex_and_frames_do_not_run_across_gaps():
    corners = outline_of(run("jansen_leg"), "foot").path[0]
    assert len(corners) == 4 and np.array_equal(corners[0], corners[-1])
    path = outline_of(run("lee_frame"), "frame").path[0].reshape(-1, 3, 2)
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


def test_a_driven_slider_without_clearance_has_no_figure_of_its_guide() -> None:
    """Its block has two rows of reactions, as corners have: one of the guide and one of the driver."""
    m = vfife.Mechanism("shaker")
    m.point("O", 0, 0)
    m.rigid_body("block", mass=1, inertia=1e-3, position=(0.1, 0))
    m.slider("rail", "ground.O", "block.center")
    m.harmonic(slider="rail", amplitude=0.01, frequency=5)
    result = vfife.simulate(m, duration=0.2)
    assert loose_guides(result) == []
    with pytest.raises(vfife.VfifeError, match="no block has clearance in a guide"):
        result.plot("guides")
    result.plot()
