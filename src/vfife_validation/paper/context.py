"""What the items share: the parameter set inferred from Table 3, and the runs that several of them look
at.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from importlib import resources
from typing import Any

from vfife.solvers.status import Status

from .contents import Parameter
from .influence import MOST_TURNS, STEP, TOLERANCE, Case, Influence, influences
from .mechanisms import CLEARANCE, CLEARANCES, FASTEST, LINK_WORDS, SPEEDS, Parameters
from .search import from_numbers


def fitted() -> dict[str, Any]:
    """Read the stored result of the search for the lost parameters, with its provenance."""
    outcome: dict[str, Any] = json.loads(
        resources.files(__package__).joinpath("fitted.json").read_text(encoding="utf-8")
    )
    return outcome


@dataclass
class Context:
    """Runs and parameters by need; ``tell`` is told what is being computed, ``progress`` how much of it is
    done.
    """

    tell: Callable[[str], None] = lambda text: None
    progress: Callable[[int, int], None] | None = None
    budget: float = 0.0
    seed: int = 1
    fit: dict[str, Any] = field(default_factory=fitted)
    computed: dict[str, Any] = field(default_factory=dict)

    def compute_once(self, name: str, make: Callable[[], Any]) -> Any:
        """Return the result of ``make``, computed on the first call with this name."""
        if name not in self.computed:
            self.computed[name] = make()
        return self.computed[name]

    @cached_property
    def parameters(self) -> Parameters:
        """The set that fits Table 3 best."""
        return from_numbers(self.fit["best"]["parameters"])

    def influences(self, title: str, cases: list[Case], **options: Any) -> list[Influence]:
        """Run the four-bar cases, each until its turns repeat."""
        self.tell(title)
        return influences(cases, progress=self.progress, **options)

    @cached_property
    def three(self) -> dict[tuple[float, float], Influence]:
        """Three loose joints: by clearance (m) and crank speed (rad/s), the runs of Sect. 5."""
        keys = [(c, FASTEST) for c in CLEARANCES] + [(CLEARANCE, speed) for speed in SPEEDS[:-1]]
        influences = self.influences(
            "three clearance joints, Sect. 5", [Case(self.parameters, c, speed) for c, speed in keys]
        )
        return dict(zip(keys, influences, strict=True))

    @property
    def sizes(self) -> list[Influence]:
        """The runs of Sect. 5.1, by clearance."""
        return [self.three[c, FASTEST] for c in CLEARANCES]

    @property
    def speeds(self) -> list[Influence]:
        """The runs of Sect. 5.2, by crank speed."""
        return [self.three[CLEARANCE, speed] for speed in SPEEDS]


def described(p: Parameters) -> list[Parameter]:
    """List the parameters of a four-bar run, with their origins."""
    low = "lost Table 2; fit to Table 3"
    start = f"crank at {math.degrees(p.crank_angle):.0f}°, ideal velocities, journals centred"
    restitution = p.contact.restitution  # type: ignore[attr-defined]
    moment = (
        "at the particles alone"
        if p.friction_moment == "off"
        else f"with moments ({p.friction_moment}), R_B = {1e3 * p.bearing_radius:.3g} mm"
    )
    return [
        Parameter(
            "lengths and masses",
            "ground 0.150, crank 0.400, coupler 0.260, follower 0.460 m; 3.120, 2.028, 3.588 kg",
            "stated",
            "Table 1",
        ),
        Parameter("friction coefficient c_f", f"{p.friction:g}", "stated", "Sect. 5"),
        Parameter(
            "contact law",
            {"pereira": "enhanced (Pereira), Eq. 26-28"}.get(p.contact.name, p.contact.name),
            "stated",
            "Sect. 3.2",
        ),
        Parameter("E, ν", "207 GPa, 0.3", "inferred", "Sect. 4.1 prints 2.07 GPa; see Fig. 8"),
        Parameter("axial length L", f"{1e3 * p.axial_length:.4g} mm", "inferred", low),
        Parameter("restitution c_e", f"{restitution:.4g}", "inferred", low),
        Parameter("friction speeds v0, v1", f"{p.v0:.4g}, {p.v1:.4g} m/s", "inferred", low),
        Parameter(
            "links", LINK_WORDS[p.link], "inferred", "fit to Table 3; the paper calls its bodies rigid"
        ),
        Parameter("where friction acts", moment, "inferred", "Eq. 23-25 have no moment; fit to Table 3"),
        Parameter(
            "branch",
            "joint 2 below the line from joint 1 to the ground pivot" if p.below else "joint 2 above",
            "inferred",
            "Fig. 11 is lost",
        ),
        Parameter("start", start, "inferred", "Fig. 11 is lost; angle from the fit"),
        Parameter("step", f"{1e6 * STEP:g} µs", "chosen", "see `beyond`"),
        Parameter(
            "settled",
            f"turns within {TOLERANCE:g} of each other, {MOST_TURNS} turns at the most",
            "chosen",
            "",
        ),
    ]


def settling(influence: Influence) -> str:
    """How a run ended, in words."""
    if influence.run.status != Status.COMPLETE:
        return Status.DIVERGED
    last = float(influence.run.distances[-1])
    if influence.run.settled is None:
        return f"not settled in {len(influence.run.distances)} turns (last two apart by {last:.1e})"
    return f"turn {influence.run.settled} repeats the one before to {last:.0e}"
