"""The page of a mechanism: skeleton, style, scripts and data in one HTML file that loads nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import lru_cache
from html import escape
from pathlib import Path

from ...compiler.backends import javascript
from ...files import write_text
from ...kernels.arrays import Layout
from ...kernels.topology import Topology
from ...laws.stored import refuse_recorded
from ...model.mechanism import Mechanism
from ...simulation.result import Result
from ...simulation.simulate import simulate
from .page_model import PageModel
from .patches import SliderPatches, slider_patches
from .payload import Json, payload, scratch_rows, static_payload
from .sliders import Slide, default_slides, parse_slides

BROWSER = Path(__file__).parents[1] / "browser"
WORKER = ("stepper.js",)
SCRIPTS = (
    "pieces.js", "numbers.js", "store.js", "running.js", "path.js", "theme.js", "svg.js", "pen.js", "pose.js",
    "scene.js", "axes.js", "charts.js",
    "orbits.js", "tables.js", "sliders.js", "downloads.js", "main.js", "view.js",
)  # fmt: skip
STYLES = ("theme.css", "page.css")
LARGEST = 2_000_000  # bytes
HEIGHT = 720  # pixels of a cell


class Live:
    """A page that runs a mechanism: displayed by a notebook, written by :meth:`save`. ``page`` is its HTML
    text.
    """

    def __init__(self, page: str, name: str) -> None:
        self.page, self.name = page, name

    def __repr__(self) -> str:
        return (
            f"{self.name}, running, in {len(self.page.encode('utf-8')):,} bytes: the last line of a"
            " notebook's cell shows it, save(path) keeps it"
        )

    def _repr_html_(self) -> str:
        """Return the page for a notebook, in a frame that cannot access the notebook."""
        words = f"{self.name}, running"
        look = f"width: 100%; height: {HEIGHT}px; border: 1px solid #8884; border-radius: 6px"
        inside = f'sandbox="allow-scripts allow-downloads" srcdoc="{escape(self.page)}"'
        return f'<iframe title="{escape(words)}" style="{look}" {inside}></iframe>'

    def save(self, path: str | Path) -> None:
        """Write the page. An existing file is replaced when the new one is complete. Raises OSError."""
        write_text(Path(path), self.page)


def live(mechanism: Mechanism, slide: Iterable[str] | None = None, step: float | None = None) -> Live:
    """Return a page that runs a mechanism.

    ``slide``: ranges of sliders, as in "joint.C.clearance=0.01..0.5mm"; None for the default sliders.
    ``step`` (s): that of a run; None for the automatic one. Raises VfifeError if the mechanism cannot run in
    a page, ModelError and AssemblyError if it cannot run at all, ValueError for an invalid slider.
    """
    if mechanism.settings.analysis == "static" and not slide:
        slides = []
    elif slide is None:
        slides = default_slides(mechanism)
    else:
        slides = parse_slides(mechanism, [slide] if isinstance(slide, str) else slide)
    return Live(live_page(mechanism, slides, step), str(mechanism.name))


def live_result(result: Result, slide: Iterable[str] | None = ()) -> Live:
    """Return a page that runs the mechanism of a result with its step; of a static analysis, one with its
    equilibria. Raises as :func:`live`.
    """
    assembly = result.record.assembly
    if result.record.static and not slide:
        return Live(result_page(result), str(assembly.mechanism.name))
    return live(assembly.mechanism, slide, assembly.choice.step)


def live_page(mechanism: Mechanism, slides: Iterable[Slide] = (), step: float | None = None) -> str:
    """Return a page that runs a mechanism, as HTML text without external references.

    The page runs the traced step as JavaScript, with the bits of :func:`~vfife.simulation.simulate.simulate`
    without companions. ``slides`` become sliders (see :func:`~vfife.live.page.sliders.default_slides`);
    ``step`` (s) is that of a run, None the automatic one. For a static analysis the equilibria are computed
    here. Raises VfifeError if the mechanism cannot run in a page, ModelError and AssemblyError if it cannot
    run at all.
    """
    if mechanism.settings.analysis == "static" and not (slides := list(slides)):
        return static_page(simulate(mechanism, reference=False))
    return page_with_sliders(slider_patches(mechanism, list(slides), step))


def result_page(result: Result) -> str:
    """Return the page of a result without sliders: its mechanism with its step, or the equilibria of a static
    analysis. Raises VfifeError.
    """
    assembly = result.record.assembly
    return (
        static_page(result)
        if result.record.static
        else live_page(assembly.mechanism, step=assembly.choice.step)
    )


def static_page(result: Result) -> str:
    """Return the page of the equilibria of a static analysis. Raises VfifeError if only the start was
    computed.
    """
    return page_text(
        static_payload(result) | {"worker": '"use strict";\n' + (BROWSER / "still.js").read_text("utf-8")}
    )


def page_with_sliders(patches: SliderPatches) -> str:
    """Return the page of a mechanism with sliders. Raises LawError for laws known from a run file only."""
    topology = patches.base.assembly.topology
    refuse_recorded([*topology.contact_laws, *topology.friction_laws])
    return page_text(payload(patches.base) | patches.json() | {"worker": worker(patches.base)})


def page_text(data: Json) -> str:
    """Return the page with its data."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    safe = text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    parts = {
        "title": escape(data["name"]), "given": safe,
        "style": "".join((BROWSER / name).read_text("utf-8") for name in STYLES),
        "script": "\n".join((BROWSER / name).read_text("utf-8") for name in SCRIPTS),
    }  # fmt: skip
    page = (BROWSER / "page.html").read_text("utf-8")
    for name, part in parts.items():
        page = page.replace(f"<!-- {name} -->", part, 1)
    return page


@lru_cache(maxsize=16)
def step_of(topology: Topology) -> str:
    """Return the JavaScript text of a step; cached, because models that differ in numbers only share it."""
    return javascript.module(topology, scratch_rows(Layout(topology)))


def worker(model: PageModel) -> str:
    """Return the script of the worker: the step of the mechanism, that of its ideal reference, and their
    driver.
    """
    texts = [step_of(assembly.topology) for assembly in (model.assembly, model.ideal) if assembly is not None]
    steps = ",\n".join(f"(() => {{\n{text}\nreturn advance;\n}})()" for text in texts)
    return f'"use strict";\nconst steps = [{steps}];\n' + "\n".join(
        (BROWSER / name).read_text("utf-8") for name in WORKER
    )
