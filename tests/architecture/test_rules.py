"""The rules of the house that a machine can check by reading or importing: start-up and style."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from architecture.sources import SOURCE, Function, files, report, statements

FORBIDDEN_WORDS = ("util", "utils", "manager", "managers", "helper", "helpers")


def test_there_is_something_to_check() -> None:
    if not (SOURCE / "__init__.py").exists():
        pytest.fail(f"{SOURCE} is not a package: it has no __init__.py", pytrace=False)


# --------------------------------------------------------------------------------------------------- start-up


def loaded_by(code: str) -> set[str]:
    """Top-level packages that a fresh interpreter has loaded after running the code: the last line of its
    output.
    """
    listing = "import sys; print('\\n' + ' '.join(sorted({name.partition('.')[0] for name in sys.modules})))"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{listing}"], capture_output=True, text=True, timeout=120, check=False
    )
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
        (
            "import vfife",
            "import vfife",
            {"numpy", "numba", "llvmlite", "matplotlib", "xarray", "pandas", "scipy"},
        ),
        ("vfife --help", HELP, {"numpy", "numba", "llvmlite", "matplotlib", "xarray", "pandas", "scipy"}),
    ],
    ids=["import", "help"],
)
def test_start_is_light(what: str, code: str, unwanted: set[str]) -> None:
    """Start-up loads nothing heavy. To see who did: `python -X importtime -c 'import vfife'`."""
    heavy = sorted(loaded_by(code) & unwanted)
    report(f"`{what}` must not load these; import them inside the function that needs them:", heavy)


# ------------------------------------------------------------------------------------------------------ style


def test_no_input_is_checked_by_assert() -> None:
    offenders = [
        f"{name}:{node.lineno}"
        for name, _, _ in files()
        for node in statements(name)
        if isinstance(node, ast.Assert)
    ]
    report(
        "`assert` vanishes under -O and says nothing to a user; raise an exception with a sentence:",
        offenders,
    )


def test_names_say_what_a_thing_is() -> None:
    offenders = []
    for name, _, _ in files():
        if any(
            word in FORBIDDEN_WORDS for part in Path(name).with_suffix("").parts for word in part.split("_")
        ):
            offenders.append(f"{name}: name the file after what it holds")
        for node in statements(name):
            if isinstance(node, Function) and node.name.lstrip("_").startswith("get_"):
                offenders.append(f"{name}:{node.lineno} {node.name}: name what it returns")
            if isinstance(node, ast.ClassDef) and re.search(r"(Manager|Helper|Utils?)$", node.name):
                offenders.append(f"{name}:{node.lineno} {node.name}: name what it is")
    report("No utils, manager, helpers and no get_:", offenders)


def test_what_assembles_a_mechanism_raises_errors_of_its_own() -> None:
    """A ValueError of Python's own cannot be told from a fault of ours by who catches it."""
    found = [
        f"{name}:{node.lineno}"
        for name, tree, _ in files()
        if name.startswith(("vfife/assembly/", "vfife/kinematics/"))
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and getattr(node.exc.func, "id", "") in ("ValueError", "TypeError")
    ]
    report("Raise VfifeError, or one of its kinds:", found)
