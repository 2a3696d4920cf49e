"""Figures of a study have its numbers: maps and curves are its arrays, a front is what no case beats, and
what is missing stays so.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection, QuadMesh

import vfife
from studies.studies import ASKED, Closed
from vfife.errors import VfifeError
from vfife.modelfile import dump
from vfife.numerics.pareto import front
from vfife.plots.study import quantiles
from vfife.plots.study_axes import broken_name, edges, even_indices, is_logarithmic, unit_of_axis
from vfife.plots.style import readable
from vfife.results.parameters import Varied
from vfife.studies.engine import study_engine

GRID = ASKED.replace("count = 2", "count = 4")


def made(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **closed: Any) -> vfife.studies.Study:
    monkeypatch.setattr(study_engine, "run_cases", Closed(**closed))
    path = tmp_path / "s.toml"
    path.write_text(text)
    return vfife.study(path)


def test_maps_curves_and_lines_have_the_numbers_of_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = made(GRID, tmp_path, monkeypatch, fails=2e-4)
    figures = found.plot()
    assert list(figures) == ["maps", "curves", "parallel", "fronts"]
    values = found.data["C.force.max"].values
    mesh, *_ = (one for one in figures["maps"].axes[0].collections if isinstance(one, QuadMesh))
    assert np.ma.allclose(mesh.get_array(), np.ma.masked_invalid(values)), (
        "speed has more values, so it goes across"
    )
    assert np.ma.getmaskarray(mesh.get_array())[1].all(), "cases that failed are no colour"
    lines = figures["curves"].axes[0].lines
    assert [
        np.allclose(line.get_ydata(), row, equal_nan=True) for line, row in zip(lines, values, strict=True)
    ] == [True] * 3
    (drawn,) = (one for one in figures["parallel"].axes[0].collections if isinstance(one, LineCollection))
    assert len(drawn.get_segments()) == 8, "two of three clearances came to something"
    assert list(found.plot("curves", measures=["C.impacts"])) == ["curves"]
    with pytest.raises(VfifeError, match="did you mean"):
        found.plot("curvs")
    with pytest.raises(VfifeError, match="no measure"):
        found.plot(measures=["C.fource"])


def test_curves_name_how_many_values_they_show(monkeypatch: pytest.MonkeyPatch) -> None:
    """A speed is in the unit of the study file; one without a unit is in rpm, as in all figures."""
    for first, label, place in (
        ("100 rad/s", "speed (rad/s)", 100.0),
        (100.0, "speed (rpm)", 3000.0 / np.pi),
    ):
        speeds = {"path": "driver.crank.speed", "from": first, "to": 200.0, "count": 20}
        play = {"path": "joint.C.clearance", "from": "0.1 mm", "to": "1 mm", "count": 10}
        monkeypatch.setattr(study_engine, "run_cases", Closed())
        found = vfife.study(
            vfife.gallery.four_bar_case_b(), {"speed": speeds, "play": play}, ["C.force.max"], turns=2
        )
        figure = found.plot("curves")["curves"]
        texts = [one.get_text() for one in (*figure.texts, figure.axes[0].title, figure.axes[0].xaxis.label)]
        assert any("6 of 10 values of play" in text for text in texts), texts
        assert label in texts and np.isclose(figure.axes[0].lines[0].get_xdata()[0], place)


def test_an_axis_of_clearances_of_a_pin_says_radial_and_one_of_a_guide_does_not(monkeypatch) -> None:
    monkeypatch.setattr(study_engine, "run_cases", Closed())
    vary = {"play": {"path": "joint.C.clearance", "values": ["0.1 mm", "0.2 mm", "0.3 mm"]}}
    found = vfife.study(vfife.gallery.four_bar_case_b(), vary, ["C.force.max"], turns=2)
    assert found.plot("curves")["curves"].axes[0].get_xlabel() == "play (mm, radial)"
    study: Any = SimpleNamespace(request={"text": dump(vfife.gallery.compressor())})
    for path, unit in (
        ("joint.big-end.clearance", "um, radial"),
        ("joint.cylinder.clearance", "um"),
        ("body.rod.length", "um"),
    ):
        assert unit_of_axis(study, Varied("play", (path,), "m", "values"), "um") == unit


def test_bands_are_quantiles_of_the_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = GRID.replace("count = 4\n", "").replace("turns = 2", 'turns = 2\nmethod = "random"\ncount = 200')
    found = made(text, tmp_path, monkeypatch)
    figures = found.plot("maps", "curves")
    assert list(figures) == ["curves"]
    middle, low, high = quantiles(found.laid_out("C.force.max"))
    speeds = np.sort(found.data.speed.values)
    for k, play in enumerate((1e-4, 2e-4, 3e-4)):
        for line, share in ((low, 0.05), (middle, 0.5), (high, 0.95)):
            assert line[k] == pytest.approx(play * np.quantile(speeds, share) ** 2, rel=0.01)
    assert np.allclose(figures["curves"].axes[0].lines[0].get_ydata(), middle)
    assert "over 200 samples" in figures["curves"]._suptitle.get_text()


@pytest.mark.parametrize("measures", [2, 3])
def test_a_front_is_what_no_other_point_beats(measures: int) -> None:
    values = np.round(np.random.default_rng(measures).normal(size=(120, measures)), 1)
    values = np.vstack([values, values[:5]])
    beaten = [
        any(
            all(a <= b for a, b in zip(other, one, strict=True))
            and any(a < b for a, b in zip(other, one, strict=True))
            for other in values
        )
        for one in values
    ]
    assert front(values).tolist() == [not one for one in beaten]
    assert 2 <= front(values).sum() < 60


def test_axes_say_quantities_as_people_do() -> None:
    assert readable([2e-4], "m") == (1e3, "mm")
    assert readable([5000.0], "W") == (1e-3, "kW")
    assert readable([50.0], "rad/s^2") == (1.0, "rad/s²")
    assert edges(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert is_logarithmic(np.geomspace(1.0, 100.0, 5)) and not is_logarithmic(np.linspace(1.0, 100.0, 5))
    assert (
        broken_name("follower.angular_acceleration.max").replace("\n", "")
        == "follower.angular_acceleration.max"
    )
    assert all(
        len(even_indices(n, most)) == min(n, most) for n, most in itertools.product((1, 5, 37), (2, 6)) if n
    )


@pytest.mark.system("draws every figure of studies")
def test_words_stand_in_their_order_and_files_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vfife.plots.study import save_figures

    text = (
        GRID
        + '[vary.law]\npath = "joint.C.contact.law"\nvalues = ["lankarani-nikravesh", "flores", "hertz"]\n'
    )
    found = made(text, tmp_path, monkeypatch)
    (tmp_path / "out").mkdir()
    paths = save_figures(found, tmp_path / "out", ["parallel", "maps"], ending=".svg")
    assert [path.name for path in paths] == ["maps.svg", "parallel.svg"]
    assert "median over law" in found.plot("maps")["maps"]._suptitle.get_text()
    words = {text.get_text() for text in found.plot("parallel")["parallel"].axes[0].texts}
    assert {"lankarani-nikravesh", "flores", "hertz"} <= words


def test_a_logarithmic_axis_names_values_that_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = GRID.replace(
        'values = ["0.1 mm", "0.2 mm", "0.3 mm"]',
        'from = "0.01 mm"\nto = "1 mm"\ncount = 9\nspacing = "logarithmic"',
    )
    found = made(text, tmp_path, monkeypatch)
    axis = found.plot("curves")["curves"].axes[0].xaxis
    labels = [tick.get_text() for tick in axis.get_ticklabels()]
    assert axis.get_scale() == "log" and labels[0] == "0.01" and labels[-1] == "1" and len(labels) <= 7
    assert list(axis.get_minorticklocs()) == []


def test_axes_and_tables_have_the_unit_of_the_study_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vfife.report.study import document, value_words

    text = GRID.replace('"100 rad/s"', '"1500 rpm"').replace('"200 rad/s"', '"3000 rpm"')
    found = made(text, tmp_path, monkeypatch)
    speed = found.parameter("speed")
    assert speed.unit == "rad/s" and speed.written == "rpm"
    assert value_words(speed, 50.0 * np.pi) == "1500 rpm"
    ax, other, *_ = found.plot("curves")["curves"].axes
    assert "rpm" in ax.get_xlabel()
    assert np.allclose(ax.lines[0].get_xdata(), [1500.0, 2000.0, 2500.0, 3000.0])
    assert "last turn" in ax.get_title("left") and "whole case" in other.get_title("left")
    assert "rpm" in str(document(found).parts) and "rad/s" not in str(document(found).parts)


def test_a_knock_of_zero_is_no_impact_and_no_best_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vfife.report.study import extreme_table, remarks_on_turns

    text = GRID.replace('"C.impacts"', '"C.approach_speed.max"')
    found = made(text, tmp_path, monkeypatch)
    for k, one in enumerate(found.outcomes.values()):
        one["measures"]["C.approach_speed.max"] = 0.1 + 0.01 * k
    assert not any("no impact" in text for text in remarks_on_turns(found))
    assert not any("hollow" in ax.get_title("left") for ax in found.plot("curves")["curves"].axes)
    found.outcomes[found.done[5].number]["measures"]["C.approach_speed.max"] = 0.0
    (remark,) = (text for text in remarks_on_turns(found) if "no impact means" in text)
    assert remark.startswith("C.approach_speed.max") and "C.force.max has it, and vfife run" in remark
    assert "no impact" in extreme_table(found).rows[1], "0 is no speed"
    force, speed = found.plot("curves")["curves"].axes
    assert "hollow: no impact" in speed.get_title("left") and "hollow" not in force.get_title("left")
    values = [y for line in speed.lines if line.get_ls() == "-" for y in line.get_ydata()]
    assert np.isnan(values).sum() == 1 and np.nanmin(values) > 0.0, "no line goes through 0"
    (ax,) = found.plot("fronts", measures=["C.approach_speed.max", "C.force.max"])["fronts"].axes
    best = next(one for one in ax.collections if one.get_label().startswith("front"))
    assert best.get_offsets()[:, 0].min() > 0.0, "a case without impacts is not recommended"
    (hollow,) = (line for line in ax.lines if str(line.get_label()).startswith("no impact"))
    assert hollow.get_xdata().tolist() == [0.0]
    ends = [text.get_text() for text in found.plot("parallel")["parallel"].axes[0].texts]
    assert "no impact" in ends
    for one in found.outcomes.values():
        one["measures"]["C.approach_speed.max"] = 0.0
    _, speed = found.plot("curves")["curves"].axes
    rings = [line for line in speed.lines if line.get_markerfacecolor() == "white"]
    sizes = [(line.get_markersize(), -line.get_zorder()) for line in rings]
    assert len(rings) > 1 and sizes == sorted(set(sizes)), "one colour does not hide the others"


@pytest.mark.parametrize(("speed", "count"), [(0.0, 1), (0.1, 0)])
def test_a_search_cautions_about_a_best_case_without_impacts(speed: float, count: int) -> None:
    from vfife.report.searches import optimum

    name = "C.approach_speed.max"
    request: dict[str, Any] = {"wanted": {"turns": 2, "last": 1}, "raw": {"method": "search"}}
    study = SimpleNamespace(
        parameters=(), measures={name: "m/s"}, path="s.study", request=request, outcomes={}, errors={},
        sensitive=(0, 0), has_former_measures=False, done=(), repeats={},
    )  # fmt: skip
    search = SimpleNamespace(aims=[name], minimised=[name], maximised=[])
    best = [SimpleNamespace(number=1, parameters={}, values={name: speed}, feasible=True)]
    answer: Any = SimpleNamespace(study=study, search=search, best=best, cases=best, refined=0, reason="")
    parts = optimum(answer).parts
    assert sum("no impact in a best case" in str(part) for part in parts) == count
    assert sum("its start included" in str(part) for part in parts) == 1
    request["wanted"] = {"turns": 2, "last": 1, "counts": "last"}
    parts = optimum(answer).parts
    assert sum("counted over the last turn of each case" in str(part) for part in parts) == 1
    assert not any("its start included" in str(part) for part in parts)


def with_errors(study: vfife.studies.Study, bar: float) -> vfife.studies.Study:
    """Give the cases of a study a numerical error of the force (N), in a sensitive motion."""
    from vfife.results.case_errors import ErrorEstimate

    estimate = ErrorEstimate(12, bar / 2.0, bar / 2.0, bar, 1.5, 0, 3)
    study.__dict__["_sample_errors"] = SimpleNamespace(
        estimates={"C.force.max": estimate}, sensitive=(3, 12), bars=lambda _, cases: [bar] * len(cases)
    )
    return study


def test_maps_name_turns_and_errors_and_hatch_cells_within_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = with_errors(made(GRID, tmp_path, monkeypatch), 2.3456)
    figure = found.plot("maps")["maps"]
    force, count = figure.axes[:2]
    values = found.data["C.force.max"].values
    hatched = {
        tuple(np.add(one.get_xy(), (one.get_width() / 2, one.get_height() / 2))) for one in force.patches
    }
    inside = np.abs(values - np.median(values)) < 2.3456
    speeds, plays = found.data.speed.values, 1e3 * found.data.play.values
    centres = [(speeds[column], plays[row]) for row, column in np.argwhere(inside)]
    assert 0 < len(centres) < values.size and len(hatched) == len(centres) and not count.patches
    assert all(any(np.allclose(one, two) for two in hatched) for one in centres)
    assert force.get_title("left").split("\n")[1:] == ["last turn", "numerical error up to 2.35 N"]
    assert count.get_title("left").split("\n")[1:] == ["whole case", "numerical error not estimated"]
    title = figure.get_suptitle().replace("\n", " ")
    assert "3 of 12 sampled cases are sensitive to the step; hatched: equal to the median" in title


THREE = GRID + '[vary.fit]\npath = "joint.C.contact.restitution"\nvalues = [0.5, 0.7, 0.9]\n'


def test_curves_of_medians_show_numerical_errors_beside_their_bands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bands are those of a third parameter: they are no uncertainty, and the bars stand beside them."""
    found = with_errors(made(THREE, tmp_path, monkeypatch), 2.3456)
    figure = found.plot("curves")["curves"]
    title = figure.get_suptitle().replace("\n", " ")
    assert "over fit, without numerical errors); bars: largest numerical error" in title
    assert "3 of 12 sampled cases are sensitive to the step" in title
    force, count = figure.axes
    assert force.get_title("left").split("\n")[2] == "numerical error up to 2.35 N"
    assert count.get_title("left").split("\n")[2] == "numerical error not estimated"
    assert not any(isinstance(one, LineCollection) for one in count.collections)
    bars = [one for one in force.collections if isinstance(one, LineCollection)]
    assert len(bars) == 3
    middle = np.median(found.laid_out("C.force.max")[0], axis=1)
    ends = np.array([segment[:, 1] for segment in bars[0].get_segments()])
    assert ends[:, 1] == pytest.approx(middle + 2.3456)


