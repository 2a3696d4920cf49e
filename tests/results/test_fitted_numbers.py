"""What a fit says of its parameters and curves, in closed form: shares of bounds, what is known, what lies on
a bound, sentences.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from vfife.report.sensitivity import identification
from vfife.results.fit import Fit, FitCurve, FitValue, values_of

ONE = FitValue("k", ("spring.k.stiffness",), "N/m", 300.0, 5.0, 290.0, 320.0, (200.0, 600.0))


def fit_of(*values: FitValue, **changes: object) -> Fit:
    """A fit of some parameters with one curve that misses by half of its deviation."""
    measured = np.array([1.0, -1.0, 1.0, -1.0])
    curve = FitCurve("b.x", "x", "m", "time", np.arange(4.0), measured, 1.5 * measured)
    made = Fit(
        "oscillator", "swing.csv", "complete", list(values), np.eye(len(values)), [], 0.0, 0.0, "time",
        [curve], [], 0, 0, "tangents", 0.0, 0.95, 1.0,
    )  # fmt: skip
    return replace(made, **changes)  # type: ignore[arg-type]


def test_a_share_is_where_a_value_lies_between_its_bounds() -> None:
    assert [ONE.share(value) for value in (200.0, 300.0, 600.0)] == [0.0, 0.25, 1.0]
    wide = replace(ONE, bounds=(1.0, 1e4), logarithmic=True)
    assert [wide.share(value) for value in (1.0, 10.0, 1e4)] == pytest.approx([0.0, 0.25, 1.0])
    assert wide.share(0.0) == pytest.approx(-0.75), "a thousandth of the lower bound at the least"


def test_limits_beyond_both_bounds_are_no_numbers_to_quote() -> None:
    lost = replace(ONE, error=1e9, low=-2e9, high=2e9)
    assert lost.words(0.95) == "k = 300 N/m (not determined by these data)"
    shown = str(identification(fit_of(lost)).parts)
    assert "not determined by these data" in shown and "e+09" not in shown and "GN" not in shown
    assert "95 %: 150 to 700" not in replace(lost, low=150.0, high=700.0).words(0.95)
    assert "95 %" in replace(lost, low=250.0, high=700.0).words(0.95)


def test_a_confidence_of_a_quarter_of_the_bounds_is_the_widest_that_tells() -> None:
    assert replace(ONE, high=400.0).determined and not replace(ONE, high=401.0).determined
    assert not replace(ONE, known=False).determined
    with pytest.warns(DeprecationWarning, match="determined"):
        assert replace(ONE, high=400.0).told


def test_a_value_within_a_hundredth_of_either_bound_lies_on_it() -> None:
    on = [replace(ONE, value=value).at_bound for value in (200.0, 203.0, 205.0, 400.0, 595.0, 597.0, 600.0)]
    assert on == [True, True, False, False, False, True, True]


def test_what_is_left_is_over_the_deviation() -> None:
    """Half of ±1 is missed everywhere; two curves together by the root of the mean of their squares."""
    found = fit_of(ONE)
    (curve,) = found.curves
    assert curve.share == 0.5 == found.share
    off = replace(curve, model=curve.measured)
    assert fit_of(ONE, curves=[curve, off]).share == pytest.approx(0.5 / math.sqrt(2.0))
    assert replace(curve, measured=np.ones(4)).share == math.inf


def test_directions_that_the_data_leave_open_are_named() -> None:
    two, third = replace(ONE, name="c"), replace(ONE, name="m")
    root = 1.0 / math.sqrt(2.0)
    directions = [
        (0.9, np.array([root, -root, 0.0])),
        (0.3, np.array([0.0, 0.0, 1.0])),
        (0.2, np.array([1.0, 0.0, 0.0])),
    ]
    both, alone = fit_of(ONE, two, third, directions=directions).undetermined
    assert both.startswith("k and c one by one: k up with c down") and alone.startswith(
        "m: within its bounds"
    )


def test_what_is_not_known_is_no_number() -> None:
    """An interrupted fit has no correlation; limits of a value whose confidence is not known are none."""
    two = replace(ONE, name="c", low=100.0, high=500.0)
    for entry, count in ((math.nan, 0), (0.99, 1)):
        correlation = np.array([[1.0, entry], [entry, 1.0]])
        assert len(fit_of(ONE, two, correlation=correlation).splits) == count
    frame = fit_of(ONE, replace(two, known=False)).to_dataframe()
    assert list(frame.loc["k", ["standard_error", "low", "high"]]) == [5.0, 290.0, 320.0]
    assert frame.loc["c", ["standard_error", "low", "high"]].isna().all() and frame.loc["c", "value"] == 300.0
    unknown = replace(two, known=False)
    assert all(map(math.isnan, (unknown.error, unknown.low, unknown.high))) and unknown.ends == (
        200.0,
        500.0,
    ), "within the bounds"
    assert math.isnan(unknown.json()["low"]) and unknown.width == 0.5
    assert "not known; fits nearly as well from 200 to 500)" in unknown.words(0.95), "within its bounds"
    assert "290" in ONE.words(0.95)
    again = values_of([vars(unknown)])[0]
    assert again.ends == (200.0, 500.0) and math.isnan(again.low), "a file has the ends"
    former = {name: value for name, value in vars(two).items() if name != "ends"} | {"known": False}
    assert values_of([former])[0].ends == (200.0, 500.0), "a former file has limits"


def test_remarks_say_how_it_was_found() -> None:
    assert fit_of(ONE).remarks == []
    starts = [(1.0, (300.0,)), (1.09, (301.0,)), (1.2, (500.0,))]
    found = fit_of(ONE, offset=0.5, offset_error=0.01, starts=starts, evaluations=40).remarks
    assert found[0].startswith("The first sample of the data was taken 500 ± 10 ms") and found[1].startswith(
        "2 of 3 searches reached this point"
    )
    assert "90 ± 5.7 deg" in fit_of(ONE, over="angle", offset=math.pi / 2.0, offset_error=0.1).remarks[0]
    unknown = fit_of(replace(ONE, known=False), offset=0.5, offset_error=math.nan).remarks[0]
    assert "taken 500 ms after" in unknown and "confidence not known" in unknown and "±" not in unknown
    assert (
        "(correlation 0.11)" in fit_of(ONE, autocorrelation=0.11).remarks[0]
        and fit_of(ONE, autocorrelation=0.1).remarks == []
    )
    assert fit_of(replace(ONE, value=200.0)).remarks == ["At a bound, so perhaps beyond it: k."]


def test_a_file_has_null_for_what_is_not_known_and_the_ends_of_all_that_fits(tmp_path) -> None:
    """NaN is no JSON."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    fit_of(ONE, replace(ONE, name="c", known=False)).write_json(tmp_path / "fit.json")
    sure, unknown = json.loads((tmp_path / "fit.json").read_text(), parse_constant=refuse)["parameters"]
    assert (sure["low"], sure["high"]) == (290.0, 320.0) and "ends" not in sure
    assert unknown["low"] is unknown["standard_error"] is None and unknown["ends"] == [290.0, 320.0]
