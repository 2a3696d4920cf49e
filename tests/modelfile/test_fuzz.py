"""Model texts with anything in them: a mechanism, or faults in sentences, soon; never a traceback, and no
number that is none.
"""

from __future__ import annotations

import pytest

import vfife
from hostile import EXAMPLES, VALUES, model_texts, overrides, quantities
from vfife.errors import VfifeError


def test_changed_models_are_models_or_told() -> None:
    assert 20 < model_texts(700, 1) < 680


def test_changed_models_are_put_together_or_told() -> None:
    assert model_texts(150, 5, assembled=True) > 5


def test_changes_of_the_command_line_are_taken_or_told() -> None:
    assert 10 < overrides(400, 3) < 390


def test_quantities_are_numbers_or_told() -> None:
    assert 50 < quantities(2500, 4) < 2450


@pytest.mark.parametrize("value", VALUES)
def test_anything_may_be_set(value: str) -> None:
    """What --set gives, for a place of each kind."""
    path = EXAMPLES[0].parent / "four_bar_case_c.toml"
    for place in (
        "joint.C.clearance",
        "run.step",
        "run.outputs",
        "body.coupler.length",
        "driver.crank.speed",
        "gravity",
        "name",
        "joint.C.kind",
    ):
        try:
            vfife.load_model(path, set=[(place, value.strip('"'))])
        except VfifeError as error:
            assert str(error)
