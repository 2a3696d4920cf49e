"""vfife: planar mechanisms whose pins have play, by the vector form intrinsic finite element method.

Everything a script needs is here: nouns, laws, ways to run them and the files they leave. Nothing is loaded before it is asked for, so that the
command line hears signals from its first line on; llvmlite, xarray and matplotlib only where something needs them.
"""

from __future__ import annotations

from sys import modules as _modules
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import errors, gallery
    from .analysis.modes import modes
    from .errors import VfifeError
    from .laws import MATERIALS, ContactLaw, FrictionLaw, Law, Material, Pair, quantity
    from .laws import contact as _contact
    from .laws import friction as _friction
    from .laws.contact import *  # noqa: F403
    from .laws.friction import *  # noqa: F403
    from .laws.user import load_laws
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
    from .modelfile.files import load, load_model, save_model
    from .result import Result, load_result
    from .results.comparison import Comparison
    from .results.fit import load_fit
    from .results.spectra import envelope, spectrogram, spectrum
    from .results.studied import Study, load_study
    from .simulation import resume, simulate
    from .solvers.ensemble import ensemble
    from .solvers.status import Status
    from .study.compare import compare
    from .study.cosimulation import Simulation
    from .study.derivatives import sensitivity
    from .study.identification.fitting import fit
    from .study.maps.basins import basins
    from .study.maps.bifurcation import bifurcation
    from .study.maps.load_map import load_map
    from .study.maps.sections import poincare_section
    from .study.maps.waterfall import waterfall
    from .study.sensitivity_indices import indices
    from .study.studies import allocate, optimise, study
    from .study.tolerance import tolerance
    from .study.tribology.simulate_wear import load_wear, wear
    from .study.tribology.wear_state import Worn

__version__ = "0.2.0"

_LAZY = {  # public name: the module that has it, or the module itself
    "Comparison": "results.comparison",
    "Result": "result",
    "Simulation": "study.cosimulation",
    "Study": "results.studied",
    "Status": "solvers.status",
    "VfifeError": "errors",
    "allocate": "study.studies",
    "basins": "study.maps.basins",
    "bifurcation": "study.maps.bifurcation",
    "compare": "study.compare",
    "ensemble": "solvers.ensemble",
    "envelope": "results.spectra",
    "errors": "",
    "fit": "study.identification.fitting",
    "gallery": "",
    "indices": "study.sensitivity_indices",
    "load": "modelfile.files",
    "load_fit": "results.fit",
    "load_laws": "laws.user",
    "load_map": "study.maps.load_map",
    "load_model": "modelfile.files",
    "load_result": "result",
    "load_study": "results.studied",
    "modes": "analysis.modes",
    "optimise": "study.studies",
    "poincare_section": "study.maps.sections",
    "resume": "simulation",
    "save_model": "modelfile.files",
    "sensitivity": "study.derivatives",
    "simulate": "simulation",
    "load_wear": "study.tribology.simulate_wear",
    "spectrogram": "results.spectra",
    "spectrum": "results.spectra",
    "tolerance": "study.tolerance",
    "waterfall": "study.maps.waterfall",
    "study": "",  # the room, which can be called
    "wear": "study.tribology.simulate_wear",
    "Worn": "study.tribology.wear_state",
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

        value = getattr(import_module(f".{_LAZY[name]}", __name__), name) if _LAZY[name] else import_module(f".{name}", __name__)
        globals()[name] = value
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
