"""How large the package is: lines of code, tokens, files, import lines, long argument lists and tuples. Run
it to see the numbers.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from itertools import chain

from architecture.sources import Function, files, inside

# A text, a number or name, an operator; a comment and the end of a line are matched to be passed over. An
# f-string is one token, as before Python 3.12.
TOKEN = re.compile(
    r"""(?x: [rbufRBUF]{0,2} (?: \"\"\" (?:\\[\s\S]|[^\\])*? \"\"\" | \'\'\' (?:\\[\s\S]|[^\\])*? \'\'\'
         | " (?:\\[\s\S]|[^"\\\n])* " | ' (?:\\[\s\S]|[^'\\\n])* ' )
       | (?:\d[\d_]*\.?|\.\d) (?:[eE][+-]\d|[\w.])* | \w+ | \#.* | \n
       | \.\.\. | (?:\*\*|//|>>|<<)=? | [-+*/%@&|^=<>!:]= | -> | [^\s\\] )"""
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


def docstring_lines(statements: list[ast.stmt], tree: ast.Module) -> set[int]:
    """Lines of the docstrings of a file and of its classes and functions."""
    nodes = [tree, *(node for node in statements if isinstance(node, ast.ClassDef | Function))]
    first = [node.body[0] for node in nodes if node.body and ast.get_docstring(node, clean=False) is not None]
    return set(chain.from_iterable(map(lines_of, first)))


def lines_of(node: ast.stmt) -> range:
    """Lines of a statement, from 1."""
    return range(node.lineno, (node.end_lineno or node.lineno) + 1)


def tokens(text: str) -> list[tuple[int, int]]:
    """First and last line of each token of a file, without comments and ends of lines."""
    found, line = [], 1
    for token in TOKEN.findall(text):
        first, line = line, line + token.count("\n")
        if token[0] not in "#\n":
            found.append((first, line))
    return found


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


def size_of(tree: ast.Module, text: str) -> Size:
    """The size of one file."""
    statements = list(inside(tree))
    docstrings = docstring_lines(statements, tree)
    code = [(first, last) for first, last in tokens(text) if not docstrings & {first, last}]
    imports = [node for node in statements if isinstance(node, ast.Import | ast.ImportFrom)]
    functions = [node for node in statements if isinstance(node, Function)]
    inner = {
        id(node)
        for one in functions
        for node in inside(one)
        if isinstance(node, ast.ImportFrom) and node.level
    }
    return Size(
        files=1,
        code=len({line for first, last in code for line in range(first, last + 1)}),
        tokens=len(code),
        import_lines=len(set(chain.from_iterable(map(lines_of, imports)))),
        inner_imports=len(inner),
        many_arguments=sum(argument_count(one) >= 8 for one in functions),
        tuples=sum(map(returns_tuple, functions)),
    )


def sizes() -> dict[str, Size]:
    """The size of each package of vfife."""
    found: dict[str, Size] = {}
    for name, tree, text in files():
        package, *parts = name.split("/")
        if package == "vfife":
            room = parts[0] if len(parts) > 1 else "top level"
            found[room] = found.get(room, Size()) + size_of(tree, text)
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
