"""Call of the compiled routines by name. They and what compiles them are loaded with the first call, because
commands that compute nothing import this package too.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any


def call(name: str, *arguments: Any) -> None:
    """Run a routine on arrays and integers; it writes its results to its arguments."""
    _routines()[name](*arguments)


@lru_cache(maxsize=1)
def _routines() -> dict[str, Callable[..., Any]]:
    from .library import compiled

    return dict(compiled())
