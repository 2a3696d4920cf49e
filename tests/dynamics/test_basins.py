"""Basins of a double well, whose symmetry says which start comes where; values begun anew; companions."""

import dataclasses
import math
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import vfife
from mechanisms import snapping
from vfife.dynamics import load_map
from vfife.dynamics.basins import Basins, attractors, basins
from vfife.dynamics.bifurcation import bifurcation
from vfife.dynamics.step_check import CheckedMap, Companion, packed, sampled, unpacked
from vfife.errors import ModelError
from vfife.measures.chaos import Verdict, exponent, verdict
from vfife.modelfile import load
from vfife.plots.dynamics import shares
from vfife.report.document import Table
from vfife.report.dynamics import _transients as transient_sentences
from vfife.report.dynamics import _unsettled_starts as unsettled_sentences
from vfife.report.dynamics import basins as basins_document

LOOSE = "examples/slider_crank_loose_pin.toml"


@pytest.fixture(scope="module")
def wells(tmp_path_factory):
    """A grid over where the block begins and how fast, symmetric about rest in the middle;
    broken off twice.
    """
    path = tmp_path_factory.mktemp("wells") / "wells.map"
    x, y = ("body.block.position.0", -0.6, 0.6), ("body.block.velocity.0", -4.0, 4.0)
    given = {
        "count": (6, 5),
        "turns": 12,
        "dropped": 8,
        "step": 1e-3,
        "series": ["block.x"],
        "companions": 3,
        "file": path,
    }

    def stop(done: int, of_all: int) -> None:
        if done in (9, 17):
            raise KeyboardInterrupt

    for _ in range(2):
        part = basins(snapping(), x, y, **given, progress=stop)
        assert part.done < 30 and np.isnan(part.labels).any()
    calls = []
    return basins(snapping(), x, y, **given, progress=lambda *at: calls.append(at)), calls, path


@pytest.mark.system("steps a grid of starts")
def test_a_double_well_has_two_basins_that_are_each_others_mirror(wells) -> None:
    """Places and velocities of the opposite sign come to the other side; from rest each side is its own. Both
    rest where the spring is free.
    """
    found, _, _ = wells
    assert len(found.attractors) == 2 and found.done == 30
    labels = found.labels
    assert np.array_equal(labels, 1.0 - labels[::-1, ::-1])
    rest = [float(one.points[0, 0]) for one in found.attractors]
    assert sorted(rest) == pytest.approx([-math.sqrt(1.1**2 - 1.0), math.sqrt(1.1**2 - 1.0)], rel=1e-3)
    sides = np.sign(np.array(found.spec.x))
    assert np.array_equal(np.sign(np.array(rest))[labels[2].astype(int)], sides)
    assert {one.kind for one in found.attractors} == {"period 1"}
    over = dataclasses.replace(
        found, spec=dataclasses.replace(found.spec, paths=(found.spec.paths[0], "spring.snap.stiffness"))
    )
    assert found.spec.varied == () and [one.kind for one in over.attractors] == [
        "period 1"
    ]  # points would move with the stiffness


@pytest.mark.system("steps a grid of starts")
def test_the_table_and_the_figure_number_the_motions_alike(wells) -> None:
    """A sentence on a motion names its number, and two motions of one kind are told apart by it."""
    found, _, _ = wells
    table = next(part for part in basins_document(found).parts if isinstance(part, Table))
    labels = [patch.get_label().partition(":")[0] for patch in shares(found, ["red", "blue"])]
    assert [row[0] for row in table.rows] == labels == ["1. period 1", "2. period 1"]


@pytest.mark.parametrize(
    ("transients", "said"),
    [
        ([4], "Motion 5 of this table may be a transient "),
        ([1, 4], "Motions 2 and 5 of this table may be tr"),
    ],
)
def test_motions_that_may_be_transients_are_named_by_number(transients: list[int], said: str) -> None:
    assert transient_sentences(SimpleNamespace(transients=transients))[0].startswith(said)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("kinds", "rate", "sentences"),
    [
        (["period 1"] * 3 + ["not settled"], -0.07, []),
        (
            ["period 1"] * 2 + ["not settled"],
            math.nan,
            ["1 of 3 starts are not settled: take more turns (--turns 600)."],
        ),
        (
            ["not settled"] * 2,
            -0.07,
            [
                "2 of 2 starts are not settled: take more turns (--turns 150: a small difference shrinks by"
                " 7 % a turn there)."
            ],
        ),
        (
            ["period 1", "chaotic"],
            -0.07,
            ["Chaotic within 60 turns: a longer transient is possible: --turns 600."],
        ),
    ],
)
def test_starts_that_may_need_more_turns_are_named(
    kinds: list[str], rate: float, sentences: list[str]
) -> None:
    """ln 1000 is 6.91: a difference that shrinks by 0.07 a turn takes 98.7 turns, two thirds of 148."""
    found: Any = SimpleNamespace(
        verdicts=dict(enumerate(Verdict(kind, None, 0.0, exponent([rate] * 9)) for kind in kinds)),
        attractors=[SimpleNamespace(kind=kind, members=(k,)) for k, kind in enumerate(kinds)],
        spec=SimpleNamespace(turns=60, dropped=40),
    )
    found.words_of = partial(CheckedMap.words_of, found)
    assert unsettled_sentences(found) == sentences
    found.attractors = [SimpleNamespace(kind="period 1", members=range(len(kinds)))]
    assert not any("not settled" in text for text in unsettled_sentences(found))


