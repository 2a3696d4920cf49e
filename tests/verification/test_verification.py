"""The verification suite passes, and every number of it would notice a model that is a little wrong."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache

import pytest

from vfife import gallery
from vfife.report.terminal import as_text
from vfife_validation.verification import CASES, Case, Row, entry, page, ranges

SYSTEM = pytest.mark.system("compares whole runs with references")
QUICK = [
    pytest.param(one, id=name, marks=SYSTEM if one.quick else pytest.mark.verify)
    for name, one in CASES.items()
]


def failed(rows: Iterable[Row]) -> set[str]:
    return {row.quantity for row in rows if not row.passed}


@cache
def rows_of(name: str) -> tuple[Row, ...]:
    """What a case comes to as it stands."""
    return tuple(CASES[name].check())


@pytest.mark.parametrize("case", QUICK)
def test_passes(case: Case) -> None:
    rows = rows_of(case.name)
    assert rows and not failed(rows), [
        (row.quantity, row.reference, row.value, row.error, row.note) for row in rows if not row.passed
    ]


@pytest.mark.parametrize("case", QUICK)
def test_every_number_notices_a_nudged_model(case: Case) -> None:
    """Each nudge breaks a number at least, each number breaks under a nudge at least, and the model still
    runs.
    """
    told = [case.check({name: value}) for name, value in case.nudges.items()]
    numbers = {row.quantity for row in rows_of(case.name)}
    assert all({row.quantity for row in rows} == numbers for rows in told)
    assert all(failed(rows) for rows in told), "a nudge changes nothing that the tolerances notice"
    assert set().union(*(failed(rows) for rows in told)) == numbers, "a number that nothing breaks"


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_says_where_it_comes_from(case: Case) -> None:
    assert case.title and case.source and case.nudges and case.family
    assert case.name == case.name.lower()


@pytest.mark.system("runs nudged models")
def test_tolerances_are_tight() -> None:
    """Statics 0.1 %, the rest at most 1 %, as a run of the tight cases tells; scales are never larger than
    what is measured can be.
    """
    for name in (
        "elastica",
        "closed-circle",
        "williams-toggle",
        "follower-frame",
        "welded-arm",
        "elastic-guide",
    ):
        assert not CASES[name].quick  # its rows are looked at in the next test, where they are run
    for case in (one for one in CASES.values() if one.quick):
        assert all(row.tolerance <= 1e-2 for row in rows_of(case.name))


@pytest.mark.verify
def test_tolerances_of_the_long_cases_are_tight() -> None:
    """Two shares of scattered values claim less than 99 %: 97 % of sensitive runs, 95 % of chaotic means."""
    scattered = {
        "share of the measures inside their range": 0.03,
        "share of the means of two chaotic motions inside their range": 0.05,
    }
    for name, case in ((name, case) for name, case in CASES.items() if not case.quick):
        exempt = scattered if name == "ranges-of-sensitive-runs" else {}
        limit = 1e-3 if case.family == "equilibria" else 1e-2
        for row in case.check():
            assert row.tolerance <= exempt.get(row.quantity, limit) + 1e-12, (name, row)


def test_a_number_that_is_none_fails() -> None:
    for value in (math.nan, math.inf):
        assert not Row("x", "m", 1.0, value, 1e-2).passed
    assert not Row("x", "m", 0.0, 0.0, 1e-2).passed  # no scale: nothing can be said
    assert Row("x", "m", 0.0, 1e-3, 1e-2, 1.0).passed


def test_a_model_that_cannot_run_is_a_failed_case() -> None:
    def rows(nudge):  # type: ignore[no-untyped-def]
        yield Row("first", "1", 1.0, 1.0, 1e-3)
        raise RuntimeError("the run ended diverged")

    found = Case("broken", "Broken", "none", "tests", rows, {}).check()
    assert [row.passed for row in found] == [True, False]
    assert "diverged" in found[-1].note


def test_page_is_made_of_the_cases() -> None:
    from vfife_validation.verification.page import FAMILIES, tables

    assert {one.family for one in CASES.values()} == set(FAMILIES)
    text = tables([CASES["gear-pair"], CASES["motor-curve"], CASES["andrews-squeezer"]])
    assert text.count("## Gears, motors and prescribed motion") == 1
    assert "| beta at 0.03 s | rad | 15.8108 | 15.8108 |" in text
    with pytest.raises(RuntimeError, match="'broken'"):
        tables(
            [
                Case(
                    "broken",
                    "Broken",
                    "none",
                    "tests",
                    lambda nudge: iter([Row("x", "m", 1.0, 2.0, 1e-3)]),
                    {},
                )
            ]
        )


def test_a_share_stands_with_its_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a mechanism as it stands and one that is slower: how many runs and measures were compared, on the
    screen, on the page and as data.
    """
    monkeypatch.setattr(ranges, "MECHANISMS", (gallery.slider_crank,))
    monkeypatch.setattr(ranges, "VARIANTS", ((1.0, 1.0), (1.0, 0.5)))
    case = CASES["ranges-of-runs"]
    runs, measures, _ = rows = case.check()
    assert runs.counts == {"mechanisms as they stand": (1, 1), "runs": (2, 2)}
    ((inside, total),) = measures.counts.values()
    assert total > 20 and measures.value == inside / total
    text = f"{inside} of {total} measures inside"
    assert text in as_text(page.document(case, rows)) and text in page.tables([case])
    assert entry(case, measures)["counts"] == {"measures inside": {"count": inside, "of": total}}
    assert "counts" not in entry(case, rows[2])
    wrong = case.check({"width": 0.0})[1]
    ((fewer, same),) = wrong.counts.values()
    assert fewer < same == total and wrong.value == fewer / same  # not rounded
