"""The text of a function, found by the syntax tree of its file.

A file is parsed once for all of its functions; ``inspect.getsource`` tokenises it again for each. Only one
thread at a time parses and compiles code (``WRITING``), because Python 3.11 loses count of its recursion
depth when two do so at once.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import textwrap
import threading
from typing import Any

WRITING = threading.RLock()


_files: dict[str, tuple[list[str], dict[int, int]]] = {}


def function_text(function: Any) -> str:
    """Return the text of a plain function's definition, without the indentation of its class.

    Raises OSError if it cannot be found.
    """
    code = function.__code__
    with WRITING:
        lines = linecache.getlines(code.co_filename, function.__globals__)
        cached = _files.get(code.co_filename)
        if cached is None or cached[0] is not lines:
            cached = _files[code.co_filename] = lines, _ends(lines)
    end = cached[1].get(code.co_firstlineno)
    text = inspect.getsource(function) if end is None else "".join(lines[code.co_firstlineno - 1 : end])
    return textwrap.dedent(text)


def function_tree(function: Any) -> ast.AST:
    """Return the syntax tree of a function's definition, without decorators and annotations."""
    tree = parsed(function_text(function))
    if isinstance(tree, ast.FunctionDef):
        tree.decorator_list, tree.returns = [], None
        for argument in [*tree.args.args, *tree.args.kwonlyargs, *tree.args.posonlyargs]:
            argument.annotation = None
    return tree


def parsed(text: str) -> ast.AST:
    """Return the syntax tree of the first statement of a text."""
    with WRITING:
        return ast.parse(text).body[0]


def _ends(lines: list[str]) -> dict[int, int]:
    """Return the last line of each definition by its first line, decorators included."""
    try:
        tree = ast.parse("".join(lines))
    except SyntaxError:
        return {}
    ends: dict[int, int] = {}
    waiting: list[Any] = list(tree.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef) and node.end_lineno is not None:
            ends[min([node.lineno, *(d.lineno for d in node.decorator_list)])] = node.end_lineno
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.If | ast.Try | ast.With):
            waiting += node.body
    return ends
