"""Static analyses on twice and half the elements: the error of the mesh that is told, against the error
there is.
"""

from __future__ import annotations

import dataclasses
import io
import math

import numpy as np
import pytest
from rich.console import Console
from scipy.integrate import solve_bvp

import vfife
from choice import default_cases
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.laws import Material
from vfife.measures.statics import error_of, sizes
from vfife.measures.trust import trust
from vfife.measures.values import Measured
from vfife.model.bodies import Member, Section
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.report.summary import show
from vfife.simulation.result import Result
from vfife.solvers import refinement
from vfife.solvers.refinement import meshed, other_meshes, refinable, worth_other_meshes

SLENDER = {"section": Section(1.0, 300.0**-2), "material": Material(youngs_modulus=300.0**2)}  # EI = 1 N m^2


def cantilever(elements: int, load: float = 5.0, **options) -> Mechanism:
    """1 m and 1 N m^2, clamped at its start, pressed across at its end."""
    m = Mechanism("cantilever", settings=Settings(analysis="static", load_factors=(0.5, 1.0)))
    m.point("O", 0.0, 0.0)
    m.link("beam", length=1.0, mass=1.0, **({"model": "elastic", "elements": elements} | SLENDER | options))
    m.weld("clamp", "ground.O", "beam.start")
    m.loads["P"] = PointForce(name="P", at="beam.end", force=(0.0, load))
    return m


