"""The page: its skeleton, style and scripts put together with what it is given, in one file that asks for nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import lru_cache
from html import escape
from pathlib import Path

from ..codegen import javascript
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from ..model.mechanism import Mechanism
from ..result import Result
from ..simulation import simulate
from .equilibria import told_of
from .given import Json, given, left
from .patches import Patched, patched
from .sliders import Slide
from .together import Together

BROWSER = Path(__file__).with_name("browser")
WORKER = ("stepper.js",)
SCRIPTS = (
    "pieces.js", "numbers.js", "store.js", "running.js", "path.js", "theme.js", "svg.js", "pen.js", "pose.js", "scene.js", "axes.js", "charts.js",
    "orbits.js", "tables.js", "sliders.js", "downloads.js", "main.js", "looks.js",
)  # fmt: skip
LARGEST = 2_000_000  # bytes


def live_page(mechanism: Mechanism, slides: Iterable[Slide] = (), step: float | None = None) -> str:
    """A page in which a mechanism runs, as one HTML text without any reference to elsewhere.

    The step that it runs is the traced one as JavaScript, with the bits of :func:`~vfife.simulation.simulate` without companions. ``slides`` become
    sliders (:func:`~vfife.live.sliders.default_slides` for the usual ones); ``step`` (s) is that of a run, or None for the automatic one. A static
    analysis is carried out, and the page holds its equilibria. Raises VfifeError for a mechanism that cannot run in a page, ModelError and
    AssemblyError for one that cannot run at all.
    """
    if mechanism.settings.analysis == "static" and not (slides := list(slides)):
        return still(simulate(mechanism, reference=False))
    return written(patched(mechanism, list(slides), step))


def result_page(result: Result) -> str:
    """The page of a result: its mechanism running with its step, without sliders; of a static analysis its equilibria. Raises VfifeError."""
    assembly = result.record.assembly
    return still(result) if result.record.static else live_page(assembly.mechanism, step=assembly.choice.step)


def still(result: Result) -> str:
    """The page of the equilibria of a static analysis. Raises VfifeError where there are none but the start."""
    return put_together(told_of(result) | {"worker": '"use strict";\n' + (BROWSER / "still.js").read_text("utf-8")})


def written(found: Patched) -> str:
    """The page of a mechanism with its sliders."""
    return put_together(given(found.base) | found.json() | {"worker": worker(found.base)})


def put_together(told: Json) -> str:
    """The page of what is told, as one text."""
    text = json.dumps(told, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    safe = text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    parts = {
        "title": escape(told["name"]), "style": (BROWSER / "page.css").read_text("utf-8"), "given": safe,
        "script": "\n".join((BROWSER / name).read_text("utf-8") for name in SCRIPTS),
    }  # fmt: skip
    page = (BROWSER / "page.html").read_text("utf-8")
    for name, part in parts.items():
        page = page.replace(f"<!-- {name} -->", part, 1)
    return page


@lru_cache(maxsize=16)
def step_of(topology: Topology) -> str:
    """The text of a step, kept for the next model that differs in numbers alone."""
    return javascript.written(topology, left(Layout(topology)))


def worker(found: Together) -> str:
    """What the worker runs: the step of the mechanism, that of its ideal reference, and what drives them."""
    texts = [step_of(one.topology) for one in (found.own, found.ideal) if one is not None]
    steps = ",\n".join(f"(() => {{\n{text}\nreturn advance;\n}})()" for text in texts)
    return f'"use strict";\nconst steps = [{steps}];\n' + "\n".join((BROWSER / name).read_text("utf-8") for name in WORKER)
