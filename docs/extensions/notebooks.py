"""Notebooks of ``examples/notebooks``: their execution as Jupyter does it, and their pages."""

from __future__ import annotations

import ast
import json
import linecache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = ROOT / "examples" / "notebooks"
FOLDER = "notebooks"  # of the pages
LARGEST = 3_000_000  # characters that a cell displays
REPRESENTATIONS = ("_repr_html_", "_repr_png_", "_repr_svg_")


def cells(path: Path) -> list[tuple[str, str]]:
    """Return the kind and the source of each cell."""
    found = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def run_cell(source: str, names: dict[str, Any], file: str) -> Any:
    """Execute a cell; return the value of the expression at its end, or None."""
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    for statement in tree.body:  # one by one, as ipykernel does
        exec(compile(ast.Module([statement], []), file, "exec", dont_inherit=True), names)
    if not isinstance(last, ast.Expr):
        return None
    return eval(compile(ast.Expression(last.value), file, "eval", dont_inherit=True), names)


def representation(value: Any) -> str | bytes:
    """Return what a notebook displays of a value, in the richest form that it has, else its repr. ValueError
    if that tells a reader nothing, or is too large for a page.
    """
    for name in REPRESENTATIONS:
        method = getattr(value, name, None)
        shown = method() if method is not None else None
        if shown:
            break
    else:
        shown = repr(value)
    if isinstance(shown, str) and (" object at 0x" in shown or len(shown) >= LARGEST):
        raise ValueError(
            f"a notebook displays {shown[:60]}, {len(shown):,} characters; at most {LARGEST:,} fit a page,"
            " and an object needs a representation of its own"
        )
    return shown


def page(path: Path) -> str:
    """Return the page of a notebook, in Markdown, whose cells are executed when it is read."""
    parts = [
        source if kind == "markdown" else f"````{{notebook-cell}}\n{source}\n````"
        for kind, source in cells(path)
    ]
    parts.insert(1, f"Open it in Jupyter: {{download}}`{path.name} <../../examples/notebooks/{path.name}>`.")
    return "\n\n".join(parts) + "\n"


def write_pages(app: Any) -> None:
    """Write the page of each notebook where it differs."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        target = folder / f"{path.stem}.md"
        if not target.exists() or target.read_text(encoding="utf-8") != page(path):
            target.write_text(page(path), encoding="utf-8")


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
