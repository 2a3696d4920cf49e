"""The package as files: what the rules of the house are read from."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "vfife"
VALIDATION = ROOT / "src" / "vfife_validation"
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

Function = ast.FunctionDef | ast.AsyncFunctionDef


def parsed(folder: Path) -> list[tuple[str, ast.Module, str]]:
    """Every Python file in a folder as (name, tree, text)."""
    files = []
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        files.append((path.relative_to(folder.parent).as_posix(), ast.parse(text, str(path)), text))
    return files


@cache
def files() -> list[tuple[str, ast.Module, str]]:
    """Those of both packages, read once by the process that needs them."""
    return [*parsed(SOURCE), *parsed(VALIDATION)]


@cache
def modules() -> frozenset[str]:
    """Names of all modules of both packages; a package goes by its own name."""
    names = (name.removesuffix(".py").removesuffix("/__init__") for name, _, _ in files())
    return frozenset(name.replace("/", ".") for name in names)


@cache
def statements(name: str) -> list[ast.stmt]:
    """Every statement of a file of the package, those inside others too: functions, classes and imports are
    nothing else.
    """
    return list(inside(next(tree for other, tree, _ in files() if other == name)))


def inside(node: ast.AST) -> Iterator[ast.stmt]:
    """Every statement inside a node, however deep."""
    for child in held(node):
        if isinstance(child, ast.stmt):
            yield child
        yield from inside(child)


def held(node: ast.AST) -> Iterator[ast.AST]:
    """What a node holds that is a statement or may hold one."""
    for part in ("body", "handlers", "orelse", "finalbody", "cases"):
        found = getattr(node, part, ())
        yield from found if isinstance(found, list) else ()


def report(rule: str, offenders: list[str]) -> None:
    """Fails with the rule and who breaks it."""
    if offenders:
        pytest.fail(f"{rule}\n  " + "\n  ".join(offenders), pytrace=False)


class Import(NamedTuple):
    """One module that a file imports: where, its absolute name, whether inside a function, whether for type
    checkers alone.
    """

    line: int
    module: str
    inside: bool
    for_types: bool


def imports(name: str, tree: ast.Module) -> Iterator[Import]:
    """Every import of a file, those inside functions too."""
    yield from _imports(tree, Path(name).parent.as_posix().replace("/", "."), inside=False, for_types=False)


def _imports(node: ast.AST, package: str, *, inside: bool, for_types: bool) -> Iterator[Import]:
    for child in held(node):
        if isinstance(child, ast.Import):
            yield from (Import(child.lineno, alias.name, inside, for_types) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            module = _absolute(child, package)
            names = [f"{module}.{alias.name}" for alias in child.names]
            # `from . import forces` names a module, `from .forces import peak` a thing in one.
            inner = [one for one in names if one in modules()]
            if len(inner) < len(names):
                inner.insert(0, module)
            yield from (Import(child.lineno, one, inside, for_types) for one in inner)
        else:
            checked = isinstance(child, ast.If) and ast.unparse(child.test) in (
                "TYPE_CHECKING",
                "typing.TYPE_CHECKING",
            )
            within = inside or isinstance(child, Function)
            yield from _imports(child, package, inside=within, for_types=for_types or checked)


def _absolute(statement: ast.ImportFrom, package: str) -> str:
    base = ""
    if statement.level:
        parents = package.split(".")
        base = ".".join(parents[: len(parents) - statement.level + 1])
    return ".".join(part for part in (base, statement.module) if part)
