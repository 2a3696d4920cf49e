"""Answers in a notebook: each class of answers is shown as the document that the command line prints."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

from .html import fragment

DOCUMENTS = {  # module and function that make the document of a class; all other classes are maps
    "Study": ("study", "document"), "Worn": ("wear", "document"), "Fit": ("sensitivity", "identification"),
    "Comparison": ("sensitivity", "comparison"), "Optimum": ("study", "optimum"),
    "Allocation": ("study", "allocation"), "Sensitivity": ("sensitivity", "sensitivity"),
}  # fmt: skip


class NotebookDocument:
    """Base of answers that a notebook shows as documents: title, tables, cautions.

    ``former_names``: attributes by the names of version 0.2, which give a DeprecationWarning.
    """

    former_names: ClassVar[Mapping[str, str]] = {}
    name: str

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.name!r}; see .plot(), .to_dataframe()>"

    def _repr_html_(self) -> str:
        return notebook(self)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            present = type(self).former_names.get(name)
            if present is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            text = f"{type(self).__name__}.{name} is {present} now; the old name goes with the next version"
            warnings.warn(text, DeprecationWarning, stacklevel=2)
            return getattr(self, present)


def notebook(answer: Any) -> str:
    """Return the document of a study, map, wear simulation, fit, comparison or sensitivity as HTML for a
    notebook.
    """
    module, function = DOCUMENTS.get(type(answer).__name__, ("dynamics", "document"))
    return fragment(getattr(import_module(f".{module}", __package__), function)(answer))
