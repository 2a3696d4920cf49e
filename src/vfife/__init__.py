"""vfife: planar mechanisms whose pins have play, by the vector form intrinsic finite element method.

Everything a script needs is here: nouns, laws, ways to run them and the files they leave. Numba, xarray and matplotlib are loaded only when
something asks for them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .laws import MATERIALS, ContactLaw, FrictionLaw, Law, Material, Pair, quantity
from .laws import contact as _contact
from .laws import friction as _friction
from .laws.contact import *  # noqa: F403
from .laws.friction import *  # noqa: F403
from .model import above as _above
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

if TYPE_CHECKING:
    from . import errors, gallery
    from .errors import VfifeError
    from .laws.user import load_laws
    from .modelfile.files import load, load_model, save_model
    from .result import Result, load_result
    from .results.comparison import Comparison
    from .simulation import resume, simulate
    from .solvers.ensemble import ensemble
    from .solvers.status import Status
    from .study.compare import compare

__version__ = "0.1.0"

_LAZY = {  # public name: the module that has it, or the module itself
    "Comparison": "results.comparison",
    "Result": "result",
    "Status": "solvers.status",
    "VfifeError": "errors",
    "compare": "study.compare",
    "ensemble": "solvers.ensemble",
    "errors": "",
    "gallery": "",
    "load": "modelfile.files",
    "load_laws": "laws.user",
    "load_model": "modelfile.files",
    "load_result": "result",
    "resume": "simulation",
    "save_model": "modelfile.files",
    "simulate": "simulation",
}
_FORMER = {"Start": "StartSettings"}  # what a name of version 0.1 is called now


def _later(module: str, name: str) -> Callable[..., Any]:
    """A function of a room that is loaded when it is first called."""

    def answer(*given: Any) -> Any:
        from importlib import import_module

        return getattr(import_module(f".{module}", __name__), name)(*given)

    return answer


_above.ANSWERS |= {
    "to_toml": _later("modelfile", "dump"),
    "check": _later("report.checked", "checked"),
    "plot": _later("plots", "at_start"),
    "html": _later("plots.notebook", "mechanism_html"),
}


def __dir__() -> list[str]:
    """What can be completed: all public names, loaded or not."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def __getattr__(name: str) -> Any:
    """Loads what needs compiled code or large libraries when it is first asked for."""
    if name in _FORMER:
        import warnings

        now = _FORMER[name]
        warnings.warn(f"vfife.{name} is called vfife.{now} now; the old name goes with the next version", DeprecationWarning, stacklevel=2)
        return globals()[now] if now in globals() else __getattr__(now)
    if name in _LAZY:
        from importlib import import_module

        value = getattr(import_module(f".{_LAZY[name]}", __name__), name) if _LAZY[name] else import_module(f".{name}", __name__)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'vfife' has no attribute {name!r}")


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
    "StartSettings",
    "Status",
    "VfifeError",
    "compare",
    "ensemble",
    "errors",
    "gallery",
    "load",
    "load_laws",
    "load_model",
    "load_result",
    "quantity",
    "resume",
    "save_model",
    "simulate",
]
__all__ += _contact.__all__  # room by room: a type checker follows one such list, and not a list of lists
__all__ += _friction.__all__
__all__ += _joints.__all__
__all__ += _springs.__all__
__all__ += _drivers.__all__
__all__ += _loads.__all__
