"""Catalogue of the figures of a run: caption, function, and why a result has no data for one."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from ..errors import VfifeError, shown, suggestion
from ..results.run_data import RunData
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
from .elastic import bodies_with_stress, deflection, links_with_deflection, stress
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


def _without_reference(draw: Callable[[RunData], Figure]) -> Callable[[RunData, RunData | None], Figure]:
    return lambda result, _: draw(result)


def _needs_motion(data: Callable[[RunData], object], otherwise: str) -> Callable[[RunData], str]:
    return lambda result: STATIC if result.record.static else "" if data(result) else otherwise


def _needs(data: Callable[[RunData], object], otherwise: str) -> Callable[[RunData], str]:
    return lambda result: "" if data(result) else otherwise


def _several_outputs(result: RunData) -> bool:
    return len(result.record.steps) > 1


def _few_turns(result: RunData) -> str:
    if result.record.static:
        return STATIC
    if not joint_forces(result):
        return NO_FORCE
    parts = pieces(result)
    if parts is not None and len(parts.starts) >= WATERFALL_TURNS:
        return ""
    return f"it takes {WATERFALL_TURNS} turns, or {LEAST_OUTPUTS} outputs of a run without turns"


def _vibrating(result: RunData) -> str:
    assembly = result.record.assembly
    if not assembly.contacts and not any(body.elements for body in assembly.bodies.values()):
        return "no joint has clearance and no body is elastic, so nothing vibrates"
    return _needs_motion(forces, FEW_OUTPUTS)(result)


NO_FORCE = "no joint carries a force"
FEW_OUTPUTS = f"{NO_FORCE}, or there are fewer than {SAMPLES} outputs"
FIGURES: dict[str, FigureKind] = {
    "mechanism": FigureKind("bodies and joints, faint over the last turn",
        _without_reference(drawing), usual=True),
    "orbits": FigureKind(
        "journals in their clearance circles, seen from their bearings", _without_reference(orbits),
        _needs(journals, "no journal has clearance in its bearing"), usual=True,
    ),
    "guides": FigureKind(
        "blocks with clearance in their guides: tilt over offset", _without_reference(guides),
        _needs(loose_guides, "no block has clearance in a guide"), usual=True,
    ),
    "forces": FigureKind(
        "joint forces over the turn, with the ideal ones and the peaks that are reported", force_curves,
        _needs(joint_forces, NO_FORCE), usual=True,
    ),
    "moments": FigureKind(
        "moments of gears, welds and guides, torques of drivers", moment_curves,
        _needs(moments, "no joint carries a moment, and nothing is driven"), usual=True,
    ),
    "accelerations": FigureKind(
        "sliders along their guides, angular accelerations of other bodies", acceleration_curves,
        _needs_motion(accelerations, "what moves is driven evenly, or hardly turns"), usual=True,
    ),
    "strip": FigureKind("the mechanism at moments of the turn, side by side", _without_reference(strip),
        _needs(_several_outputs, "there is one output")),
    "traces": FigureKind("paths of points, with those of the ideal mechanism",
        traces, _needs(points, "no point moves")),
    "polar": FigureKind("forces on journals as vectors, seen from their bearings",
        polar, _needs(joint_forces, NO_FORCE)),
    "wear": FigureKind("depths that bearings and journals lose in a million turns, around them",
        _without_reference(wear_of_turn),
        _needs_motion(has_wear, "no journal in a bearing has a coefficient of wear")),
    "phase": FigureKind("velocity over position of bodies and sliders",
        phase, _needs_motion(portraits, "what moves is driven")),
    "spectrum": FigureKind(
        "amplitudes of joint forces over order or frequency", spectrum,
        _needs_motion(
            lambda result: pieces(result) and joint_forces(result),
            f"{NO_FORCE}, or there are too few outputs",
        ),
    ),
    "waterfall": FigureKind(
        "spectra of joint forces turn by turn", _without_reference(waterfall), _few_turns,
    ),
    "spectrogram": FigureKind("joint forces in time and frequency, in short windows",
        _without_reference(spectrogram), _needs_motion(forces, FEW_OUTPUTS)),
    "envelope": FigureKind("envelopes of joint forces, and their spectra",
        _without_reference(envelope), _vibrating),
    "energy": FigureKind("what is stored, supplied and lost, and what the ledger leaves",
        _without_reference(energy), _needs_motion(_several_outputs, "there is one output")),
    "stress": FigureKind(
        "stress along elastic links and frames", _without_reference(stress),
        _needs(bodies_with_stress, "no elastic link or frame has a section whose extreme fibre is known"),
    ),
    "deflection": FigureKind("deflection along elastic links",
        _without_reference(deflection), _needs(links_with_deflection, "no link is elastic")),
}  # fmt: skip
ALL_FIGURES = "all"  # as a name: all that a result has


# Words of captions that hold with a turn of a crank, with an ideal reference, and what holds without them.
WITHOUT_TURNS = {
    "faint over the last turn": ("faint later", "faint at other load factors"),
    "over the turn": ("over time", "over the load factor"),
    "moments of the turn": ("moments of the run", "load factors"),
}
OF_REFERENCE = (" with the ideal ones and", ", with those of the ideal mechanism")


def caption(name: str, result: RunData) -> str:
    """Return the caption of a figure of a result: the description of its kind, without turns and ideal joints
    where there are none.
    """
    text = FIGURES[name].description
    if result.crank is None or result.record.static:
        for words, (moving, static) in WITHOUT_TURNS.items():
            text = text.replace(words, static if result.record.static else moving)
    if name == "accelerations" and not any(
        quantity.unit == "m/s²" for quantity in accelerations(result).values()
    ):
        text = "angular accelerations of bodies that are not driven"
    if result.reference is None:
        for words in OF_REFERENCE:
            text = text.replace(words, " with" if words.endswith("and") else "")
    return text[0].upper() + text[1:]


def usual(result: RunData) -> list[str]:
    """Return the names of the default figures that have data."""
    return [name for name, kind in FIGURES.items() if kind.usual and not kind.missing(result)]


def available(result: RunData) -> list[str]:
    """Return the names of the figures that have data."""
    return [name for name, kind in FIGURES.items() if not kind.missing(result)]


def check_names(names: Collection[Any]) -> None:
    """Raise VfifeError, with the name that may be meant, for an unknown figure."""
    for name in names:
        if not isinstance(name, str) or (name not in FIGURES and name != ALL_FIGURES):
            raise VfifeError(
                f"there is no figure {shown(name)}: {suggestion(name, FIGURES, 'name one of the figures')}"
            )
