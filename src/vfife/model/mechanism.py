"""The mechanism that a user builds: named bodies, joints, drivers and loads with plain numbers in
SI units.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ..schema import (
    PLACE,
    SCALAR,
    Choice,
    Entries,
    FixedList,
    FreeList,
    Inner,
    Integer,
    Measure,
    Names,
    Share,
    Text,
    described,
    quantity,
)
from .bodies import Body
from .builders import Builders
from .drivers import Driver
from .joints import ClearanceRevolute, Contact, Gear, Joint
from .loads import Load
from .lumping import rigidified
from .readers import with_units
from .springs import AnySpring, ForceElement

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.figure import Figure

    from ..live.page.page import Live
    from ..report.check import Checked

StartMode = Literal["consistent", "rough"]
STATIC = ("static",)
MOST_COMPANIONS = 7  # with the run itself they fill the widest vectors that steps are compiled for
Journals = Literal["centred", "seated"]
# Turns that differ by more than a fifth do not repeat in any sense of use: a settled motion has 1 %.
REPETITION = Share(above=0.0, high=0.2)


@with_units("start")
@dataclass(frozen=True)
class StartSettings:
    """How a run starts.

    ``consistent``: positions, velocities and accelerations of the ideal mechanism; elastic links carry the
    corresponding forces. ``rough``: positions and velocities only; links are unstressed. Journals are
    ``centred`` in their bearings, or ``seated`` where the ideal reaction presses them.
    """

    mode: StartMode = described(
        Choice(("consistent", "rough")),
        "consistent: ideal velocities and accelerations, elastic links with their forces; rough: without",
        "consistent",
    )
    journals: Journals = described(
        Choice(("centred", "seated")),
        "journals centred in their bearings, or seated where the ideal reaction presses them",
        "centred",
    )
    time: float | None = quantity(
        "s",
        "time of drivers and loads at the beginning of the run; if left out: 0, or the end of the run that"
        " is continued",
        None,
    )


@with_units("run")
@dataclass(frozen=True)
class Settings:
    """Defaults of a run: its length in crank ``turns`` or as ``duration`` (s), the step (s, or "auto") and
    the number of outputs per turn (per run without a crank).

    With ``settle`` a run ends as soon as two turns agree within that share of their largest values, at the
    latest after ``turns``. ``companions`` are repetitions of a run with contact with other step sizes; their
    scatter estimates the step error. An automatic step is halved until the largest values of a turn agree
    within ``tolerance``.

    A static ``analysis`` computes the equilibrium under each of the ``load_factors``, which replace time in
    loads and drivers. It ends when the unbalanced force is at most ``residual`` times the largest force and
    the kinetic energy at most ``kinetic_energy`` times its largest value, or fails after ``iterations``.
    """

    selected_by: ClassVar[str] = "analysis"  # the field that says which others are of use

    turns: float | None = quantity("1", "length of the run in turns of the crank", None, above=0.0)
    duration: float | None = quantity("s", "length of the run in time, instead of turns", None, above=0.0)
    settle: float | None = described(
        REPETITION,
        "the run ends when two turns agree within this share of their largest values, at the latest after"
        " turns",
        None,
    )
    step: float | Literal["auto"] = described(
        Measure("s", above=0.0, words=("auto",)),
        'time step, or "auto" for the largest that is stable and accurate',
        "auto",
    )
    outputs: int = described(
        Integer(1, 100_000_000),
        "outputs per turn, the nearest number into which a given step divides it; per run without a crank",
        720,
    )
    parts: int = described(
        Integer(1, 64),
        "smaller steps into which a step is divided if a contact begins, ends or changes in it; 1: undivided,"
        " as in the paper",
        8,
    )
    companions: int | Literal["auto"] = described(
        Integer(0, MOST_COMPANIONS, words=("auto",)),
        'runs with other step sizes, which estimate the error of a run with contact; "auto" for three, 0 for'
        " none",
        "auto",
    )
    tolerance: float = quantity(
        "1",
        "relative range of the largest values over run and companions at which an automatic step is accepted",
        0.005,
        above=0.0,
        high=1.0,
    )
    energy_limit: float = quantity(
        "1",
        "largest residual of the energy balance over the largest energy; a run that exceeds it is stopped",
        0.1,
        above=0.0,
    )
    damping: float = quantity("1/s", "mass-proportional damping", 0.0, low=0.0)
    path_unit: int = described(Integer(1, 1_000_000), "steps in a path unit of the elements", 1)
    analysis: Literal["dynamic", "static"] = described(
        Choice(("dynamic", "static")),
        "dynamic: motion over time; static: equilibrium under each of the load factors",
        "dynamic",
    )
    load_factors: tuple[float, ...] = described(
        FreeList(SCALAR), "of a static analysis: they replace time in loads and drivers", (1.0,), only=STATIC
    )
    residual: float = quantity(
        "1",
        "of a static analysis: largest unbalanced force, as a share of the largest force",
        1e-6,
        above=0.0,
        high=0.1,
        only=STATIC,
    )
    kinetic_energy: float = quantity(
        "1",
        "of a static analysis: largest remaining kinetic energy, as a share of its largest value",
        1e-10,
        above=0.0,
        high=0.1,
        only=STATIC,
    )
    iterations: int = described(
        Integer(1, 1_000_000_000),
        "of a static analysis: largest number of iterations for a load factor",
        1_000_000,
        only=STATIC,
    )


@with_units()
@dataclass(repr=False)
class Mechanism(Builders):
    """Bodies, joints, drivers and loads by name; all numbers in SI units. ``source`` is the file read.

    >>> m = Mechanism("pendulum", gravity=(0.0, -9.81))
    >>> pivot = m.point("pivot", 0.0, 0.0)
    >>> rod = m.link("rod", length=1.0, mass=1.0)
    >>> joint = m.revolute("A", pivot, rod.start)  # or "ground.pivot", "rod.start"
    """

    name: str = described(Text(), "name of the model", "mechanism")
    note: str = described(Text(), "a note for readers", "")
    gravity: tuple[float, float] = described(
        FixedList((Measure("m/s^2"), Measure("m/s^2"))), "acceleration of gravity", (0.0, 0.0)
    )
    points: dict[str, tuple[float, float]] = described(
        Names(PLACE), "points of the ground", factory=dict, key="ground"
    )
    bodies: dict[str, Body] = described(Entries(Body), "bodies by name", factory=dict, key="body")
    joints: dict[str, Joint] = described(Entries(Joint), "joints by name", factory=dict, key="joint")
    drivers: dict[str, Driver] = described(
        Entries(Driver),
        "drivers by name, which is that of the body unless body, slider or point is given",
        factory=dict,
        key="driver",
    )
    loads: dict[str, Load] = described(Entries(Load), "loads by name", factory=dict, key="load")
    gears: dict[str, Gear] = described(
        Entries(Gear),
        "gears and belts by name: they carry moments, forces between teeth are not modelled",
        factory=dict,
        key="gear",
    )
    springs: dict[str, AnySpring] = described(
        Entries(ForceElement), "springs, dampers, stops and bushings by name", factory=dict, key="spring"
    )
    start: StartSettings = described(Inner(StartSettings), "how a run starts", factory=StartSettings)
    settings: Settings = described(Inner(Settings), "defaults of a run", factory=Settings, key="run")
    source: str | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        parts: dict[tuple[str, str], dict[str, Any]] = {
            ("body", "bodies"): self.bodies,
            ("joint", "joints"): self.joints,
            ("driver", "drivers"): self.drivers,
            ("load", "loads"): self.loads,
            ("spring", "springs"): self.springs,
        }
        counts = ", ".join(f"{len(items)} {nouns[len(items) > 1]}" for nouns, items in parts.items() if items)
        return f"<Mechanism {self.name!r}: {counts or 'empty'}; see .check(), .plot(), .live()>"

    @property
    def clearances(self) -> dict[str, ClearanceRevolute]:
        """Revolute joints with clearance, by name; :attr:`contacts` has all joints with clearance."""
        return {name: joint for name, joint in self.joints.items() if isinstance(joint, ClearanceRevolute)}

    @property
    def contacts(self) -> dict[str, Contact]:
        """Joints with clearance, by name: revolutes, sliders, curved slots and external contacts."""
        return {name: joint for name, joint in self.joints.items() if isinstance(joint, Contact)}

    if TYPE_CHECKING:  # attached by vfife.methods

        def to_toml(self) -> str:
            """See :func:`vfife.methods.to_toml`."""

        def check(self) -> Checked:
            """See :func:`vfife.methods.check`."""

        def plot(self) -> Figure:
            """See :func:`vfife.methods.plot`."""

        def live(self, slide: Iterable[str] | None = None) -> Live:
            """See :func:`vfife.methods.live`."""

        def _repr_html_(self) -> str: ...

    def crank_turns(self, turn: float | None, duration: float) -> float | None:
        """Return how many turns the crank with a period of ``turn`` (s) makes within a run of a ``duration``
        (s), if it runs up in it; None otherwise.
        """
        cranks = [driver for driver in self.drivers.values() if driver.has_turns and not driver.is_linear]
        if turn is None or not cranks:
            return None
        fastest = max(cranks, key=lambda driver: driver.largest_speed)
        return fastest.crank_turns(turn, self.clock, duration)

    @property
    def clock(self) -> float:
        """Time (s) of drivers and loads at the beginning of a run; 0 for a static analysis."""
        return 0.0 if self.settings.analysis == "static" else self.start.time or 0.0

    def ideal(self, shared: Callable[..., Any] = lambda function, *items: function(*items)) -> Mechanism:
        """Return the reference for runs with clearance: all joints ideal, all bodies rigid with their lumped
        masses, damping 0.

        ``shared`` calls a function with objects of this mechanism; it may return a former result for them.
        """
        result = copy(self)
        result.name = f"{self.name}, ideal"
        result.bodies = shared(_rigidified, self.bodies)
        result.joints = shared(_ideal_joints, self.joints)
        result.settings = shared(_ideal_settings, self.settings)
        result.start = shared(_ideal_start, self.start)
        return result


def _rigidified(bodies: dict[str, Body]) -> dict[str, Body]:
    return {name: rigidified(body) for name, body in bodies.items()}


def _ideal_joints(joints: dict[str, Joint]) -> dict[str, Joint]:
    return {name: ideal for name, joint in joints.items() if (ideal := joint.reference) is not None}


def _ideal_settings(settings: Settings) -> Settings:
    return dataclasses.replace(settings, step="auto", damping=0.0)


def _ideal_start(start: StartSettings) -> StartSettings:
    return StartSettings(time=start.time)
