"""Methods whose answers layers above give, such as ``mechanism.plot()``: the layer is loaded when the method
is called.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar


def upper(module: str, function: str, *given: Any) -> Any:
    """Call a function of a module of this package, which is imported then."""
    return getattr(import_module(f"vfife.{module}"), function)(*given)


class NotebookDocument:
    """A result that a notebook shows as its document: title, tables, cautions.

    ``former_names``: attributes by the names that they had in version 0.2, which warn.
    """

    former_names: ClassVar[Mapping[str, str]] = {}

    def _repr_html_(self) -> str:
        return str(upper("report.html", "notebook", self))

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            present = type(self).former_names.get(name)
            if present is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            text = f"{type(self).__name__}.{name} is {present} now; the old name goes with the next version"
            warnings.warn(text, DeprecationWarning, stacklevel=2)
            return getattr(self, present)
