"""Many runs of one question, and one run that a script steps.

The package is also the function: ``vfife.study(...)`` is :func:`~vfife.study.studies.study`.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Room(ModuleType):
    """The package, which can be called."""

    def __call__(self, *given: Any, **named: Any) -> Any:
        from .studies import study

        return study(*given, **named)


sys.modules[__name__].__class__ = _Room
