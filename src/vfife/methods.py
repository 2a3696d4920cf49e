"""Methods of mechanisms and results that need packages above their classes, such as ``mechanism.plot()``.

``model`` and ``results`` import neither figures, pages nor reports. ``vfife`` attaches these functions to the
classes as soon as one of its public names has loaded them; each imports its package when it is called.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from .live.page.page import Live
    from .model.mechanism import Mechanism
    from .report.check import Checked
    from .results.derivatives import Sensitivity
    from .results.fit import Fit
    from .results.study import Study
    from .simulation.result import Result
    from .studies.methods.compare import Comparison


def to_toml(self: Mechanism) -> str:
    """Return the text of a model file of this mechanism, in SI units. Raises ValueError or TypeError if no
    model file can contain it.
    """
    from .modelfile import dump

    return dump(self)


def check(self: Mechanism) -> Checked:
    """Check the mechanism without a run: close it at its start, and follow its ideal motion over the range of
    the drivers.

    Returns the degrees of freedom, the step and cautions; printed, they are a few sentences. Raises
    ModelError with all faults, AssemblyError if no position satisfies the joints or the mechanism locks.
    """
    from .model.validation import validate
    from .report.check import checked
    from .simulation.start import examination

    validate(self)
    facts = examination(self)
    return checked(facts.assembly, facts.outlook.cautions)


def plot(self: Mechanism) -> Figure:
    """Return a figure of the mechanism at its start, with the names of its bodies and joints; where the start
    hides a body, as the rod hides the crank at a dead centre, in another position of the turn. Raises as
    :meth:`check` does.
    """
    from .plots import at_start

    return at_start(self)


def live(self: Mechanism, slide: Iterable[str] | None = None) -> Live:
    """Return a page that runs the mechanism, as the last expression of a notebook cell and in pages exported
    from the notebook.

    ``slide``: numbers with ranges that become sliders, as in ["joint.C.clearance=0.01..0.5mm"]; None for all
    clearances, driver speeds, friction and restitution, whose positions take some seconds to assemble; () for
    none. Its ``save(path)`` writes the page. Raises as :meth:`check`, VfifeError for a mechanism without
    motion, and ValueError for an invalid slider.
    """
    from .live.page.page import live

    return live(self, slide)


def mechanism_html(self: Mechanism) -> str:
    """Return the drawing and the tables of parts for a notebook."""
    from .plots.notebook import mechanism_html

    return mechanism_html(self)


def live_result(self: Result, slide: Iterable[str] | None = ()) -> Live:
    """Return a page that runs the mechanism with the step of the run, or shows the equilibria of a static
    analysis.

    ``slide`` as in :meth:`Mechanism.live <vfife.Mechanism.live>`, none by default. Raises VfifeError for a
    mechanism without motion.
    """
    from .live.page.page import live_result

    return live_result(self, slide)


def report(
    self: Result, path: str | Path, running: bool = True, author: str = "", logo: str | Path | None = None
) -> tuple[str, ...]:
    """Write a report for screen and paper: inputs, findings, cautions, reliability and figures.

    path: the file, ``.html`` or ``.pdf``; an existing one is replaced when the new one is complete
    running: whether the mechanism runs in an HTML page
    author: name on the first page
    logo: PNG or JPEG file for the first page

    Returns sentences on what the report lacks. Raises VfifeError for another extension or logo, OSError.
    """
    from .live.page.reports import report

    return report(self, path, running, author, logo)


def plot_study(self: Study, *names: str, measures: Sequence[str] = ()) -> dict[str, Figure]:
    """Return figures by name: ``maps``, ``curves``, ``parallel``, ``fronts``, or only those of ``names`` and
    ``measures``.

    Raises VfifeError for an unknown name.
    """
    from .plots.study import figures

    return figures(self, names, measures)


def plot_comparison(self: Comparison) -> dict[str, Figure]:
    """Return the figures ``forces``, of the joint forces over a turn, and ``bars``, of the largest values of
    each law; none where no run is complete.
    """
    from .plots.sensitivity import comparison_figures

    return comparison_figures(self)


def plot_fit(self: Fit) -> Figure:
    """Return a figure of measured and simulated curves, residuals, and the correlation of the parameters."""
    from .plots.sensitivity import fit_figure

    return fit_figure(self)


def plot_sensitivity(self: Sensitivity) -> Figure:
    """Return a figure of the elasticities, the largest first."""
    from .plots.sensitivity import tornado

    return tornado(self)


def plot_transformed(self: Any) -> Figure:
    """Return a figure of a spectrum, spectrogram or envelope."""
    from .plots.spectra import figure_of

    return figure_of(self)


def notebook(self: Any) -> str:
    """Return the document of the answer for a notebook: title, tables and cautions."""
    from .report.html import notebook

    return notebook(self)


def text(self: Any) -> str:
    """Return the document of the answer as text, for print()."""
    from .report.html import text

    return text(self)


METHODS: dict[str, dict[str, Callable[..., Any]]] = {  # by class, which may not be loaded yet
    "model.mechanism.Mechanism": {
        "to_toml": to_toml,
        "check": check,
        "plot": plot,
        "live": live,
        "_repr_html_": mechanism_html,
    },
    "results.spectra.Spectrum": {"plot": plot_transformed, "_repr_html_": notebook, "__str__": text},
    "results.spectra.Spectrogram": {"plot": plot_transformed, "_repr_html_": notebook, "__str__": text},
    "results.spectra.Envelope": {"plot": plot_transformed, "_repr_html_": notebook, "__str__": text},
    "simulation.result.Result": {"live": live_result, "report": report},
    "results.study.Study": {"plot": plot_study, "_repr_html_": notebook, "__str__": text},
    "results.fit.Fit": {"plot": plot_fit, "_repr_html_": notebook, "__str__": text},
    "studies.methods.compare.Comparison": {"plot": plot_comparison, "_repr_html_": notebook, "__str__": text},
    "results.derivatives.Sensitivity": {"plot": plot_sensitivity, "_repr_html_": notebook, "__str__": text},
}


def attach() -> None:
    """Attach the methods to the classes that are loaded."""
    for place, methods in METHODS.items():
        module, _, name = place.rpartition(".")
        owner = getattr(sys.modules.get(f"vfife.{module}"), name, None)
        if owner is not None:
            for method, function in methods.items():
                setattr(owner, method, function)
