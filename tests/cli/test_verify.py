"""`vfife verify` runs cases of the verification suite."""

import json
import re
from collections.abc import Callable

import pytest

from vfife.cli.commands.verify import PAGES, items_of
from vfife.job.activity import ACTIVITY
from vfife.job.amounts import span
from vfife_validation.paper.contents import Item
from vfife_validation.verification import CASES, Case, Row


def test_tells_each_number(command: Callable) -> None:
    done = command("verify", "gear-pair", "motor-curve", "--json")
    assert done.exit_code == 0, done.stderr
    told = json.loads(done.stdout)["cases"]
    assert {one["case"] for one in told} == {"gear-pair", "motor-curve"}
    first = told[0]
    assert {"case", "source", "reference", "value", "error", "tolerance", "passed"} <= set(first)
    assert first["passed"] is True and first["reference"] == pytest.approx(0.125 * 2.0 / 0.068)


def test_for_people(command: Callable) -> None:
    done = command("verify", "Gear-Pair")
    assert done.exit_code == 0
    assert "moment of the gear on the second" in done.stdout
    assert "1 of 1 cases passed" in done.stdout


def test_lists(command: Callable) -> None:
    assert {one["case"] for one in json.loads(command("verify", "--list", "--json").stdout)["cases"]} == set(
        CASES
    )
    assert "williams-toggle" in command("verify", "--list").stdout
    assert command("verify", "list").stdout == command("verify", "--list").stdout


@pytest.mark.parametrize("group", PAGES)
def test_each_item_of_a_page_has_a_forecast(group: str) -> None:
    items = items_of(group)
    assert items.SECONDS.keys() == items.ITEMS.keys() and min(items.SECONDS.values()) > 0.0


def test_a_page_is_forecast_before_its_first_item_and_names_the_present_one(
    command: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The time of one item and what is left for the others."""
    items, texts = items_of("trends"), []

    def interrupt() -> Item:
        texts.append((ACTIVITY.text, ACTIVITY.seconds))
        raise KeyboardInterrupt

    monkeypatch.setitem(items.ITEMS, "chain", interrupt)
    done = command("verify", "trends", "chain", "scatter")
    assert done.exit_code == 130 and "no item was done" in done.stderr
    both = items.SECONDS["chain"] + items.SECONDS["scatter"]
    assert f"forecast: 2 items: {span(both)} on an idle machine" in done.stderr
    (text, seconds), left = texts[0], span(items.SECONDS["scatter"])
    assert text == f"chain (1 of 2, then about {left} for the others)" and seconds == items.SECONDS["chain"]


def test_titles_name_no_class() -> None:
    """A title is a sentence for readers: no word in it is the name of a class of the package."""
    inner_capital = re.compile(r"\b[A-Z][a-z]+[A-Z]\w+")
    assert CASES and not [case.title for case in CASES.values() if inner_capital.search(case.title)]


def test_unknown_case(command: Callable) -> None:
    done = command("verify", "wiliams-togle", "gear-pair", "xyzzy")
    assert done.exit_code == 2
    assert "'wiliams-togle'; did you mean 'williams-toggle'" in done.stderr
    assert "'xyzzy'" in done.stderr and "--list" in done.stderr


def test_a_failed_case_ends_with_1(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = Case("wrong", "Wrong", "nobody", "tests", lambda nudge: iter([Row("x", "m", 1.0, 1.1, 1e-2)]), {})
    monkeypatch.setitem(CASES, "wrong", wrong)
    done = command("verify", "wrong")
    assert done.exit_code == 1
    assert "FAILED" in done.stdout and "failed: wrong" in done.stdout
    assert json.loads(command("verify", "wrong", "--json").stdout)["cases"][0]["passed"] is False


def test_ctrl_c_keeps_what_is_done(command: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    def rows(nudge):
        raise KeyboardInterrupt
        yield

    monkeypatch.setitem(CASES, "stopped", Case("stopped", "Stopped", "nobody", "tests", rows, {}))
    done = command("verify", "gear-pair", "stopped", "--json")
    assert done.exit_code == 130
    told = json.loads(done.stdout)
    assert told["interrupted"] is True and {one["case"] for one in told["cases"]} == {"gear-pair"}
    assert "after 1 of 2 cases" in done.stderr
