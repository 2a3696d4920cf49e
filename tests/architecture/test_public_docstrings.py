"""Docstrings of public functions name every argument, what is returned and what is raised."""

from __future__ import annotations

import ast
import builtins
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from typing import Any, get_args, get_type_hints

import vfife

SPACES = (
    "bodies", "drivers", "dynamics", "identification", "joints", "laws", "loads", "springs", "studies",
    "tribology",
)  # fmt: skip
OUTPUT = re.compile(r"\b(returns?|yields?|whether)\b", re.IGNORECASE)


def public() -> Iterator[tuple[str, Any]]:
    for module in (vfife, *(getattr(vfife, space) for space in SPACES)):
        yield from ((f"{module.__name__}.{name}", getattr(module, name)) for name in module.__all__)


def functions() -> Iterator[tuple[str, str, Callable[..., Any]]]:
    """Every public function and method, with its name and its docstring after those that it overrides."""
    seen = set[Any]()
    for name, value in public():
        members = inspect.getmembers_static(value) if inspect.isclass(value) else [("", value)]
        for member, held in members:
            function = getattr(held, "__func__", held)
            own = inspect.isfunction(function) and function.__module__.startswith("vfife")
            if own and function not in seen and not member.startswith("_"):
                seen.add(function)
                bases = [vars(base).get(member) for base in value.__mro__] if member else []
                texts = [inspect.getdoc(getattr(one, "__func__", one)) or "" for one in (held, *bases) if one]
                yield f"{name}.{member}".rstrip("."), "\n".join(texts), function


def arguments(function: Callable[..., Any]) -> set[str]:
    """Names of arguments, and the keywords of a group that is taken as ``**options``."""
    names = set[str]()
    for one in inspect.signature(function).parameters.values():
        names.add(one.name)
        if one.kind is one.VAR_KEYWORD and "Unpack" in str(one.annotation):
            (group,) = get_args(get_type_hints(function, include_extras=True)[one.name])
            names |= set(get_type_hints(group))
    return names - {"self", "cls"}


def named(name: str, text: str) -> bool:
    return re.search(rf"(?<![\w.]){re.escape(name)}\b", text) is not None


def raised(function: Callable[..., Any]) -> Iterator[type[BaseException]]:
    for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function)))):
        called = node.exc.func if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) else None
        name = getattr(called, "id", getattr(called, "attr", ""))
        error = getattr(vfife.errors, name, None) or getattr(builtins, name, None)
        if error is not None:
            yield error


def faults(text: str, function: Callable[..., Any]) -> Iterator[str]:
    yield from (
        f"argument {name} is not named" for name in sorted(arguments(function)) if not named(name, text)
    )
    returned = inspect.signature(function).return_annotation
    if returned not in (None, "None", "NoReturn", inspect.Signature.empty) and not OUTPUT.search(text):
        yield f"says nothing of the {returned} that it returns"
    for error in raised(function):
        if not any(one.__name__ in text for one in error.__mro__[:-3] or [error]):
            yield f"says nothing of {error.__name__}, which it raises"


def test_public_functions_name_their_arguments_results_and_errors() -> None:
    every = list(functions())
    assert len(every) > 200
    assert [f"{name}: {one}" for name, text, function in every for one in faults(text, function)] == []


def test_public_classes_name_their_fields() -> None:
    """A field has a description of its own, or the docstring of its class names it."""
    undescribed = []
    for name, value in public():
        if inspect.isclass(value) and dataclasses.is_dataclass(value):
            text = "\n".join(inspect.getdoc(base) or "" for base in value.__mro__)
            fields = [one for one in dataclasses.fields(value) if one.init and not one.metadata]
            undescribed += [f"{name}: {one.name}" for one in fields if not named(one.name, text)]
    assert undescribed == []


def sample(length: float, mass: float) -> float:
    """Divide a mass by a length (m)."""
    if length == 0.0:
        raise ValueError("no length")
    return mass / length


def test_a_docstring_with_gaps_is_reported() -> None:
    text = inspect.getdoc(sample) or ""
    assert list(faults(text, sample)) == [
        "says nothing of the float that it returns", "says nothing of ValueError, which it raises"
    ]  # fmt: skip
    assert list(faults("Return the quotient. Raises ValueError.", sample)) == [
        "argument length is not named", "argument mass is not named"
    ]  # fmt: skip
    assert not list(faults(f"{text} Returns kg/m. Raises ValueError for 0 m.", sample))
    fit = next(text for name, text, _ in functions() if name == "vfife.fit")
    assert list(faults(fit.replace("screened: ", ""), vfife.fit)) == ["argument screened is not named"]
