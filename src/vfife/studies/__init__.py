"""Many runs of one model: studies, searches, tolerance, sensitivity, comparison."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..results.study import Study as Study
    from ..results.study import load_study as load_study
    from ..solvers.ensemble import ensemble as ensemble
    from .methods.compare import Comparison as Comparison
    from .methods.compare import compare as compare
    from .methods.derivatives import sensitivity as sensitivity
    from .methods.sensitivity_indices import indices as indices
    from .methods.tolerance import tolerance as tolerance
    from .study_work import Allocation as Allocation
    from .study_work import Optimum as Optimum
    from .study_work import allocate as allocate
    from .study_work import optimise as optimise
    from .study_work import study as study

_MODULES = {  # of public names, each loaded when it is first used
    "Allocation": ".study_work",
    "Comparison": ".methods.compare",
    "Optimum": ".study_work",
    "Study": "..results.study",
    "allocate": ".study_work",
    "compare": ".methods.compare",
    "ensemble": "..solvers.ensemble",
    "indices": ".methods.sensitivity_indices",
    "load_study": "..results.study",
    "optimise": ".study_work",
    "sensitivity": ".methods.derivatives",
    "study": ".study_work",
    "tolerance": ".methods.tolerance",
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_MODULES[name], __name__), name)
    import_module("..methods", __name__).attach()  # plot() of what a loaded study is, for example
    return value


def __dir__() -> list[str]:
    return __all__
