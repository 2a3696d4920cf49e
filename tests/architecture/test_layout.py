"""What lies where, and how large it is."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from architecture.sources import SOURCE, Function, files, held, report, statements

ENTRIES = 38  # of a folder that is read at a glance: packages, public namespaces, a few modules
FILE_STOP = 500
FUNCTION_STOP = 60


def test_the_listing_fits_on_a_screen() -> None:
    entries = sorted(path.name for path in SOURCE.iterdir() if path.name != "__pycache__")
    assert len(entries) <= ENTRIES, entries


def test_every_package_says_what_it_holds() -> None:
    texts = {name: ast.get_docstring(tree) or "" for name, tree, _ in files()}
    packages = sorted({name.rpartition("/")[0] for name in texts})
    report(
        "A folder without a package that says what it holds:",
        [package for package in packages if f"{package}/__init__.py" not in texts],
    )
    short = [
        f"{package}: {texts[f'{package}/__init__.py']!r}"
        for package in packages
        if len(texts[f"{package}/__init__.py"].split()) < 5
    ]
    report("The docstring of a package states in a sentence what it holds:", short)


# ------------------------------------------------------------------------------------------------------- size


def table_lines(tree: ast.Module) -> int:
    """Lines of tables: module-level assignments of a literal list, tuple, dict or set."""
    lines = 0
    for node in tree.body:
        value = getattr(node, "value", None)
        if not isinstance(node, ast.Assign | ast.AnnAssign) or not isinstance(
            value, ast.List | ast.Tuple | ast.Dict | ast.Set
        ):
            continue
        try:
            ast.literal_eval(value)
        except ValueError:
            continue
        lines += (node.end_lineno or node.lineno) - node.lineno + 1
    return lines


def nested_functions(node: ast.AST) -> Iterator[Function]:
    """The functions directly inside a node, not those inside them."""
    for child in held(node):
        if isinstance(child, Function):
            yield child
        else:
            yield from nested_functions(child)


def own_lines(function: Function) -> int:
    """Lines of a function from its `def`, without its docstring and without the functions inside it."""
    lines = (function.end_lineno or function.lineno) - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function) is not None:
        lines -= (first.end_lineno or first.lineno) - first.lineno + 1
    for inner in nested_functions(function):
        start = min([inner.lineno, *(decorator.lineno for decorator in inner.decorator_list)])
        lines -= (inner.end_lineno or inner.lineno) - start + 1
    return lines


def test_files_stop_at_500_lines() -> None:
    sizes = {name: len(text.splitlines()) - table_lines(tree) for name, tree, text in files()}
    offenders = [f"{name}: {lines} lines" for name, lines in sizes.items() if lines > FILE_STOP]
    report(f"A file stops at {FILE_STOP} lines, tables excepted; is it two concepts?", offenders)


def test_functions_stop_at_60_lines() -> None:
    offenders = []
    for name, _, _ in files():
        for node in statements(name):
            if isinstance(node, Function) and own_lines(node) > FUNCTION_STOP:
                offenders.append(f"{name}:{node.lineno} {node.name}: {own_lines(node)} lines")
    report(
        f"A function stops at {FUNCTION_STOP} lines, its docstring and inner functions not counted:",
        offenders,
    )
