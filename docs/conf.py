"""Sphinx configuration. What pages show is made while they are built, by docs/extensions, and nothing is
asked for from elsewhere.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from sphinx.util.parallel import make_chunks

HERE = Path(__file__).parent
ROOT = HERE.parent
os.environ.setdefault("MPLBACKEND", "Agg")
sys.path[:0] = [str(ROOT / "src"), str(HERE / "extensions"), str(ROOT / "benchmarks")]

project = "vfife"
author = "The vfife authors"
copyright = "The vfife authors"
PACKAGE = (ROOT / "src/vfife/__init__.py").read_text(encoding="utf-8")
release = version = re.findall(r'__version__ = "(.+)"', PACKAGE)[0]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_gallery.gen_gallery",
    "command_reference",
    "commands",
    "equations",
    "law_gallery",
    "links",
    "making",
    "mechanisms",
    "model_reference",
    "notebooks",
    "public_api",
]
exclude_patterns = [
    "_build",
    "_made",
    "extensions",
    "examples/**/*.ipynb",
    "examples/sg_execution_times.rst",
    "sg_execution_times.rst",
]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"vfife {release}"
html_static_path = ["_static"]
html_css_files = ["vfife.css"]
html_extra_path = ["_made/extra"]  # live pages
html_math_renderer = "mathml"
html_show_sourcelink = False

sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["examples"],
    "filename_pattern": r"\.py$",  # every script runs, whatever its name
    "ignore_pattern": r"__init__\.py",
    "capture_repr": (),
    "abort_on_example_error": False,  # all failures are shown, and any fails the build
    "download_all_examples": False,
    "image_scrapers": ("drawn_figures",),
    "min_reported_time": 1,
    "plot_gallery": True,
    "show_signature": False,
    "reference_url": {"vfife": None},  # names in scripts lead to their place in the API
}

autodoc_member_order = "bysource"
autodoc_typehints = "signature"


def fill_verification_page(app, docname, source) -> None:
    """Run the verification suite and put its numbers into verification.md before it is read."""
    if docname == "verification":
        from vfife_validation.verification import CASES
        from vfife_validation.verification.page import tables

        source[0] = source[0].replace("@CASES@", tables(CASES.values()))


def fill_benchmarks_page(app, docname, source) -> None:
    """Put the numbers of benchmarks/latest.json into benchmarks.md before it is read, and whether they are
    those of the step as it is.
    """
    if docname == "benchmarks":
        from measure import step_text
        from page import tables

        for mark, text in tables(step_text()).items():
            source[0] = source[0].replace(mark, text)


# Pages by the processor time that they take, longest first; the others take less than ten seconds.
LONGEST = ("published", "verification", "zero", "trends", "measured", "notebooks/2_which_clearance")


def deal_pages(app, env, docnames) -> None:
    """Pages are read in batches, the first of which begin at once. The longest pages begin them: the longest
    one takes about as long as all the others.
    """
    ranked = [name for name in LONGEST if name in docnames]
    ranked += [name for name in docnames if name not in LONGEST]
    size = len(make_chunks(docnames, app.parallel)[0]) if docnames else 1
    places = sorted(range(len(docnames)), key=lambda place: place % size)
    for place, name in zip(places, ranked, strict=True):
        docnames[place] = name


def setup(app) -> None:
    app.connect("env-before-read-docs", deal_pages)
    app.connect("source-read", fill_verification_page)
    app.connect("source-read", fill_benchmarks_page)


# Rooms may use the same short word (a Table of a model file and one of a page); annotations name both by it
# alone.
suppress_warnings = ["ref.python"]
