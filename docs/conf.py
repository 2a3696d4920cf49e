"""Sphinx configuration. The gallery runs every script of examples/; the API page lists the modules that are there."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
SOURCE = ROOT / "src" / "vfife"
os.environ.setdefault("MPLBACKEND", "Agg")
sys.path[:0] = [str(ROOT / "src"), str(HERE), str(ROOT / "benchmarks")]

project = "vfife"
author = "The vfife authors"
copyright = "The vfife authors"
release = version = re.findall(r'__version__ = "(.+)"', (ROOT / "src/vfife/__init__.py").read_text(encoding="utf-8"))[0]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "examples/**/*.ipynb", "sg_execution_times.rst"]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"vfife {release}"
html_static_path = ["_static"]
html_css_files = ["vfife.css"]

sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["examples"],
    "filename_pattern": r"\.py$",  # every script runs, whatever its name
    "ignore_pattern": r"__init__\.py",
    "abort_on_example_error": False,  # all failures are shown, and any fails the build
    "download_all_examples": False,
    "image_scrapers": ("drawn_figures",),
    "min_reported_time": 1,
    "plot_gallery": True,
    "show_signature": False,
}

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autosummary_generate = False  # write_module_pages does


def module_names() -> list[str]:
    """Modules worth a page: the package without its private parts, its kernels (see Design) and its command line."""
    names = []
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE.parent).with_suffix("").parts
        if parts[-1] == "__init__":
            parts = parts[:-1]
        private = any(part.startswith("_") for part in parts)
        if len(parts) > 1 and not private and parts[1] not in ("kernels", "cli"):
            names.append(".".join(parts))
    return names


def public_names() -> list[str]:
    """What `from vfife import` offers."""
    import vfife

    return sorted(vfife.__all__)


def write_module_pages(app) -> None:
    """One page for each module, in the folder api/, which is laid anew for each build."""
    folder = HERE / "api"
    folder.mkdir(exist_ok=True)
    pages = {folder / f"{name}.rst": name for name in module_names()}
    for stale in set(folder.glob("*.rst")) - set(pages):
        stale.unlink()
    for path, name in pages.items():
        text = f"{name}\n{'=' * len(name)}\n\n.. automodule:: {name}\n   :members:\n   :ignore-module-all:\n   :show-inheritance:\n"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def fill_api_page(app, docname, source) -> None:
    """Put the names found into api.md before it is read."""
    if docname == "api":
        source[0] = source[0].replace("@PUBLIC@", "\n".join(f"   ~vfife.{name}" for name in public_names()))
        source[0] = source[0].replace("@MODULES@", "\n".join(f"   {name}" for name in module_names()))


def fill_verification_page(app, docname, source) -> None:
    """Run the verification suite and put its numbers into verification.md before it is read."""
    if docname == "verification":
        from vfife.verification import CASES
        from vfife.verification.page import tables

        source[0] = source[0].replace("@CASES@", tables(CASES.values()))


def fill_benchmarks_page(app, docname, source) -> None:
    """Put the numbers of benchmarks/latest.json into benchmarks.md before it is read, and whether they are those of the step as it is."""
    if docname == "benchmarks":
        from measure import step_text
        from page import tables

        for mark, text in tables(step_text()).items():
            source[0] = source[0].replace(mark, text)


def keep_docstring_layout(app, what, name, obj, options, lines) -> None:
    """Show a docstring as plain text, whose layout carries meaning: the summary, then the rest as it stands."""
    text = [line.rstrip() for line in lines]
    while text and not text[-1]:
        text.pop()
    end = text.index("") if "" in text else len(text)
    summary, rest = text[:end], text[end:]
    parts = re.split(r"(``[^`]+``)", " ".join(line.strip() for line in summary))
    escaped = "".join(part if part.startswith("``") else re.sub(r"([\\`*_|])", r"\\\1", part) for part in parts)
    lines[:] = [escaped, ""]
    if any(rest):
        lines += [".. code-block:: text", "", *(f"   {line}" if line else "" for line in rest), ""]


def setup(app) -> None:
    app.connect("builder-inited", write_module_pages)
    app.connect("source-read", fill_api_page)
    app.connect("source-read", fill_verification_page)
    app.connect("source-read", fill_benchmarks_page)
    app.connect("autodoc-process-docstring", keep_docstring_layout)

# Rooms may use the same short word (a Table of a model file and one of a page); annotations name both by it alone.
suppress_warnings = ["ref.python"]
