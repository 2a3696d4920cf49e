"""Catalogue of the figures of a run: caption, function, and why a result has no data for one."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import VfifeError, shown, suggestion
from .curves import (
    acceleration_curves,
    accelerations,
    energy,
    force_curves,
    joint_forces,
    moment_curves,
    moments,
)
from .drawing import drawing, strip
from .elastic import bent, deflection, stress, stressed
from .motion import guides, journals, loose_guides, orbits, phase, points, polar, portraits, traces
from .spectra import (
    LEAST_OUTPUTS,
    SAMPLES,
    WATERFALL_TURNS,
    envelope,
    forces,
    pieces,
    spectrogram,
    spectrum,
    waterfall,
)
from .wear import has_wear, wear_of_turn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.run_data import RunData

STATIC = "a static analysis has no motion"


@dataclass(frozen=True)
class FigureKind:
    """A figure with a caption. ``missing`` returns why a result has no data for it, or ""; ``usual`` ones are
    the default.
    """

    description: str
    draw: Callable[[RunData, RunData | None], Figure]
    missing: Callable[[RunData], str] = lambda result: ""
    usual: bool = False


def _alone(draw: Callable[[RunData], Figure]) -> Callable[[RunData, RunData | None], Figure]:
    return lambda result, _: draw(result)


def _moving(has: Callable[[RunData], object], otherwise: str) -> Callable[[RunData], str]:
    return lambda result: STATIC if result.record.static else "" if has(result) else otherwise


def _having(has: Callable[[RunData], object], otherwise: str) -> Callable[[RunData], str]:
    return lambda result: "" if has(result) else otherwise


def _several_outputs(result: RunData) -> bool:
    return len(result.record.steps) > 1


def _few_turns(result: RunData) -> str:
    if result.record.static or not joint_forces(result):
        return STATIC if result.record.static else NO_FORCE
    parts = pieces(result)
    enough = parts is not None and len(parts.starts) >= WATERFALL_TURNS
    return (
        ""
        if enough
        else f"it takes {WATERFALL_TURNS} turns, or {LEAST_OUTPUTS} outputs of a run without turns"
    )


def _vibrating(result: RunData) -> str:
    assembly = result.record.assembly
    if not assembly.contacts and not any(body.elements for body in assembly.bodies.values()):
        return "no joint has clearance and no body is elastic, so nothing vibrates"
    return _moving(forces, FEW_OUTPUTS)(result)


NO_FORCE = "no joint carries a force"
FEW_OUTPUTS = f"{NO_FORCE}, or there are fewer than {SAMPLES} outputs"
FIGURES: dict[str, FigureKind] = {
    "mechanism": FigureKind("bodies and joints, faint over the last turn",
        _alone(drawing), usual=True),
    "orbits": FigureKind(
        "journals in their clearance circles, seen from their bearings", _alone(orbits),
        _having(journals, "no journal has clearance in its bearing"), usual=True,
    ),
    "guides": FigureKind(
        "blocks with clearance in their guides: tilt over offset", _alone(guides),
        _having(loose_guides, "no block has clearance in a guide"), usual=True,
    ),
    "forces": FigureKind(
        "joint forces over the turn, with the ideal ones and the peaks that are reported", force_curves,
        _having(joint_forces, NO_FORCE), usual=True,
    ),
    "moments": FigureKind(
        "moments of gears, welds and guides, torques of drivers", moment_curves,
        _having(moments, "no joint carries a moment, and nothing is driven"), usual=True,
    ),
    "accelerations": FigureKind(
        "sliders along their guides, angular accelerations of other bodies", acceleration_curves,
        _moving(accelerations, "what moves is driven evenly"), usual=True,
    ),
    "strip": FigureKind("the mechanism at moments of the turn, side by side", _alone(strip),
                  _having(_several_outputs, "there is one output")),
    "traces": FigureKind("paths of points, with those of the ideal mechanism",
        traces, _having(points, "no point moves")),
    "polar": FigureKind("forces on journals as vectors, seen from their bearings",
        polar, _having(joint_forces, NO_FORCE)),
    "wear": FigureKind("depths that bearings and journals lose in a million turns, around them",
        _alone(wear_of_turn),
                 _moving(has_wear, "no journal in a bearing has a coefficient of wear")),
    "phase": FigureKind("velocity over position of bodies and sliders",
        phase, _moving(portraits, "what moves is driven")),
    "spectrum": FigureKind(
        "amplitudes of joint forces over order or frequency", spectrum,
        _moving(lambda one: pieces(one) and joint_forces(one), f"{NO_FORCE}, or there are too few outputs"),
    ),
    "waterfall": FigureKind("spectra of joint forces turn by turn", _alone(waterfall), _few_turns),
    "spectrogram": FigureKind("joint forces in time and frequency, in short windows",
        _alone(spectrogram), _moving(forces, FEW_OUTPUTS)),
    "envelope": FigureKind("envelopes of joint forces, and their spectra",
        _alone(envelope), _vibrating),
    "energy": FigureKind("what is stored, supplied and lost, and what the ledger leaves", _alone(energy),
                   _moving(_several_outputs, "there is one output")),
    "stress": FigureKind(
        "stress along elastic links and frames", _alone(stress),
        _having(stressed, "no elastic link or frame has a section whose extreme fibre is known"),
    ),
    "deflection": FigureKind("deflection along elastic links",
        _alone(deflection), _having(bent, "no link is elastic")),
}  # fmt: skip
ALL_FIGURES = "all"  # as a name: all that a result has


def usual(result: RunData) -> list[str]:
    """Return the names of the default figures that have data."""
    return [name for name, one in FIGURES.items() if one.usual and not one.missing(result)]


def available(result: RunData) -> list[str]:
    """Return the names of the figures that have data."""
    return [name for name, one in FIGURES.items() if not one.missing(result)]


def check_names(names: Collection[Any]) -> None:
    """Raise VfifeError, with the name that may be meant, for an unknown figure."""
    for name in names:
        if not isinstance(name, str) or (name not in FIGURES and name != ALL_FIGURES):
            raise VfifeError(
                f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one that there is')}"
            )