def test_a_median_does_not_count_cases_without_impact_as_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "C.approach_speed.max"
    found = made(THREE.replace('"C.impacts"', f'"{name}"'), tmp_path, monkeypatch)
    for case in found.done:
        found.outcomes[case.number]["measures"][name] = 0.1 + 0.2 * found.place(case)[2]
    quiet = [case for case in found.done if found.place(case)[:2] == (0, 1)]
    found.outcomes[quiet[0].number]["measures"][name] = 0.0
    figures = found.plot("curves", "maps", measures=[name])
    (ax,) = figures["curves"].axes
    rings, line, *_ = ax.lines
    assert rings.get_xdata().tolist() == [line.get_xdata()[1]] and rings.get_ydata().tolist() == [0.0]
    assert line.get_ydata() == pytest.approx([0.3, 0.4, 0.3, 0.3]), "of 0.3 and 0.5, not of 0, 0.3 and 0.5"
    assert "hollow: cases without impact" in ax.get_title("left")
    ax = figures["maps"].axes[0]
    (mesh,) = (one for one in ax.collections if isinstance(one, QuadMesh))
    assert np.asarray(mesh.get_array())[0] == pytest.approx([0.3, 0.4, 0.3, 0.3])
    assert [line.get_xdata().tolist() for line in ax.lines] == [rings.get_xdata().tolist()]
    for case in quiet:
        found.outcomes[case.number]["measures"][name] = 0.0
    figures = found.plot("curves", "maps", measures=[name])
    rings, line, *_ = figures["curves"].axes[0].lines
    assert np.isnan(line.get_ydata()).tolist() == [False, True, False, False]
    (mesh,) = (one for one in figures["maps"].axes[0].collections if isinstance(one, QuadMesh))
    assert mesh.get_array()[0, 1] == 0.0 and len(rings.get_xdata()) == 1, "without any knock: no failed case"


