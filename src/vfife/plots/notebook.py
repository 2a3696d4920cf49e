"""Mechanisms and results for notebooks, and figures as HTML elements."""

from __future__ import annotations

import base64
import io
from html import escape

from matplotlib import rc_context
from matplotlib.figure import Figure

from ..errors import VfifeError
from ..model.mechanism import Mechanism
from ..report.check import mechanism_parts
from ..report.document import Document
from ..report.html import fragment
from ..results.run_data import RunData
from .catalogue import FIGURES, caption
from .style import STYLE, picture

LARGEST = 300_000  # bytes of a figure as lines
FINE = 150.0  # pixels an inch of one that would be larger: enough for paper
SHOWN = ("mechanism", "orbits", "forces")  # figures of a result in a notebook
# And in a report
REPORTED = ("guides", "moments", "accelerations", "polar", "stress", "deflection", "energy")


def mechanism_html(mechanism: Mechanism) -> str:
    """Return a drawing of a mechanism at the start, or its faults, and tables of its parts."""
    from . import at_start

    try:
        drawn = sharp(at_start(mechanism), f"drawing of {mechanism.name}")
    except VfifeError as error:
        drawn = f"<pre>{escape(str(error))}</pre>"
    return f"<h4>{escape(str(mechanism.name))}</h4>{drawn}{fragment(Document(mechanism_parts(mechanism)))}"


def result_html(result: RunData) -> str:
    """Return summary and figures of a result."""
    from ..report.overview import overview
    from ..report.summary import run_summary
    from . import figures

    drawn = figures(result, names=[name for name in SHOWN if not FIGURES[name].missing(result)])
    summary = getattr(result, "summary", None) or run_summary(result)  # a result keeps its own
    return fragment(overview(summary)) + "".join(picture(figure, name) for name, figure in drawn.items())


def pictures(result: RunData) -> dict[str, str]:
    """Return the figures of a report as elements of a page, by their titles: SVG, or pixels if smaller."""
    return {title: sharp(figure, title) for title, figure in reported_figures(result).items()}


def reported_figures(result: RunData) -> dict[str, Figure]:
    """Return the figures of the report of a result by their titles; the mechanism is the first."""
    from . import figures

    names = [
        name for name, kind in FIGURES.items() if name in (*SHOWN, *REPORTED) and not kind.missing(result)
    ]
    return {caption(name, result): figure for name, figure in figures(result, names=names).items()}


def svg(figure: Figure, words: str) -> bytes:
    """Return a figure as SVG; ``words`` seed the names of its parts, so that it is reproducible."""
    stream = io.BytesIO()
    with rc_context({**STYLE, "svg.hashsalt": words}):
        figure.savefig(stream, format="svg", dpi=FINE, metadata={"Date": None})
    return stream.getvalue()


def sharp(figure: Figure, words: str) -> str:
    """Return a figure as SVG, or as PNG if that is smaller."""
    lines = svg(figure, words)
    if len(lines) > LARGEST:
        return picture(figure, words, FINE)
    data = base64.b64encode(lines).decode("ascii")
    return f'<img alt="{escape(words)}" style="max-width: 100%" src="data:image/svg+xml;base64,{data}">'
