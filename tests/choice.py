"""Which cases of a parametrised test run by default; the others run in `.ci/run`."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def default_cases(values: Iterable[Any], default: Callable[[Any], bool], reason: str) -> list[Any]:
    """Return the values as parameters, those for which ``default`` is false marked ``system`` with the
    reason.
    """
    return [
        value if default(value) else pytest.param(value, marks=pytest.mark.system(reason)) for value in values
    ]