def test_forces_side_by_side_have_one_unit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["C.force.max", "B.force.max", "A.force.max"]
    text = GRID.replace('"C.impacts"', '"B.force.max", "A.force.max"')
    found = made(text, tmp_path, monkeypatch)
    for outcome in found.outcomes.values():
        outcome["measures"].update(zip(names, (2500.0, 1800.0, 3.0), strict=True))
    for figure, count in (("curves", 3), ("maps", 3)):
        axes = found.plot(figure, measures=names)[figure].axes[:count]
        titles = [ax.get_title("left").split("\n")[0] for ax in axes]
        assert titles == ["C.force.max (kN)", "B.force.max (kN)", "A.force.max (N)"], "3 N would be 0.003 kN"


def test_titles_of_maps_stay_within_their_panels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["C.force.max", "follower.angular_acceleration.max", "C.approach_speed.max", "C.penetration.max"]
    listed = ", ".join(f'"{name}"' for name in names[1:])
    found = with_errors(made(GRID.replace('"C.impacts"', listed), tmp_path, monkeypatch), 1.0)
    for outcome in found.outcomes.values():
        force = outcome["measures"]["C.force.max"]
        outcome["measures"].update(dict.fromkeys(names[1:], force - 1.0))
    figure = found.plot("maps", measures=names)["maps"]
    figure.draw_without_rendering()
    boxes = [ax._left_title.get_window_extent() for ax in figure.axes[:4]]
    assert all(box.x1 <= figure.bbox.x1 for box in boxes)
    assert not any(one.overlaps(two) for one, two in itertools.combinations(boxes, 2))


