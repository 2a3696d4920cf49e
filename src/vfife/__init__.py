"""vfife: planar mechanisms whose pins have clearance, by the vector form intrinsic finite element method.

This module has the names that a first script needs: a mechanism, runs and studies of it, and files. Others
are grouped by subject: ``vfife.bodies``, ``joints``, ``springs``, ``drivers``, ``loads`` and ``laws`` have
the classes of which a mechanism is built; ``studies``, ``dynamics``, ``identification`` and ``tribology``
what is done with many runs; ``options`` groups of keywords; ``gallery`` mechanisms to start from; ``errors``
what is raised.

Every name is loaded when it is first used, so that the command line handles signals from its first line on;
llvmlite, xarray and matplotlib only where something needs them.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import bodies as bodies
    from . import drivers as drivers
    from . import dynamics as dynamics
    from . import errors as errors
    from . import gallery as gallery
    from . import identification as identification
    from . import joints as joints
    from . import laws as laws
    from . import loads as loads
    from . import options as options
    from . import springs as springs
    from . import studies as studies
    from . import tribology as tribology
    from .assessment.design_work import design as design
    from .dynamics.bifurcation import bifurcation as bifurcation
    from .errors import VfifeError as VfifeError
    from .identification import fit as fit
    from .job.job import Interrupted as Interrupted
    from .laws import Material as Material
    from .model.mechanism import Mechanism as Mechanism
    from .model.mechanism import Settings as Settings
    from .model.mechanism import StartSettings as StartSettings
    from .modelfile.read import load as load
    from .modelfile.read import load_model as load_model
    from .modelfile.write import save_model as save_model
    from .simulation.cosimulation import Simulation as Simulation
    from .simulation.result import Result as Result
    from .simulation.result import load_result as load_result
    from .simulation.resumption import resume as resume
    from .simulation.simulate import simulate as simulate
    from .solvers.status import Status as Status
    from .studies import compare as compare
    from .studies import optimise as optimise
    from .studies import sensitivity as sensitivity
    from .studies import study as study
    from .tribology import wear as wear

__version__ = "0.2.0"

_NAMESPACES = (
    "bodies", "drivers", "dynamics", "errors", "gallery", "identification", "joints", "laws", "loads",
    "options", "springs", "studies", "tribology",
)  # fmt: skip
_NAMES = {  # by the module that has them
    "assessment.design_work": ("design",),
    "dynamics": ("bifurcation",),
    "errors": ("VfifeError",),
    "identification": ("fit",),
    "job.job": ("Interrupted",),
    "laws.law": ("Material",),
    "model.mechanism": ("Mechanism", "Settings", "StartSettings"),
    "modelfile.read": ("load", "load_model"),
    "modelfile.write": ("save_model",),
    "simulation.cosimulation": ("Simulation",),
    "simulation.result": ("Result", "load_result"),
    "simulation.resumption": ("resume",),
    "simulation.simulate": ("simulate",),
    "solvers.status": ("Status",),
    "studies": ("compare", "optimise", "sensitivity", "study"),
    "tribology": ("wear",),
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names}
# Classes and functions of these were names of vfife up to version 0.2.
_FORMER = (
    "laws", "joints", "bodies", "springs", "drivers", "loads", "studies", "dynamics", "identification",
    "tribology"
)  # fmt: skip
__all__ = sorted((*_NAMESPACES, *_MODULES))


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used."""
    if name in _NAMESPACES:
        value: Any = import_module(f".{name}", __name__)
    elif name in _MODULES:
        value = getattr(import_module(f".{_MODULES[name]}", __name__), name)
    elif (
        name.startswith("_") or find_spec(f"{__name__}.{name}") is not None
    ):  # a module, which is imported then
        raise AttributeError(f"module 'vfife' has no attribute {name!r}")
    else:
        value = _former(name)
    import_module(".methods", __name__).attach()
    return globals().setdefault(name, value) if name in __all__ else value


def _former(name: str) -> Any:
    """Return what a name of version 0.2 stands for, with a warning that says where it is now."""
    for namespace in _FORMER:
        module = import_module(f".{namespace}", __name__)
        if name in module.__all__:
            text = (
                f"vfife.{name} is vfife.{namespace}.{name} now; the old name will be removed in the next"
                " version"
            )
            warnings.warn(text, DeprecationWarning, stacklevel=3)
            return getattr(module, name)
    raise AttributeError(f"module 'vfife' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
