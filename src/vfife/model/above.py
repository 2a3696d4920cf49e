"""Methods whose answers layers above give, such as ``mechanism.plot()``: the layer is loaded when the method
is called.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def upper(module: str, function: str, *given: Any) -> Any:
    """Call a function of a module of this package, which is imported then."""
    return getattr(import_module(f"vfife.{module}"), function)(*given)


class NotebookDocument:
    """A result that a notebook shows as its document: title, tables, cautions."""

    def _repr_html_(self) -> str:
        return str(upper("report.html", "notebook", self))
