"""The JSON Schema of fit plans: it accepts the plan of the documentation, and no key or value beside it."""

import re
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from schemas import complaints
from vfife.cli.app import app
from vfife.identification.fit_plan import plan_schema, schema_text

PAGE = Path(__file__).parents[2] / "docs" / "fit.md"
PLAN = next(
    one for one in re.findall(r"```toml\n(.*?)```", PAGE.read_text("utf-8"), re.S) if "[[record]]" in one
)
SCHEMA = plan_schema()


def test_the_plan_of_the_page_fits() -> None:
    assert list(complaints(tomllib.loads(PLAN), SCHEMA, SCHEMA)) == []


@pytest.mark.parametrize(
    "before, after",
    [
        ('start = "data"', 'start = "guess"'), ("every = 10", "every = 0"), ("every = 10", "evry = 10"),
        ('data = "slow.csv"', 'date = "slow.csv"'), ('"0.5..2 kg cm^2"', "[1]"),
        ('set = { "body', 'sett = { "body'), ("model =", "modell ="), ("[[record]]", "[[records]]"),
    ],
)  # fmt: skip
def test_what_a_plan_may_not_have_does_not(before: str, after: str) -> None:
    assert before in PLAN
    assert list(complaints(tomllib.loads(PLAN.replace(before, after)), SCHEMA, SCHEMA)) != []


def test_the_command_prints_it_and_refuses_two() -> None:
    command = CliRunner()
    assert command.invoke(app, ["schema", "--fit"]).stdout == schema_text()
    both = command.invoke(app, ["schema", "--fit", "--study"])
    assert both.exit_code == 2 and "name one of them" in both.stderr
