"""A study that is written here: its axes, coordinates, places, points and rows, without any run."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vfife.errors import VfifeError
from vfife.measures.catalogue import unit_of
from vfife.results.parameters import in_order
from vfife.results.study import Study
from vfife.store.studyfile import StudyCase

GRID = [(a, b) for a in (3.0, 1.0) for b in ("soft", "hard")]
A, B = "body.a.mass", "joint.B.contact"


def made(kinds: tuple[str, str], values: list[tuple[object, object]], ended: int) -> Study:
    """A study of two parameters whose first cases have ended; C.force.max is their number."""
    parameters = [
        {"name": name, "paths": [path, f"{path}.too"], "unit": unit, "kind": kind, "words": ""}
        for name, path, unit, kind in zip(("a", "b"), (A, B), ("kg", "1"), kinds, strict=True)
    ]
    asked = {"parameters": parameters, "measures": {"C.force.max": "N"}}
    outcomes = {
        k: {
            "status": "complete",
            "measures": {"C.force.max": float(k)},
            "turns": 2,
            "settled": None,
            "step": 1e-6,
            "reason": "",
        }
        for k in range(ended)
    }
    cases = [StudyCase(k, str(k), {A: first, B: second}) for k, (first, second) in enumerate(values)]
    return Study(None, {"study": asked}, cases, outcomes)


def test_a_grid_has_an_axis_for_each_parameter() -> None:
    """Numbers in their order, words as they came; what is left is NaN."""
    study = made(("values", "values"), GRID, 3)
    assert study.axes == {"a": [1.0, 3.0], "b": ["soft", "hard"]}
    assert (
        study.laid_out("C.force.max")[1].tolist() == [0.0, 1.0] and study.laid_out("C.force.max")[0][0] == 2.0
    )
    assert math.isnan(study.laid_out("C.force.max")[0][1])
    assert [study.place(one) for one in study.cases] == [(1, 0), (1, 1), (0, 0), (0, 1)]
    found = study._coordinates()
    assert found["a"][0] == "a" and found["a"][1].tolist() == [1.0, 3.0]
    assert found["a"][2] == {"units": "kg", "long_name": "body.a.mass, body.a.mass.too"}


def test_samples_lie_beside_what_is_gridded() -> None:
    study = made(("values", "fit"), [(a, b) for a in (1.0, 2.0) for b in (0.1, 0.4, 0.2)], 6)
    assert study.axes == {"a": [1.0, 2.0], "sample": [(0.1,), (0.4,), (0.2,)]}
    assert study.laid_out("C.force.max").tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
    dims, values, _ = study._coordinates()["b"]
    assert dims == "sample" and values.tolist() == [0.1, 0.4, 0.2]


def test_what_fills_no_grid_lies_along_its_members() -> None:
    for kinds, values in ((("values", "values"), GRID[:3]), (("fit", "fit"), [(1.0, 2.0), (3.0, 4.0)])):
        study = made(kinds, values, 2)
        assert study.axes == {"case": values} and study.place(study.cases[1]) == (1,)
        dims, column, _ = study._coordinates()["b"]
        assert dims == "case" and column.tolist() == [one[1] for one in values]


def test_points_count_words_by_their_place() -> None:
    assert made(("values", "values"), GRID, 4).points().tolist() == [
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 0.0],
        [1.0, 1.0],
    ]
    assert made(("values", "values"), GRID, 0).points().shape == (0, 2)


def test_parameters_and_measures_are_found_by_name_and_path() -> None:
    study = made(("values", "values"), GRID, 2)
    assert study.parameter("b").name == study.parameter(B).name == study.parameter(f"{B}.too").name == "b"
    assert study.values("C.force.max").tolist() == [0.0, 1.0]
    for wrong in (lambda: study.parameter("c"), lambda: study.values("D.force.max")):
        with pytest.raises(VfifeError, match="this study"):
            wrong()


def test_rows_have_every_member_and_what_it_came_to() -> None:
    study = made(("values", "values"), GRID, 1)
    first, second, *_ = study.rows()
    assert first["status"] == "complete" and (
        first["case"],
        first["a"],
        first["C.force.max"],
        first["turns"],
    ) == (0, 3.0, 0.0, 2)
    assert second["status"] == "left" and second["C.force.max"] is None and second["turns"] is None
    assert list(first) == list(study.columns)
    assert study.counts == {"complete": 1, "left": 3} and len(study.left) == 3


def test_units_follow_the_ends_of_names() -> None:
    names = (
        "C.force.max",
        "guide.1.penetration.max",
        "mechanism.efficiency",
        "C.impacts",
        "crank.power.mean",
        "C.unheard.of",
    )
    assert [unit_of(one) for one in names] == ["N", "m", "1", "1", "W", "1"]
    assert in_order([3.0, 1.0, 3.0]) == [1.0, 3.0] and in_order(["b", "a", "b"]) == ["b", "a"]
    assert np.array(in_order([2, 1])).tolist() == [1, 2]
