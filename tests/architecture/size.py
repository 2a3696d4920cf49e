"""How large the package is: lines of code, tokens, files, import lines, long argument lists and tuples. Run
it to see the numbers.
"""

from __future__ import annotations

import ast
import io
import tokenize
from dataclasses import dataclass

from architecture.sources import SOURCE

BLANK = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)


@dataclass(frozen=True)
class Size:
    """Counts over files: ``code`` has neither blank lines nor comments nor docstrings; ``inner_imports`` are
    relative ones inside functions.
    """

    files: int = 0
    code: int = 0
    tokens: int = 0
    import_lines: int = 0
    inner_imports: int = 0
    many_arguments: int = 0
    tuples: int = 0

    def __add__(self, other: Size) -> Size:
        return Size(*(getattr(self, name) + getattr(other, name) for name in Size.__dataclass_fields__))

    @property
    def import_share(self) -> float:
        return self.import_lines / self.code


def docstring_lines(tree: ast.AST) -> set[int]:
    nodes = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    first = [node.body[0] for node in nodes if node.body and ast.get_docstring(node) is not None]
    return {line for node in first for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}


def argument_count(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Arguments of a function, without ``self`` and ``cls``."""
    places = function.args.posonlyargs + function.args.args
    own = bool(places) and places[0].arg in ("self", "cls")
    return len(places) - own + len(function.args.kwonlyargs)


def returns_tuple(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether a function declares that it returns a tuple of three or more."""
    match function.returns:
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=parts)):
            return len(parts) >= 3
    return False


def size_of(text: str) -> Size:
    """The size of one file."""
    tree = ast.parse(text)
    docstrings = docstring_lines(tree)
    tokens = [
        token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in BLANK
    ]
    tokens = [token for token in tokens if not docstrings & {token.start[0], token.end[0]}]
    lines = {line for token in tokens for line in range(token.start[0], token.end[0] + 1)}
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    inner = {
        id(node)
        for one in functions
        for node in ast.walk(one)
        if isinstance(node, ast.ImportFrom) and node.level
    }
    return Size(
        files=1,
        code=len(lines),
        tokens=len(tokens),
        import_lines=len(
            {line for node in imports for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}
        ),
        inner_imports=len(inner),
        many_arguments=sum(argument_count(one) >= 8 for one in functions),
        tuples=sum(map(returns_tuple, functions)),
    )


def sizes() -> dict[str, Size]:
    """The size of each package of vfife."""
    found: dict[str, Size] = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).parts
        name = parts[0] if len(parts) > 1 else "top level"
        found[name] = found.get(name, Size()) + size_of(path.read_text("utf-8"))
    return found


if __name__ == "__main__":
    every = sizes()
    for name, one in [
        *sorted(every.items(), key=lambda item: -item[1].code),
        ("all", sum(every.values(), Size())),
    ]:
        print(
            f"{name:12} {one.files:4} files {one.code:6} lines {one.tokens:7} tokens"
            f" {100 * one.import_share:5.1f} % imports",
            end=" ",
        )
        print(
            f"{one.inner_imports:4} inside functions {one.many_arguments:3} with 8 or more arguments"
            f" {one.tuples:3} tuples of 3 or more"
        )
