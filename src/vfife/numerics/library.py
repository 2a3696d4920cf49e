"""The compiled routines: one text of all of them, one file of object code, loaded with the first call."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..compiler.backends.kinds import entry_of
from ..compiler.runtime.cache import digest
from ..compiler.runtime.native import Called, interpreted, library
from ..compiler.trace.source import Gathered
from ..compiler.trace.traceable import WRITING
from .routines import eigenvalues, functions, linear, singular

# Routines and the kinds of their arguments: f3 an array of numbers with three dimensions, d a number, i an
# integer.
ROUTINES: dict[Callable[..., None], str] = {
    linear.multiply: "f3 f3 f3",
    linear.multiply_vectors: "f3 f2 f2",
    linear.eliminate: "f3 f3 f1",
    singular.factors: "f3 f3 f3 f1",
    singular.decompose: "f3 f3 f2 f3 f1 i",
    eigenvalues.eigenvalues: "f3 f2 f2 f2",
    linear.factorise: "f1 f1 f1 i d",
    linear.substitute_back: "f1 f1 f1 f1 i",
    functions.turn_all: "f1 f1 f1",
    functions.raise_all: "f1 f1 f1",
    functions.exponentials: "f1 f1",
    functions.logarithms: "f1 f1",
    functions.directions_of: "f1 f1 f1",
}


def text() -> str:
    """Text of all routines and what they call."""
    with WRITING:
        gathered = Gathered()
        for routine in ROUTINES:
            gathered.add(routine)
        return gathered.text()


@lru_cache(maxsize=1)
def compiled() -> dict[str, Called]:
    """Each routine by its name, compiled."""
    entries = {routine.__name__: entry_of(kinds) for routine, kinds in ROUTINES.items()}
    return library(_sources(), entries, wide=True, write=text)


def _sources() -> str:
    """Return a hash of the files that the text is gathered from. The kernels are not in it, because the key
    of every file of the cache has them already.
    """
    return digest(file.read_bytes() for file in sorted((Path(__file__).parent / "routines").glob("*.py")))


@lru_cache(maxsize=1)
def plain() -> dict[str, Callable[..., Any]]:
    """Return the same routines as plain Python: slow, with the same bits."""
    body = text()
    return {routine.__name__: interpreted(body, routine.__name__) for routine in ROUTINES}
