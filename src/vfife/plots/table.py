"""The table of figures: what each shows, how it is drawn, and why a result has nothing for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .along import bent, deflection, stress, stressed
from .clearances import guides, journals, loose_guides, orbits, polar
from .curves import acceleration_curves, accelerations, force_curves, joint_forces, moment_curves, moments
from .drawing import drawing, strip
from .energy import energy
from .paths import phase, points, portraits, traces
from .spectra import FEW, LEAST, SAMPLES, envelope, forces, pieces, spectrogram, spectrum, waterfall
from .worn import in_a_turn, wears

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..results.view import View

STATIC = "a static analysis has no motion"


@dataclass(frozen=True)
class Kind:
    """``says`` in a line what is shown; ``lacks`` tells why a result has nothing for it, "" where it has; a
    ``usual`` one is drawn unasked.
    """

    says: str
    draw: Callable[[View, View | None], Figure]
    lacks: Callable[[View], str] = lambda result: ""
    usual: bool = False


def _moving(has: Callable[[View], object], otherwise: str) -> Callable[[View], str]:
    return lambda result: STATIC if result.record.static else "" if has(result) else otherwise


def _having(has: Callable[[View], object], otherwise: str) -> Callable[[View], str]:
    return lambda result: "" if has(result) else otherwise


def _several_outputs(result: View) -> bool:
    return len(result.record.steps) > 1


def _few_turns(result: View) -> str:
    if result.record.static or not joint_forces(result):
        return STATIC if result.record.static else NO_FORCE
    found = pieces(result)
    enough = found is not None and len(found[0]) >= FEW
    return "" if enough else f"it takes {FEW} turns, or {LEAST} outputs of a run without turns"


NO_FORCE = "no joint carries a force"
FEW_OUTPUTS = f"{NO_FORCE}, or there are fewer than {SAMPLES} outputs"
FIGURES: dict[str, Kind] = {
    "mechanism": Kind("bodies and joints at the start, faint over the last turn", lambda one, _: drawing(one), usual=True),
    "orbits": Kind(
        "journals in their clearance circles, seen from their bearings", lambda one, _: orbits(one),
        _having(journals, "no journal has play in its bearing"), usual=True,
    ),
    "guides": Kind(
        "blocks with play in their guides: tilt over offset", lambda one, _: guides(one),
        _having(loose_guides, "no block has play in a guide"), usual=True,
    ),
    "forces": Kind(
        "joint forces over the turn, with the ideal ones and the peaks that are reported", force_curves,
        _having(joint_forces, NO_FORCE), usual=True,
    ),
    "moments": Kind(
        "moments of gears, welds and guides, torques of drivers", moment_curves,
        _having(moments, "no joint carries a moment, and nothing is driven"), usual=True,
    ),
    "accelerations": Kind(
        "sliders along their guides, angular accelerations of other bodies", acceleration_curves,
        _moving(accelerations, "what moves is driven evenly"), usual=True,
    ),
    "strip": Kind("the mechanism at moments of the turn, side by side", lambda one, _: strip(one),
                  _having(_several_outputs, "there is one output")),
    "traces": Kind("paths of points, with those of the ideal mechanism", traces, _having(points, "no point moves")),
    "polar": Kind("forces on journals as vectors, seen from their bearings", polar, _having(joint_forces, NO_FORCE)),
    "wear": Kind("depths that bearings and journals lose in a million turns, around them", lambda one, _: in_a_turn(one),
                 _moving(wears, "no journal in a bearing has a coefficient of wear")),
    "phase": Kind("velocity over position of bodies and sliders", phase, _moving(portraits, "what moves is driven")),
    "spectrum": Kind(
        "amplitudes of joint forces over order or frequency", spectrum,
        _moving(lambda one: pieces(one) and joint_forces(one), f"{NO_FORCE}, or there are too few outputs"),
    ),
    "waterfall": Kind("spectra of joint forces turn by turn", lambda one, _: waterfall(one), _few_turns),
    "spectrogram": Kind("joint forces in time and frequency, in short windows", lambda one, _: spectrogram(one), _moving(forces, FEW_OUTPUTS)),
    "envelope": Kind("envelopes of joint forces, and their spectra", lambda one, _: envelope(one), _moving(forces, FEW_OUTPUTS)),
    "energy": Kind("what is stored, supplied and lost, and what the ledger leaves", lambda one, _: energy(one),
                   _moving(_several_outputs, "there is one output")),
    "stress": Kind(
        "stress along elastic links and frames", lambda one, _: stress(one),
        _having(stressed, "no elastic link or frame has a section whose extreme fibre is known"),
    ),
    "deflection": Kind("deflection along elastic links", lambda one, _: deflection(one), _having(bent, "no link is elastic")),
}  # fmt: skip
EVERY = "all"  # as a name: all that a result has


def usual(result: View) -> list[str]:
    """Names of the figures that are drawn unasked, of those that the result has something for."""
    return [name for name, one in FIGURES.items() if one.usual and not one.lacks(result)]


def available(result: View) -> list[str]:
    """Names of the figures that the result has something for."""
    return [name for name, one in FIGURES.items() if not one.lacks(result)]
