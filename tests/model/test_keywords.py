"""Keywords of all public functions: an unknown one is refused with a sentence that names the function."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import pytest

import vfife
from vfife.errors import ArgumentError, ModelError


def functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield the public functions by name."""
    names = [name for name in vfife.__all__ if inspect.ismodule(getattr(vfife, name))]
    for module in (vfife, *(import_module(f"vfife.{name}") for name in names)):
        for name in getattr(module, "__all__", ()):
            if inspect.isfunction(function := getattr(module, name)):
                yield f"{module.__name__}.{name}", function


FUNCTIONS = dict(functions())


def required(function: Callable[..., Any]) -> list[inspect.Parameter]:
    """Return the arguments that a call must have."""
    parameters = inspect.signature(function).parameters.values()
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [one for one in parameters if one.default is one.empty and one.kind in named]


def test_all_functions_are_found() -> None:
    assert {"vfife.resume", "vfife.fit", "vfife.dynamics.basins", "vfife.gallery.four_bar"} <= set(FUNCTIONS)
    assert len(FUNCTIONS) > 40


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_unknown_keyword_is_a_sentence(name: str) -> None:
    """Also of a function that passes its keywords on, whose sentence may name what it passes them to."""
    function = FUNCTIONS[name]
    arguments = {parameter.name: None for parameter in required(function)}
    with pytest.raises(ModelError, match=r"there is no (such keyword|'clearence')"):
        function(**arguments, clearence=1.0)


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if required(FUNCTIONS[name])])
def test_a_missing_argument_is_a_sentence(name: str) -> None:
    first = required(FUNCTIONS[name])[0].name
    with pytest.raises(ArgumentError, match=rf"{first}: this argument is missing"):
        FUNCTIONS[name]()


def test_an_argument_that_is_given_twice_is_a_sentence() -> None:
    with pytest.raises(ArgumentError, match=r'load\(\), path = "b": this argument is given twice'):
        vfife.load("a", path="b")  # type: ignore[misc]
