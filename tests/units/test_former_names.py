"""Attributes can be read by the names of version 0.2 for one version more."""

from __future__ import annotations

from typing import Any

import pytest

from vfife.dynamics.maps import Map
from vfife.errors import former_names
from vfife.results.study import Study
from vfife.solvers.record import Record
from vfife.store.studyfile import SPECIFICATION
from vfife.studies.study_work import Optimum
from vfife.tribology.wear_state import Worn


@former_names(old="new")
class Example:
    new = 3


def test_a_former_name_gives_the_attribute_with_a_warning() -> None:
    example: Any = Example()
    with pytest.warns(DeprecationWarning, match=r"Example\.old is new now"):
        assert example.old == 3
    with pytest.raises(AttributeError, match="'other'"):
        _ = example.other


@pytest.mark.parametrize(
    ("owner", "old", "new"),
    [
        (Record, "kept", "row_numbers"),
        (Record, "lost", "damaged_parts"),
        (Study, "asked", "request"),
        (Study, "lost", "damaged_cases"),
        (Study, "damaged_members", "damaged_cases"),
        (Study, "members", "cases"),
        (Optimum, "members", "cases"),
        (Map, "asked", "spec"),
        (Map, "told", "step_report"),
        (Map, "alike", "agreement"),
        (Worn, "asked", "spec"),
        (Worn, "ended", "life_end"),
        (Worn, "beside", "step_difference"),
        (Worn, "play", "clearance"),
    ],
)
def test_names_of_answers(owner: type, old: str, new: str) -> None:
    one: Any = owner.__new__(owner)
    if new == "request":
        new_value: Any = {"name": "x"}
        one.meta = {SPECIFICATION: new_value}
    else:
        one.__dict__[new] = new_value = 5
    with pytest.warns(DeprecationWarning, match=f"{old} is {new} now"):
        assert getattr(one, old) == new_value
