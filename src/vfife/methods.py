"""Methods of mechanisms and results whose answers packages above those classes give, such as
``mechanism.plot()``.

``model`` and ``results`` import neither figures, pages nor reports. ``vfife`` attaches these functions to the
classes as soon as one of its public names has loaded them, and each loads its package when it is called.
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
    from .results.fit import Fit
    from .results.study import Study
    from .simulation.result import Result


def to_toml(self: Mechanism) -> str:
    """Return the text of a model file that holds it, in SI units. Raises ValueError or TypeError where no
    model file can.
    """
    from .modelfile import dump

    return dump(self)


def check(self: Mechanism) -> Checked:
    """Examine the mechanism, close it at its start, and follow its ideal motion through what the drivers ask
    for; nothing is run.

    Raises ModelError with every fault, AssemblyError where no position satisfies its joints, or it jams. The
    answer has its degrees of freedom, its step and cautions; printed, it is a few sentences.
    """
    from .studies.methods.check import checked

    return checked(self)


def plot(self: Mechanism) -> Figure:
    """Return a figure of the mechanism at its start, with the names of its bodies and joints. Raises as
    :meth:`check` does.
    """
    from .plots import at_start

    return at_start(self)


def live(self: Mechanism, slide: Iterable[str] | None = None) -> Live:
    """Return a page in which the mechanism runs: as the last line of a notebook's cell it runs there, and in
    pages exported from it.

    ``slide``: numbers that become sliders, with their ranges, as in ["joint.C.clearance=0.01..0.5mm"]; None
    for every clearance, the speed of drivers, friction and restitution, whose positions take some seconds to
    assemble; () for none. Its ``save(path)`` writes the page. Raises as :meth:`check` does, VfifeError for
    what has no motion to run, and ValueError for a slide that cannot be used.
    """
    from .live.page.page import live

    return live(self, slide)


def mechanism_html(self: Mechanism) -> str:
    """Return what a notebook shows: its drawing, and tables of its parts."""
    from .plots.notebook import mechanism_html

    return mechanism_html(self)


def live_result(self: Result, slide: Iterable[str] | None = ()) -> Live:
    """Return a page in which the mechanism runs with the step of the run, or of its equilibria.

    ``slide`` as of :meth:`Mechanism.live <vfife.Mechanism.live>`, none by default. Raises VfifeError for what
    has no motion.
    """
    from .live.page.page import live_result

    return live_result(self, slide)


def report(self: Result, path: str | Path, running: bool = True) -> None:
    """Write a page that prints well: inputs, what was found, cautions, how far it can be trusted, figures,
    and the mechanism ``running``.

    A file that is there gives way when the page is whole. Raises OSError where it cannot be written.
    """
    from .live.page.reports import report

    report(self, path, running)


def plot_study(self: Study, *names: str, measures: Sequence[str] = ()) -> dict[str, Figure]:
    """Return figures by name: ``maps``, ``curves``, ``parallel``, ``fronts``; those of ``names`` and
    ``measures`` where some are named.

    Raises VfifeError for a name that nothing has.
    """
    from .plots.study import figures

    return figures(self, names, measures)


def plot_fit(self: Fit) -> Figure:
    """Return a figure of measured curves with the model's, the residuals of each, and the correlation of the
    parameters.
    """
    from .plots.sensitivity import fit_figure

    return fit_figure(self)


def notebook(self: Any) -> str:
    """Return what a notebook shows: its document with title, tables and cautions."""
    from .report.notebook import notebook

    return notebook(self)


METHODS: dict[str, dict[str, Callable[..., Any]]] = {  # by class, which may not be loaded yet
    "model.mechanism.Mechanism": {
        "to_toml": to_toml,
        "check": check,
        "plot": plot,
        "live": live,
        "_repr_html_": mechanism_html,
    },
    "simulation.result.Result": {"live": live_result, "report": report},
    "results.study.Study": {"plot": plot_study, "_repr_html_": notebook},
    "results.fit.Fit": {"plot": plot_fit, "_repr_html_": notebook},
    "results.comparison.Comparison": {"_repr_html_": notebook},
    "results.derivatives.Sensitivity": {"_repr_html_": notebook},
}


def attach() -> None:
    """Give the classes that are loaded their methods."""
    for place, methods in METHODS.items():
        module, _, name = place.rpartition(".")
        owner = getattr(sys.modules.get(f"vfife.{module}"), name, None)
        if owner is not None:
            for method, function in methods.items():
                setattr(owner, method, function)
