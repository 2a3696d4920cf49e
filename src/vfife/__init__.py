"""vfife: planar mechanisms whose pins have play, by the vector form intrinsic finite element method.

Everything a script needs is here; numba, xarray and matplotlib are loaded only when something asks for them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .laws import (
    MATERIALS,
    Ambrosio,
    BengisuAkay,
    BrownMcPhee,
    ContactLaw,
    Coulomb,
    Dahl,
    FrictionLaw,
    Frictionless,
    GonthierFriction,
    Hydrodynamic,
    Karnopp,
    LankaraniNikravesh,
    LuGre,
    Material,
    Pair,
    Pereira,
    Stribeck,
    Threlfall,
    quantity,
)
from .model.bodies import Link, PointMass, RigidBody, Section
from .model.drivers import AngleTable, ConstantSpeed, Ramp, Torque
from .model.joints import ClearanceRevolute, IdealRevolute
from .model.loads import PointForce
from .model.mechanism import Mechanism, Settings, Start, StartSettings

if TYPE_CHECKING:
    from . import gallery
    from .laws.user import load_laws
    from .modelfile import load
    from .result import Result
    from .simulation import simulate
    from .study.compare import compare

__version__ = "0.1.0"

_LAZY = {
    "compare": "study.compare",
    "gallery": "",
    "load": "modelfile",
    "load_laws": "laws.user",
    "Result": "result",
    "simulate": "simulation",
}


def __dir__() -> list[str]:
    """What can be completed: all public names, loaded or not."""
    return sorted({*__all__, *_LAZY, *globals()})


def __getattr__(name: str) -> Any:
    """Loads what needs compiled code or large libraries when it is first asked for."""
    if name in _LAZY:
        from importlib import import_module

        value = getattr(import_module(f".{_LAZY[name]}", __name__), name) if _LAZY[name] else import_module(f".{name}", __name__)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'vfife' has no attribute {name!r}")


__all__ = [
    "MATERIALS",
    "Ambrosio",
    "AngleTable",
    "BengisuAkay",
    "BrownMcPhee",
    "ClearanceRevolute",
    "ConstantSpeed",
    "ContactLaw",
    "Coulomb",
    "Dahl",
    "FrictionLaw",
    "Frictionless",
    "GonthierFriction",
    "Hydrodynamic",
    "IdealRevolute",
    "Karnopp",
    "LankaraniNikravesh",
    "Link",
    "LuGre",
    "Material",
    "Mechanism",
    "Pair",
    "Pereira",
    "PointForce",
    "PointMass",
    "Ramp",
    "Result",
    "RigidBody",
    "Section",
    "Settings",
    "Start",
    "StartSettings",
    "Stribeck",
    "Threlfall",
    "Torque",
    "compare",
    "gallery",
    "load",
    "load_laws",
    "quantity",
    "simulate",
]
