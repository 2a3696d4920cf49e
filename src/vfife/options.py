"""Keywords of the functions that run something, grouped by purpose: what to run, what to save, what to
compute with.

Every function takes them as plain keywords, ``simulate(m, turns=10, loop="generated")``. A group is a mapping
with types, for keywords that a script passes several times:

>>> from vfife.options import Run
>>> long = Run(turns=40, settle="1 %")  # simulate(m, **long), compare(m, ["hertz"], **long)
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

from .errors import ArgumentError, Fault, LawError, ModelError, shown, suggestion

if TYPE_CHECKING:
    from pathlib import Path

    from .solvers.arguments import Loop

Function = TypeVar("Function", bound=Callable[..., Any])


class Length(TypedDict, total=False):
    """Length and step of a run. Keys that are left out or None default to the settings of the mechanism."""

    turns: float | None  # of the crank
    duration: float | str | None  # s, instead of turns
    step: float | str | None  # s, or "auto" for the largest that is stable and accurate
    companions: int | str | None  # 0 to 7, or "auto": runs with other steps, which estimate the error
    force_step: bool  # take a step that is larger than the stable one


class Run(Length, total=False):
    """What to run."""

    settle: float | str | None  # 1: ends as soon as turns repeat within this share of their largest values
    loop: Loop  # "auto", "data-driven", "generated" or "interpreted", which give the same bits


class Watch(TypedDict, total=False):
    """How to watch a computation, and what it may cost."""

    progress: Callable[..., None] | None  # called with what is done so far
    confirm: bool  # run even what takes more than an hour, or half of the memory or of the disk


class Save(TypedDict, total=False):
    """What to save."""

    file: str | Path | None  # keeps what is computed; the same call goes on after what it has
    force: bool  # replace another file that is there


class Compute(TypedDict, total=False):
    """What to compute with."""

    workers: int | None  # threads, or processes of a cluster; as many as there are processors unless said
    cluster: str | None  # "local" for processes, or the address of a scheduler of dask.distributed
    device: str | None  # "cuda" for an NVIDIA card


@contextmanager
def named_interrupt(caller: str) -> Iterator[None]:
    """Raise KeyboardInterrupt with a sentence where Ctrl-C leaves the function ``caller`` nothing to return.

    Functions return, or raise in an :class:`~vfife.Interrupted`, what they have computed. While they assemble
    a model, find a step or compile, they have nothing.
    """
    try:
        yield
    except KeyboardInterrupt as interrupt:
        if type(interrupt) is not KeyboardInterrupt:
            raise
        sentence = f"{caller}() was interrupted before it had a result to return"
        raise KeyboardInterrupt(sentence) from None


def refuse_arguments(
    caller: str,
    signature: Mapping[str, inspect.Parameter],
    values: Sequence[Any],
    values_by_name: Mapping[str, Any],
) -> None:
    """Raise ArgumentError for a call of the function ``caller`` with unknown, superfluous or missing
    arguments; ``signature`` are its parameters by name.
    """
    positional = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
    leading = [name for name, parameter in signature.items() if parameter.kind in positional]
    named = [name for name in signature if signature[name].kind is inspect.Parameter.KEYWORD_ONLY]
    is_open = any(parameter.kind is parameter.VAR_KEYWORD for parameter in signature.values())
    required = [name for name in (*leading, *named) if signature[name].default is inspect.Parameter.empty]
    present = {*leading[: len(values)], *values_by_name}
    faults = [
        Fault(
            (name,), "there is no such keyword", shown(value), "", suggestion(name, signature, "leave it out")
        )
        for name, value in values_by_name.items()
        if name not in signature and not is_open
    ]
    if not faults and len(values) > len(leading):
        allowed = f"only {', '.join(leading)} may be given without a name" if leading else "all have names"
        remedy = f"name it, as in {named[0]}=..." if named else "leave it out"
        value = shown(values[len(leading)])
        faults = [Fault(f"argument {len(leading) + 1}", allowed, value, "", remedy)]
    if not faults:
        faults = [
            Fault((name,), "this argument is given twice", shown(values_by_name[name]), "", "leave one out")
            for name in leading[: len(values)]
            if name in values_by_name
        ]
    if not faults:
        missing = [name for name in required if name not in present]
        faults = [Fault((name,), "this argument is missing", remedy=f"add {name}=...") for name in missing]
    if faults:
        raise ArgumentError(faults, f"{caller}()")


def with_faults(*groups: type) -> Callable[[Function], Function]:
    """Return a decorator for a function whose unknown, superfluous and missing arguments raise ArgumentError;
    the keywords in its ``**options``, if it has any, are those of the ``groups``.
    """

    def decorate(function: Function) -> Function:
        signature = dict(inspect.signature(function).parameters)
        rest = [name for name, parameter in signature.items() if parameter.kind is parameter.VAR_KEYWORD]
        if rest and groups:
            del signature[rest[0]]
        for name in (name for group in groups for name in group.__annotations__):
            signature[name] = inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None)

        @functools.wraps(function)
        def call(*values: Any, **values_by_name: Any) -> Any:
            refuse_arguments(function.__name__, signature, values, values_by_name)
            return function(*values, **values_by_name)

        return call  # type: ignore[return-value]

    return decorate


def with_options(group: type, **defaults: Any) -> Callable[[Function], Function]:
    """Return a decorator that gives a function with ``**options`` the keywords of a group, with ``defaults``
    or None.

    The signature, which help() and editors show, lists them one by one. Any other keyword raises
    ArgumentError. Ctrl-C before there is a result raises KeyboardInterrupt with a sentence.
    """
    names: dict[str, Any] = dict.fromkeys(group.__annotations__) | defaults

    def decorate(function: Function) -> Function:
        @functools.wraps(function)
        def call(*values: Any, **values_by_name: Any) -> Any:
            refuse_arguments(function.__name__, signature, values, values_by_name)
            try:
                with named_interrupt(function.__name__):
                    return function(*values, **{**names, **values_by_name})
            except (LawError, ModelError) as error:  # faults of the input: where it was examined says nothing
                raise error.with_traceback(None) from None

        declared = inspect.signature(function)
        parameters = [
            parameter
            for parameter in declared.parameters.values()
            if parameter.kind is not parameter.VAR_KEYWORD
        ]
        keywords = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=default,
                annotation=group.__annotations__[name].__forward_arg__,
            )
            for name, default in names.items()
        ]
        signature = declared.replace(parameters=[*parameters, *keywords]).parameters
        setattr(call, "__signature__", declared.replace(parameters=list(signature.values())))  # noqa: B010 - a checker forbids the assignment
        return call  # type: ignore[return-value]

    return decorate
