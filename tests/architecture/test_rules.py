"""The rules of the house that a machine can check by reading or importing. Import contracts are in pyproject.toml."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "src" / "vfife"
FILE_STOP = 500
FUNCTION_STOP = 60
FORBIDDEN_WORDS = ("util", "utils", "manager", "managers", "helper", "helpers")
KERNELS_MAY_IMPORT = {"llvmlite", "numba", "numba_cuda", "numpy", *sys.stdlib_module_names}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def parsed() -> list[tuple[str, ast.Module, str]]:
    """Every source file as (name, tree, text)."""
    files = []
    for path in sorted(SOURCE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        files.append((path.relative_to(SOURCE.parent).as_posix(), ast.parse(text, str(path)), text))
    return files


FILES = parsed()


def report(rule: str, offenders: list[str]) -> None:
    if offenders:
        pytest.fail(f"{rule}\n  " + "\n  ".join(offenders), pytrace=False)


def test_there_is_something_to_check() -> None:
    if not (SOURCE / "__init__.py").exists():
        pytest.fail(f"{SOURCE} is not a package: it has no __init__.py", pytrace=False)


# ------------------------------------------------------------------------------------------------------------- start-up


def loaded_by(code: str) -> set[str]:
    """Top-level packages that a fresh interpreter has loaded after running the code: the last line of its output."""
    listing = "import sys; print('\\n' + ' '.join(sorted({name.partition('.')[0] for name in sys.modules})))"
    done = subprocess.run([sys.executable, "-c", f"{code}\n{listing}"], capture_output=True, text=True, timeout=120, check=False)
    if done.returncode:
        pytest.fail(f"This failed in a fresh interpreter:\n{code}\n{done.stderr}", pytrace=False)
    return set(done.stdout.splitlines()[-1].split())


HELP = """
import sys
sys.argv = ["vfife", "--help"]
from vfife.cli.app import app
try:
    app()
except SystemExit as end:
    if end.code not in (None, 0):
        raise
"""


@pytest.mark.parametrize(
    ("what", "code", "unwanted"),
    [
        ("import vfife", "import vfife", {"numba", "llvmlite", "matplotlib", "xarray", "pandas", "scipy", "plotly"}),
        ("vfife --help", HELP, {"numba", "llvmlite", "matplotlib", "xarray", "pandas", "scipy", "plotly"}),
    ],
    ids=["import", "help"],
)
def test_start_is_light(what: str, code: str, unwanted: set[str]) -> None:
    """Start-up loads nothing heavy. To see who did: `python -X importtime -c 'import vfife'`."""
    heavy = sorted(loaded_by(code) & unwanted)
    report(f"`{what}` must not load these; import them inside the function that needs them:", heavy)


# -------------------------------------------------------------------------------------------------------------- imports


def imported_modules(tree: ast.Module, package: str) -> Iterator[tuple[int, str]]:
    """(line, absolute module) of every import of a file that lies in the package, those inside functions too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ""
            if node.level:
                parents = package.split(".")
                base = ".".join(parents[: len(parents) - node.level + 1])
            module = ".".join(part for part in (base, node.module) if part)
            yield node.lineno, module
            if module == "vfife":  # `from vfife import plots` names a room, not the package
                yield from ((node.lineno, f"vfife.{alias.name}") for alias in node.names)


def test_kernels_import_only_numpy_numba_and_each_other() -> None:
    offenders = []
    for name, tree, _ in FILES:
        if not name.startswith("vfife/kernels/"):
            continue
        package = Path(name).parent.as_posix().replace("/", ".")
        for line, module in imported_modules(tree, package):
            inside = module == "vfife.kernels" or module.startswith("vfife.kernels.")
            if not inside and module.partition(".")[0] not in KERNELS_MAY_IMPORT:
                offenders.append(f"{name}:{line} imports {module}")
    report("The kernels import the standard library, numpy, numba and each other only:", offenders)


# ---------------------------------------------------------------------------------------------------------------- style


def test_no_input_is_checked_by_assert() -> None:
    offenders = [f"{name}:{node.lineno}" for name, tree, _ in FILES for node in ast.walk(tree) if isinstance(node, ast.Assert)]
    report("`assert` vanishes under -O and says nothing to a user; raise an exception with a sentence:", offenders)


def test_names_say_what_a_thing_is() -> None:
    offenders = []
    for name, tree, _ in FILES:
        if any(word in FORBIDDEN_WORDS for part in Path(name).with_suffix("").parts for word in part.split("_")):
            offenders.append(f"{name}: name the file after what it holds")
        for node in ast.walk(tree):
            if isinstance(node, Function) and node.name.lstrip("_").startswith("get_"):
                offenders.append(f"{name}:{node.lineno} {node.name}: name what it returns")
            if isinstance(node, ast.ClassDef) and re.search(r"(Manager|Helper|Utils?)$", node.name):
                offenders.append(f"{name}:{node.lineno} {node.name}: name what it is")
    report("No utils, manager, helpers and no get_:", offenders)


# ----------------------------------------------------------------------------------------------------------------- size


def table_lines(tree: ast.Module) -> int:
    """Lines of tables: module-level assignments of a literal list, tuple, dict or set."""
    lines = 0
    for node in tree.body:
        value = getattr(node, "value", None)
        if not isinstance(node, ast.Assign | ast.AnnAssign) or not isinstance(value, ast.List | ast.Tuple | ast.Dict | ast.Set):
            continue
        try:
            ast.literal_eval(value)
        except ValueError:
            continue
        lines += (node.end_lineno or node.lineno) - node.lineno + 1
    return lines


def nested_functions(node: ast.AST) -> Iterator[Function]:
    """The functions directly inside a node, not those inside them."""
    for child in ast.iter_child_nodes(node):
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
    sizes = {name: len(text.splitlines()) - table_lines(tree) for name, tree, text in FILES}
    offenders = [f"{name}: {lines} lines" for name, lines in sizes.items() if lines > FILE_STOP]
    report(f"A file stops at {FILE_STOP} lines, tables excepted; is it two rooms?", offenders)


def test_functions_stop_at_60_lines() -> None:
    offenders = []
    for name, tree, _ in FILES:
        for node in ast.walk(tree):
            if isinstance(node, Function) and own_lines(node) > FUNCTION_STOP:
                offenders.append(f"{name}:{node.lineno} {node.name}: {own_lines(node)} lines")
    report(f"A function stops at {FUNCTION_STOP} lines, its docstring and inner functions not counted:", offenders)