def test_error_bars_of_what_cannot_be_negative_end_at_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = with_errors(made(GRID, tmp_path, monkeypatch), 3.0)
    ax = found.plot("curves")["curves"].axes[0]
    (bars, *_) = (one for one in ax.collections if isinstance(one, LineCollection))
    values = found.data["C.force.max"].values[0]
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    assert ends[:, 0] == pytest.approx(np.maximum(values - 3.0, 0.0)) and (ends[:, 0] == 0.0).any()
    assert ends[:, 1] == pytest.approx(values + 3.0)


def test_a_case_without_impact_has_a_remark_beside_its_speed_and_no_part_in_means(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vfife.report.study import extremes, remarks_on_turns

    name = "C.approach_speed.max"
    found = made(ASKED.replace('"C.impacts"', f'"{name}"'), tmp_path, monkeypatch)
    speeds = [0.0, 0.2, 0.4, 0.2, 0.4, 0.3]
    for case, speed in zip(found.done, speeds, strict=True):
        found.outcomes[case.number]["measures"][name] = speed
    columns = {column.name: column for column in found.table_columns()}
    heads = list(columns)
    assert heads[heads.index(name) + 2] == f"{name}.remark" and "C.force.max.remark" not in heads
    assert columns[name].values == speeds, "the numbers stay"
    assert columns[f"{name}.remark"].values == ["no impact", *[None] * 5]
    found.export(tmp_path / "a.csv")
    heads, first, second, *_ = (tmp_path / "a.csv").read_text("utf-8").splitlines()
    assert f"{name}.remark," in heads and ",no impact," in first and "no impact" not in second
    entry = extremes(found)[name]
    assert (entry["least"], entry["mean"]) == (0.0, pytest.approx(0.3)) and entry["count"] == 6
    assert any("means are of the other cases" in text for text in remarks_on_turns(found))
    for case in found.done:
        found.outcomes[case.number]["measures"][name] = 0.0
    assert extremes(found)[name]["mean"] == 0.0, "no impact in any case"
