"""The package does not grow unnoticed: who needs more raises a limit here, and says why in the commit."""

from __future__ import annotations

import dataclasses

import pytest

from architecture.size import Size, size_of, sizes

LIMITS = Size(
    files=450, code=61_000, tokens=600_000, import_lines=5_800, inner_imports=235, many_arguments=9, tuples=28
)


@pytest.mark.slow("reads every file token by token")
def test_the_package_is_no_larger_than_its_limits() -> None:
    found = sum(sizes().values(), Size())
    more = {
        name: (count, limit)
        for name, limit in dataclasses.asdict(LIMITS).items()
        if (count := getattr(found, name)) > limit
    }
    assert not more, more


def test_sizes_are_counted() -> None:
    text = '''"""One."""
from ..a import b, \\
    c


def f(self, p1, p2, p3, p4, p5, p6, *, p7, p8) -> tuple[int, str, float]:
    """Two."""
    from .d import e  # three

    return e("""
four""")
'''
    found = size_of(text)
    assert (found.code, found.import_lines, found.inner_imports, found.many_arguments, found.tuples) == (
        6,
        3,
        1,
        1,
        1,
    )