def elastica(load: float) -> tuple[float, float]:
    """Moment at the clamp (N m) and displacement of the end (m): EI theta'' = -P cos theta, theta(0) =
    theta'(1) = 0.
    """

    def rates(_: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.vstack([y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    mesh = np.linspace(0.0, 1.0, 201)
    found = solve_bvp(
        rates,
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
        mesh,
        np.vstack([mesh, 1.0 - mesh, mesh, 0.0 * mesh]),
        tol=1e-9,
    )
    assert found.success
    return float(found.y[1, 0]), math.hypot(found.y[2, -1] - 1.0, found.y[3, -1])


@pytest.mark.parametrize("elements", [1, 2, 3, 4, 8])
@pytest.mark.parametrize(
    "load", default_cases([1.0, 5.0, 10.0], lambda load: load == 10.0, "solves for every load")
)
def test_the_elastica_lies_in_the_range(elements: int, load: float) -> None:
    """With two elements the moment at the clamp is some per cent wrong: its range says so."""
    result, (moment, way) = vfife.simulate(cantilever(elements, load)), elastica(load)
    found, moved = result.measures["clamp.moment.max"], result.measures["displacement.max"]
    assert found.low <= moment <= found.high and moved.low <= way <= moved.high
    assert found.estimated and moved.estimated and found.width < 2.0 * moment / elements**1.5
    assert (
        result.measures["load_factor"].estimated and result.measures["load_factor"].width == 0.0
    )  # nobody doubts that


@pytest.mark.parametrize(("elements", "wrong"), [(2, 0.25), (4, 0.0625), (8, 0.0156)])
def test_the_moment_of_a_clamped_beam_under_its_weight(elements: int, wrong: float) -> None:
    """m g L/12 at both ends; weight at n nodes leaves 1/n^2 of it out."""
    m = Mechanism("beam", gravity=(0.0, -9.81), settings=Settings(analysis="static", load_factors=(1.0,)))
    m.point("O", 0.0, 0.0)
    m.point("Q", 1.0, 0.0)
    m.link("beam", length=1.0, mass=1e-3, model="elastic", elements=elements, **SLENDER)
    m.weld("left", "ground.O", "beam.start")
    m.weld("right", "ground.Q", "beam.end")
    found, truth = vfife.simulate(m).measures["left.moment.max"], 1e-3 * 9.81 / 12.0
    assert found / truth - 1.0 == pytest.approx(-wrong, rel=0.02)
    assert found.low <= truth <= found.high and found.width < 4.0 * wrong * truth


def test_a_coarse_mesh_is_told_and_a_fine_one_is_not() -> None:
    coarse, fine = (vfife.simulate(cantilever(count)) for count in (2, 12))
    said = trust(coarse.record, coarse.measures)
    assert said is not None and said.sensitive and "The mesh is coarse: " in coarse.summary["warnings"][0]
    assert not fine.summary["warnings"] and fine.summary["trust"]["apart"] < 0.01


def frame(elements: int) -> Mechanism:
    """A portal clamped at one foot and pinned at the other, loaded aslant in the middle."""
    m = Mechanism("portal", settings=Settings(analysis="static", load_factors=(1.0,)))
    m.point("O", 0.0, 0.0)
    m.point("Q", 1.2, 0.0)
    nodes = {"a": (0.0, 0.0), "b": (0.0, 1.0), "c": (1.2, 1.0), "d": (1.2, 0.0), "e": (0.6, 1.0)}
    m.frame(
        "frame",
        nodes=nodes,
        members=[Member(*ends, elements) for ends in ("ab", "be", "ec", "cd")],
        **SLENDER,
    )
    m.weld("left", "ground.O", "frame.a")
    m.revolute("right", "ground.Q", "frame.d")
    m.loads["P"] = PointForce(name="P", at="frame.e", force=(0.6, -2.0))
    return m


@pytest.mark.system("relaxes frames of several sizes")
@pytest.mark.parametrize("elements", [1, 2])
def test_a_portal_of_members_lies_in_the_ranges(elements: int) -> None:
    """One element a member, which is the default, cannot be halved: there four times as many tell."""
    fine = {count: vfife.simulate(frame(count), companions=0).measures for count in (8, 16)}
    found = vfife.simulate(frame(elements)).measures
    for name in ("left.force.max", "left.moment.max", "right.force.max", "displacement.max"):
        truth = fine[16][name] + (fine[16][name] - fine[8][name]) / 3.0
        assert found[name].low <= truth <= found[name].high and found[name].width > 0.0, name


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ((1.04, {0.5: 1.16, 2.0: 1.01}), 1.25 * 0.04),  # second order: a third of the last difference is left
        ((1.04, {0.5: 1.08, 2.0: 1.02}), 1.25 * 0.04),  # first order
        ((1.00, {0.5: 1.30, 2.0: 1.00}), 1.25 * 0.10),  # the finer meshes agree by chance
        ((1.00, {0.5: 1.00, 2.0: 1.04}), 1.25 * 0.16),
        ((1.03, {2.0: 1.00}), 4.0 * 0.03),
        ((1.16, {2.0: 1.04, 4.0: 1.01}), 1.25 * 0.16),  # second order
        ((1.00, {2.0: 1.00, 4.0: 1.04}), 1.25 * 0.16),  # the coarser meshes agree by chance
        ((1.04, {2.0: 1.00, 4.0: 1.00}), 1.25 * 4.0 / 3.0 * 0.04),
    ],
)
def test_an_error_from_meshes(values: tuple[float, dict[float, float]], error: float) -> None:
    assert error_of(*values) == pytest.approx(error, rel=1e-12)


def test_what_has_no_elements_that_can_be_halved_is_not_estimated() -> None:
    two = cantilever(4)
    two.bodies["beam"] = dataclasses.replace(two.bodies["beam"], model="two-particle")
    assert (
        refinable(cantilever(4))
        and not refinable(two)
        and not refinable(gallery.toggle_press())
        and refinable(frame(1))
    )
    result = vfife.simulate(gallery.toggle_press())
    assert not result.measures["knee.force.max"].estimated and result.measures["iterations"].estimated
    assert "knee.force.max" in result.summary["not_estimated"] and result.summary["trust"] == {}


def test_meshes_with_twice_and_half_the_elements() -> None:
    assert [member.elements for member in meshed(frame(2), 2.0).bodies["frame"].members] == [4, 4, 4, 4]
    assert [member.elements for member in meshed(frame(2), 0.5).bodies["frame"].members] == [1, 1, 1, 1]
    assert meshed(frame(3), 0.5) is None and meshed(cantilever(1), 0.5) is None
    assert meshed(cantilever(6), 0.5).bodies["beam"].elements == 3


def test_which_meshes_are_analysed() -> None:
    shares = {
        count: set(other_meshes(vfife.simulate(cantilever(count), companions=0).record))
        for count in (1, 2, 3)
    }
    assert shares == {1: {2.0, 4.0}, 2: {0.5, 2.0}, 3: {2.0, 4.0}}


def test_it_is_left_out_where_it_takes_long_or_nobody_wants_it(monkeypatch) -> None:
    many = cantilever(4)
    many.settings = dataclasses.replace(many.settings, load_factors=tuple(k / 5000.0 for k in range(1, 5001)))
    assert worth_other_meshes(assemble(cantilever(4))) and not worth_other_meshes(assemble(many))
    assert vfife.simulate(cantilever(2), companions=0).record.estimate is None
    monkeypatch.setattr(refinement, "MOST_WORK", 0.0)
    assert vfife.simulate(cantilever(2)).record.estimate is None
    assert vfife.simulate(cantilever(2), companions=1).record.estimate is not None


def test_an_analysis_that_fails_has_no_estimate() -> None:
    short = cantilever(2)
    short.settings = dataclasses.replace(short.settings, iterations=200)
    result = vfife.simulate(short)
    assert result.record.status == "not converged" and result.record.estimate is None
    assert (
        not result.measures["clamp.force.max"].estimated
        and "clamp.force.max" in result.summary["not_estimated"]
    )


@pytest.mark.system("relaxes frames of several sizes")
def test_what_carries_nothing_makes_no_mesh_coarse() -> None:
    """A beam under a moment alone has no force at its clamp but what the residual leaves."""
    result = vfife.simulate(gallery.elastica_circle())
    size = sizes(result.record, {name: one.value for name, one in result.measures.items()})
    assert (
        "clamp.moment.max" in size
        and "clamp.force.max" not in size
        and result.measures["clamp.force.max"].estimated
    )


def test_it_is_shown_and_kept(tmp_path) -> None:
    result = vfife.simulate(cantilever(2))
    result.save(tmp_path / "run.sqlite")
    again = Result.load(tmp_path / "run.sqlite")
    for one in (result, again):
        console = Console(file=io.StringIO(), width=120)
        show(console, one)
        text = console.file.getvalue()
        assert "Ranges cover the error of the mesh" in text and "not estimated" not in text
        [line] = [line for line in text.splitlines() if line.strip().startswith("clamp.moment.max")]
        assert " to " in line
    assert {name: repr(one) for name, one in again.measures.items()} == {
        name: repr(one) for name, one in result.measures.items()
    }
    console = Console(file=io.StringIO(), width=120)
    show(console, vfife.simulate(cantilever(2), companions=0))
    text = console.file.getvalue()
    assert text.count("not estimated") >= 3 and "Ranges are" not in text


def test_a_number_says_whether_it_was_estimated() -> None:
    assert repr(Measured(2.5)) == "2.5 (not estimated)" and str(Measured(2.5)) == "2.5" == f"{Measured(2.5)}"
    assert (
        repr(Measured(2.5, 2.0, 3.0)) == "2.5 (2 to 3)"
        and Measured(2.5, 2.0, 3.0).estimated
        and not Measured(2.5, 2.5, 2.5, estimated=False).estimated
    )


@pytest.mark.parametrize("elements", [10, 20, 40])
@pytest.mark.parametrize("load", [1e-4, 1.0, 100.0])
def test_the_reaction_of_a_cantilever_lies_in_its_range(elements: int, load: float) -> None:
    """It is the load, exactly, though (residual and rounding) it some millionths of a newton smaller; the
    range is not much wider than that.
    """
    m = Mechanism("cantilever", settings=Settings(analysis="static", load_factors=(1.0,), companions=1))
    m.point("O", 0.0, 0.0)
    section = {"rectangle": ["20 mm", "10 mm"]}
    m.link("beam", length=1.0, model="elastic", elements=elements, section=section, material="steel")
    m.weld("clamp", "ground.O", "beam.start")
    m.loads["P"] = PointForce(name="P", at="beam.end", force=(0.0, -load))
    result = vfife.simulate(m)
    reaction = result.measures["clamp.force.max"]
    assert reaction != load and reaction.low <= load <= reaction.high
    assert reaction.width < 2e-4 * load + 2e-4
    text = " ".join(str(result).split())
    assert "(residual and rounding)" in text and "0.0e+00" not in text