@pytest.mark.system("breaks a grid of starts off")
def test_basins_go_on_where_they_were_broken_off(wells) -> None:
    """To the bit, as they are in the file."""
    found, calls, path = wells
    again = load_map(path)
    assert calls[-1] == (30, 30) and len(calls) <= 30 - 17
    assert all(
        np.array_equal(again.points[k], found.points[k]) and np.array_equal(again.growth[k], found.growth[k])
        for k in range(30)
    )
    assert again.companions == found.companions and len(found.companions) == 6
    x, y = (found.spec.paths[0], -0.6, 0.6), (found.spec.paths[1], -4.0, 4.0)
    whole = basins(
        snapping(), x, y, count=(6, 5), turns=12, dropped=8, step=1e-3, series=["block.x"], companions=0
    )
    assert all(
        np.array_equal(whole.points[k], found.points[k]) and np.array_equal(whole.growth[k], found.growth[k])
        for k in range(30)
    )


def test_companions_agree_where_nothing_hangs_on_the_step(wells) -> None:
    found, _, _ = wells
    assert (
        {one.kind for one in found.companions} == {"period 1"}
        and "6 of 6 companions" in found.step_report
        and "1.25 and 0.5 times" in found.step_report
    )


def test_basins_are_drawn_and_written(wells, tmp_path) -> None:
    found, _, _ = wells
    figure = found.plot()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1. period 1: 50 %", "2. period 1: 50 %"]
    found.write_csv(tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert (
        len(lines) == 31
        and lines[0] == "body.block.position.0,body.block.velocity.0,attractor,kind,exponent,block.x"
    )


def loose() -> vfife.Mechanism:
    """A slider-crank whose pin strikes its bearing, by coarse steps."""
    return load(LOOSE, set=[("joint.pin.contact.restitution", 0.3)])


def test_starts_outside_the_bearing_are_none(tmp_path) -> None:
    """A square of places around a round bearing: its corners are left out."""
    found = basins(
        loose(),
        ("start.pin.x", -4e-4, 4e-4),
        ("start.pin.y", -4e-4, 4e-4),
        count=(3, 3),
        turns=3,
        dropped=1,
        step=1e-5,
        companions=0,
    )
    assert found.done == 9 and len(found.verdicts) == 5
    assert np.array_equal(
        np.isnan(found.labels), [[True, False, True], [False, False, False], [True, False, True]]
    )


@pytest.mark.parametrize(
    "path, said",
    [("start.pen.x", "start.pin.x"), ("start.pin.z", "start"), ("joint.pin.clearence", "clearance")],
)
def test_numbers_that_are_none_are_told(path, said) -> None:
    with pytest.raises(ModelError, match=said):
        basins(
            loose(), (path, 0.0, 1e-4), ("start.crank", 0.0, 1.0), count=(2, 2), turns=2, dropped=1, step=1e-5
        )


GIVEN = {"count": 3, "turns": 4, "dropped": 2, "step": 1e-5}


def test_a_value_begun_anew_is_a_run_of_its_own(tmp_path) -> None:
    """The model's own start at the first value is where the way up begins, to the bit. It goes on after a
    break.
    """
    path, starts = "joint.pin.clearance", [{}, {"start.crank": 1.0, "start.pin.vy": 0.2}]
    up = bifurcation(loose(), path, 2e-4, 3e-4, **GIVEN, companions=0)
    whole = bifurcation(loose(), path, 2e-4, 3e-4, **GIVEN, starts=starts, companions=1)
    assert whole.spec.ways == ("own start", "start.crank = 1 rad, start.pin.vy = 0.2 m/s") and whole.done == 3
    for name in up.points:
        assert (
            np.array_equal(whole.points[name][0, 0], up.points[name][0, 0])
            and not np.isnan(whole.points[name]).any()
        )
        assert not np.array_equal(whole.points[name][0, 1:], up.points[name][0, 1:])
    assert whole.growth[0, 0] == pytest.approx(
        up.growth[0, 0], rel=1e-9
    )  # whose last bits know what is in the lanes beside
    assert len(whole.companions) == 2 and "1 case repeated" in whole.step_report
    figure = whole.plot()
    (legend,) = figure.legends  # below the panels, where it covers no point
    assert [one.get_text() for one in legend.get_texts()][:2] == list(whole.spec.ways)
    lowest = min(ax.get_window_extent().y0 for ax in figure.axes)
    figure.canvas.draw()
    assert legend.get_window_extent().y1 < lowest and not any(ax.get_legend() for ax in figure.axes)

    def stop(done: int, of_all: int) -> None:
        raise KeyboardInterrupt

    part = bifurcation(
        loose(),
        path,
        2e-4,
        3e-4,
        **GIVEN,
        starts=starts,
        companions=1,
        file=tmp_path / "a.map",
        progress=stop,
    )
    assert part.done == 0 and sum(bool(kind) for kinds in part.kinds for kind in kinds) == 1
    rest = bifurcation(
        loose(), path, 2e-4, 3e-4, **GIVEN, starts=starts, companions=1, file=tmp_path / "a.map"
    )
    assert (
        all(np.array_equal(rest.points[name], whole.points[name]) for name in whole.points)
        and rest.companions == whole.companions
    )


def test_lengths_are_swept_from_starts() -> None:
    """What no motion can go on through is begun anew, the difference watched being one that opens no joint:
    its growth is that of a play swept.
    """
    length = bifurcation(
        loose(), "body.rod.length", 0.12, 0.121, **{**GIVEN, "count": 2}, starts=[{}], companions=0
    )
    assert length.done == 2 and np.isfinite(length.growth).all() and abs(length.exponents).max() < 20.0


def test_a_start_comes_to_the_phase_of_all() -> None:
    """A crank that is driven: whatever angle it begins at, at the phase it stands as that of the model's own
    start does.
    """
    found = bifurcation(
        loose(), "joint.pin.clearance", 2e-4, 3e-4, **{**GIVEN, "count": 2}, series=["crank.angle"],
        phase=0.25, starts=[{}, {"start.crank": 2.0}, {"start.crank": -1.0}], companions=0,
    )  # fmt: skip
    angles = np.mod(found.points["crank.angle"], 2.0 * math.pi)
    assert angles == pytest.approx(
        np.full(angles.shape, 0.5 * math.pi), abs=math.pi / found.spec.steps * 1.01
    )


class Members(CheckedMap):
    def kind_of(self, case: Companion) -> str:
        return ("period 1", "chaotic")[case.number]

    def name_of(self, case: Companion) -> str:
        return f"member {case.number}"


def test_starts_are_named_in_the_units_of_the_figure() -> None:
    numbers = {"body.rod.angle": math.pi / 2.0, "body.rod.rate": 2.0}
    spec = SimpleNamespace(paths=tuple(numbers), units=("rad", "rad/s"), numbers=lambda case: numbers)
    found: Any = SimpleNamespace(spec=spec)
    assert (
        Basins.name_of(found, Companion(0, 0, 0.8, "period 1"))
        == "body.rod.angle = 90 deg, body.rod.rate = 2"
    )


def test_companions_that_differ_are_named() -> None:
    some = [
        Companion(0, 0, 0.8, "period 1"),
        Companion(0, 0, 2.0, "period 2"),
        Companion(1, 0, 0.8, "chaotic"),
        Companion(1, 0, 2.0, "quasi-periodic"),
    ]
    assert unpacked(packed(some)) == some and unpacked(None) == []
    spec = SimpleNamespace(turns=90)
    said = Members("", spec, tuple(some)).step_report
    assert "member 1 is chaotic within 90 turns, with" in said and "step chaotic" not in said
    assert "2 of 4 companions" in said and "member 0 is period 1, with 0.5 times the step period 2" in said
    short = type("Short", (Members,), {"most_differences": 1})("", spec, tuple(some)).step_report
    assert "step period 2; 1 more differ" in short and "member 1" not in short
    assert sampled(400, 5) == (40, 120, 200, 280, 360) and sampled(2, 5) == (0, 1) and sampled(10, 0) == ()


def test_one_period_begun_elsewhere_is_one_motion() -> None:
    """Points 1, 3 and 3, 1 are one motion; 1, 4 is another; what has no period is one of its kind."""
    cloud = np.random.default_rng(3).uniform(1.0, 4.0, (40, 1))
    points = [np.resize(one, 40)[:, None] for one in ([1.0, 3.0], [3.0, 1.0], [1.0, 4.0], [1.0, 3.001])] + [
        None,
        cloud,
    ]
    found = attractors(points, [None if one is None else verdict(one) for one in points])
    assert [(one.kind, one.members) for one in found] == [
        ("period 2", (0, 1, 3)),
        ("period 2", (2,)),
        ("not settled", (5,)),
    ]
