"""The package does not grow unnoticed: who needs more raises a limit here, and says why in the commit."""

from __future__ import annotations

import ast
import dataclasses
import io
import sys
import tokenize

import pytest

from architecture.size import Size, size_of, sizes, tokens

LIMITS = Size(
    files=514,
    code=75_600,
    tokens=765_000,
    import_lines=7_340,
    inner_imports=104,
    many_arguments=10,
    tuples=28,
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
    found = size_of(ast.parse(text), text)
    counts = (found.code, found.import_lines, found.inner_imports, found.many_arguments, found.tuples)
    assert counts == (6, 3, 1, 1, 1)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("x = a.b[-1.5e-3:2] # one\n", 11),
        ('x **= \'it\\\'s\' + rb"""a\n\\""" \'b\' """\n', 5),
        ("def f(a, *, b: int = 0x1F) -> float: ...\n", 17),
        ("if a != b and (c := d // 2) >= 1_000.j:\n    e = f'{a}' \\\n        'b'\n", 19),
    ],
)
def test_tokens_are_those_of_python(text: str, count: int) -> None:
    passed_over = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
    of_python = [
        (one.start[0], one.end[0])
        for one in tokenize.generate_tokens(io.StringIO(text).readline)
        if one.type not in (*passed_over, tokenize.ENDMARKER)
    ]
    assert tokens(text) == of_python or sys.version_info >= (3, 12)
    assert len(tokens(text)) == count
