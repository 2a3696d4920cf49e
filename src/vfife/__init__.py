"""vfife: planar mechanisms whose pins have play, by the vector form intrinsic finite element method.

Everything a script needs is here: nouns, laws, ways to run them and the files they leave. Nothing is loaded
before it is asked for, so that the command line hears signals from its first line on; llvmlite, xarray and
matplotlib only where something needs them.
"""

from __future__ import annotations

from sys import modules as _modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import errors, gallery
    from .dynamics.basins import basins
    from .dynamics.bifurcation import bifurcation
    from .dynamics.load_map import load_map
    from .dynamics.sections import poincare_section
    from .dynamics.waterfall import waterfall
    from .errors import VfifeError
    from .identification.fitting import fit
    from .laws import MATERIALS, ContactLaw, FrictionLaw, Law, Material, Pair, quantity
    from .laws import contact as _contact
    from .laws import friction as _friction
    from .laws.contact import *  # noqa: F403
    from .laws.friction import *  # noqa: F403
    from .laws.user import load_laws
    from .measures.modes import modes
    from .model import drivers as _drivers
    from .model import joints as _joints
    from .model import loads as _loads
    from .model import springs as _springs
    from .model.bodies import Frame, Link, Member, PointMass, RigidBody, Section
    from .model.drivers import *  # noqa: F403
    from .model.joints import *  # noqa: F403
    from .model.loads import *  # noqa: F403
    from .model.mechanism import Mechanism, Settings, StartSettings
    from .model.springs import *  # noqa: F403
    from .model.wear import Wear
    from .modelfile.read import load, load_model
    from .modelfile.write import save_model
    from .results.comparison import Comparison
    from .results.fit import load_fit
    from .results.spectra import envelope, spectrogram, spectrum
    from .results.studied import Study, load_study
    from .simulation.cosimulation import Simulation
    from .simulation.result import Result, load_result
    from .simulation.simulate import resume, simulate
    from .solvers.ensemble import ensemble
    from .solvers.status import Status
    from .studies.methods.compare import compare
    from .studies.methods.derivatives import sensitivity
    from .studies.methods.sensitivity_indices import indices
    from .studies.methods.tolerance import tolerance
    from .studies.study import allocate, optimise, study
    from .tribology.simulate_wear import load_wear, wear
    from .tribology.wear_state import Worn

__version__ = "0.2.0"

_LAZY = {  # public name: the module that has it, or the module itself
    "Comparison": "results.comparison",
    "Result": "simulation.result",
    "Simulation": "simulation.cosimulation",
    "Study": "results.studied",
    "Status": "solvers.status",
    "VfifeError": "errors",
    "allocate": "studies.study",
    "basins": "dynamics.basins",
    "bifurcation": "dynamics.bifurcation",
    "compare": "studies.methods.compare",
    "ensemble": "solvers.ensemble",
    "envelope": "results.spectra",
    "errors": "",
    "fit": "identification.fitting",
    "gallery": "",
    "indices": "studies.methods.sensitivity_indices",
    "load": "modelfile.read",
    "load_fit": "results.fit",
    "load_laws": "laws.user",
    "load_map": "dynamics.load_map",
    "load_model": "modelfile.read",
    "load_result": "simulation.result",
    "load_study": "results.studied",
    "modes": "measures.modes",
    "optimise": "studies.study",
    "poincare_section": "dynamics.sections",
    "resume": "simulation.simulate",
    "save_model": "modelfile.write",
    "sensitivity": "studies.methods.derivatives",
    "simulate": "simulation.simulate",
    "load_wear": "tribology.simulate_wear",
    "spectrogram": "results.spectra",
    "spectrum": "results.spectra",
    "tolerance": "studies.methods.tolerance",
    "waterfall": "dynamics.waterfall",
    "study": "studies.study",
    "wear": "tribology.simulate_wear",
    "Worn": "tribology.wear_state",
}
_ROOMS = {  # of nouns and laws: the public names in each, or None for all that it lists itself
    "laws": ("MATERIALS", "ContactLaw", "FrictionLaw", "Law", "Material", "Pair", "quantity"),
    "laws.contact": None,
    "laws.friction": None,
    "model.bodies": ("Frame", "Link", "Member", "PointMass", "RigidBody", "Section"),
    "model.joints": None,
    "model.springs": None,
    "model.drivers": None,
    "model.loads": None,
    "model.mechanism": ("Mechanism", "Settings", "StartSettings"),
    "model.wear": ("Wear",),
}


_LISTED: list[str] = []  # the public names that no room lists


def __dir__() -> list[str]:
    """What can be completed: all public names, loaded or not."""
    _furnish()
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def __getattr__(name: str) -> Any:
    """Loads what needs compiled code or large libraries when it is first asked for."""
    if name in _LAZY:
        from importlib import import_module

        value = (
            getattr(import_module(f".{_LAZY[name]}", __name__), name)
            if _LAZY[name]
            else import_module(f".{name}", __name__)
        )
        globals()[name] = value
        _attach()
        return value
    if "__all__" not in globals() and (name == "__all__" or not name.startswith("__")):
        _furnish()
        return getattr(_modules[__name__], name)
    raise AttributeError(f"module 'vfife' has no attribute {name!r}")


def _furnish() -> None:
    """Loads the rooms of nouns and laws, and lists their names."""
    from importlib import import_module

    listed = list(_LISTED)
    for room, names in _ROOMS.items():
        module = import_module(f".{room}", __name__)
        globals().update({name: getattr(module, name) for name in names or module.__all__})
        listed += [] if names else module.__all__
    globals()["__all__"] = listed
    _attach()


def _attach() -> None:
    """Gives classes that are loaded the methods whose answers packages above them give."""
    from importlib import import_module

    import_module(".methods", __name__).attach()


# Laws and kinds make themselves known in their rooms, so that a new one is its file and an import line there.
__all__ = [
    "MATERIALS",
    "Comparison",
    "ContactLaw",
    "Frame",
    "FrictionLaw",
    "Law",
    "Link",
    "Material",
    "Mechanism",
    "Member",
    "Pair",
    "PointMass",
    "Result",
    "RigidBody",
    "Section",
    "Settings",
    "Simulation",
    "StartSettings",
    "Status",
    "Study",
    "VfifeError",
    "Wear",
    "Worn",
    "allocate",
    "basins",
    "bifurcation",
    "compare",
    "ensemble",
    "envelope",
    "errors",
    "fit",
    "gallery",
    "indices",
    "load",
    "load_fit",
    "load_laws",
    "load_map",
    "load_model",
    "load_result",
    "load_study",
    "load_wear",
    "modes",
    "optimise",
    "poincare_section",
    "quantity",
    "resume",
    "save_model",
    "sensitivity",
    "simulate",
    "spectrogram",
    "spectrum",
    "study",
    "tolerance",
    "waterfall",
    "wear",
]
if TYPE_CHECKING:
    __all__ += _contact.__all__  # room by room: a type checker follows one such list, and not a list of lists
    __all__ += _friction.__all__
    __all__ += _joints.__all__
    __all__ += _springs.__all__
    __all__ += _drivers.__all__
    __all__ += _loads.__all__
else:
    _LISTED += __all__
    del __all__  # it is whole when the rooms are loaded: __getattr__ sees to that
