"""Base classes of laws: a law is a frozen dataclass, whose fields a user sets, with one static function of
plain numbers, which the step executes.

A contact law computes, from penetration (m) and impact speed (m/s), an elastic force (N) and a damping
coefficient (N s/m): F_N = elastic + damping * rate, never below zero. It is linear in the rate, so that a
step solves it in closed form. A friction law solves its own relation: with the sliding velocity that there
would be without friction, ``free``, and the mobility, the sliding velocity is free + mobility * force.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Self

from ..errors import ArgumentError, Fault, LawError, shown, suggestion
from ..numerics.scalar import log
from ..schema import Choice, Reader, Switch, Text, contains_unit, described_fields, value_of
from ..schema import quantity as quantity


@dataclass(frozen=True)
class Material:
    """Elastic constants of a body: Young's modulus (Pa), Poisson's ratio (1), density (kg/m^3), and hardness
    (Pa) if it is known; ``name`` appears in messages.
    """

    name: str = "steel"
    youngs_modulus: float = quantity("Pa", "Young's modulus", 207e9, above=0.0)
    poissons_ratio: float = quantity("1", "Poisson's ratio", 0.3, above=-1.0, high=0.5)
    density: float = quantity("kg/m^3", "density", 7800.0, above=0.0)
    hardness: float | None = quantity(
        "Pa",
        "indentation hardness: Brinell's or Vickers' number times 9.81 MPa; if left out, that of `vfife"
        " materials`, or none",
        None,
        above=0.0,
    )

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E in 1/Pa."""
        return (1.0 - self.poissons_ratio * self.poissons_ratio) / self.youngs_modulus


@dataclass(frozen=True)
class Pair:
    """The two surfaces of a contact: radii, ``clearance`` and ``axial_length`` (m), and their materials.

    The journal of radius R_J = R_B - c is inside the bearing. With an ``opposite_radius`` there are two
    rounds side by side (external contact), of which the first may be straight
    (``bearing_radius = math.inf``). ``effective_mass`` (kg) is m_i m_j/(m_i + m_j) of the two bodies, if it
    is known.
    """

    bearing_radius: float
    clearance: float
    axial_length: float
    bearing: Material = Material()
    journal: Material = Material()
    opposite_radius: float | None = None
    effective_mass: float | None = None

    def between(self, effective_mass: float | None) -> Pair:
        """Return the same surfaces between other bodies.

        effective_mass: m_i m_j/(m_i + m_j) of the bodies (kg), None if it is unknown
        """
        return Pair(
            self.bearing_radius,
            self.clearance,
            self.axial_length,
            self.bearing,
            self.journal,
            self.opposite_radius,
            effective_mass,
        )

    @property
    def external(self) -> bool:
        """Whether the contact is external: two rounds side by side."""
        return self.opposite_radius is not None

    @property
    def journal_radius(self) -> float:
        """R_J = R_B - c (m), Eq. 18; outside, the opposite radius."""
        return self.bearing_radius - self.clearance if self.opposite_radius is None else self.opposite_radius

    @property
    def radius_difference(self) -> float:
        """dR = R_B - R_J inside, which is the clearance; R_B + R_J outside (m)."""
        return self.clearance if self.opposite_radius is None else self.bearing_radius + self.opposite_radius

    @property
    def relative_radius(self) -> float:
        """R_B R_J/(R_B - R_J) inside, R_B R_J/(R_B + R_J) outside (m)."""
        if math.isinf(self.bearing_radius):
            return self.journal_radius
        return self.bearing_radius * self.journal_radius / self.radius_difference

    @property
    def composite_modulus(self) -> float:
        """E* with 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j (Pa); Eq. 28 for equal materials."""
        return 1.0 / (self.bearing.compliance + self.journal.compliance)

    @property
    def hertz_stiffness(self) -> float:
        """K of F = K delta^1.5, 4/3 E* sqrt(R) with the relative radius R (N/m^1.5)."""
        return 4.0 / 3.0 * self.composite_modulus * math.sqrt(self.relative_radius)

    @property
    def wave_speed(self) -> float:
        """sqrt(E/rho) of the slower of the two materials (m/s)."""
        return min(
            math.sqrt(material.youngs_modulus / material.density) for material in (self.bearing, self.journal)
        )


# Units of slots that several laws have, and that are no fields.
SLOT_UNITS = {"damping_factor": "1", "exponent_beyond_1": "1", "ramp": "m/s"}


@dataclass(frozen=True, kw_only=True)
class Law:
    """Base of contact and friction laws. Subclasses register themselves by ``name``.

    A ``common`` law is part of every data-driven loop, used or not, so that one compilation serves most
    models. ``slots`` names the parameters that the function receives, ``slot_units`` gives their units if no
    field has the same name.
    """

    name: ClassVar[str] = ""
    source: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    slots: ClassVar[tuple[str, ...]] = ()
    common: ClassVar[bool] = False
    slot_units: ClassVar[dict[str, str]] = {}
    registry: ClassVar[dict[str, type[Law]]] = {}

    def __new__(cls, *numbers: Any, **values: Any) -> Self:
        """Refuse positional arguments: numbers in the wrong order would not be noticed."""
        if numbers:
            written = ", ".join(f"{field.name}=..." for field in dataclasses.fields(cls))
            raise TypeError(
                f"the law {cls.name!r} takes its parameters by name, as in {cls.__name__}({written})"
            )
        known = [field.name for field in dataclasses.fields(cls)]
        if faults := [
            Fault(
                (name,),
                "there is no such parameter",
                shown(value),
                "",
                suggestion(name, known, "leave it out"),
            )
            for name, value in values.items()
            if name not in known
        ]:
            raise ArgumentError(faults, f"{cls.__name__}()")
        return super().__new__(cls)

    def __init_subclass__(cls, register: bool = True, **kwargs: Any) -> None:
        """Register the law. Raises ValueError for the name of a built-in law; a user's law may be defined
        again.
        """
        super().__init_subclass__(**kwargs)
        if not register or not cls.__dict__.get("name"):
            return
        former = cls.registry.get(cls.name)
        if (
            former is not None
            and built_in(former)
            and (cls.__module__, cls.__qualname__) != (former.__module__, former.__qualname__)
        ):
            raise ValueError(
                f"the name {cls.name!r} is taken by a law that vfife brings, {former.__name__}; call"
                f" {cls.__qualname__} otherwise"
            )
        cls.registry[cls.name] = cls

    def __post_init__(self) -> None:
        """Replace texts with units by numbers in SI units. Raise LawError with every parameter outside its
        limits, or that contradicts another.
        """
        texts, reader = Reader(written=True), Reader()
        fields = described_fields(type(self))
        for field in fields:
            value, value_type = getattr(self, field.name), value_of(field)
            if contains_unit(value) and not isinstance(value_type, Text | Choice | Switch):
                number = value_type.read(value, (field.name,), texts)
                object.__setattr__(self, field.name, value if number is None else number)
        reader.fields((), self)
        refused = {fault.path[0] for fault in texts.faults}
        plain_faults = [fault for fault in reader.faults if fault.path[0] not in refused]
        order = [field.name for field in fields]
        faults = sorted([*texts.faults, *plain_faults], key=lambda fault: order.index(str(fault.path[0])))
        faults = faults or list(self.disagreements())
        if faults:
            raise LawError(f'law "{self.name}": {" ".join(map(str, faults))}', faults)

    def disagreements(self) -> Iterator[Fault]:
        """Yield faults of parameters that are within their limits but contradict each other; ``where`` is the
        name of one of them.
        """
        return iter(())

    @classmethod
    def known(cls) -> Mapping[str, type[Law]]:
        """Return the laws of this kind by name: those of the registry, replaced by those of the run file that
        is being read in this context.
        """
        return {**cls.registry, **{law.name: law for law in _STANDING_IN.get() if issubclass(law, cls)}}

    @classmethod
    def form(cls) -> type[Law]:
        """Return the first base class with this law's ``force`` and ``slots``. Laws of one form differ only
        in their parameters and are compiled once.
        """
        return _form(cls)  # type: ignore[arg-type]

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Return the parameters named in ``slots``, derived from the fields and the surfaces ``pair``. Raises
        ValueError for surfaces that the law does not cover.
        """
        raise NotImplementedError

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Return sentences, without full stops, on where the law leaves the range of its source for this
        pair, and what it does there.

        pair: the two surfaces
        penetration: deepest penetration of a run (m); without it, cautions that only a run can give are left
        out
        impact_speed: speed of the fastest impact of a run (m/s)
        """
        return ()

    def misfit(self, pair: Pair) -> str:
        """Return how far a stiffness that was given is from that of the surfaces ``pair``, as a sentence
        without a full stop; "" where it fits them, or none was given.
        """
        return ""

    def facts(self, pair: Pair) -> tuple[str, ...]:
        """Return sentences, without full stops, on how the law takes its own parameters between the surfaces
        ``pair``. A fact is shown with the laws of a model; it is a caution only for answers that it changes.
        """
        return ()

    def usual(self, pair: Pair) -> tuple[float, float] | None:
        """Return the impact speeds (m/s) between the surfaces ``pair`` at which a run is beyond the
        quasi-static theory of the law, as nearly all machines are; it is mentioned, but not as a caution.
        None without such a range.
        """
        return None

    def derived(self, pair: Pair) -> dict[str, str]:
        """Return the parameters of the law between the surfaces ``pair`` as text, by slot name."""
        return {name: f"{value:.6g}" for name, value in zip(self.slots, self.parameters(pair), strict=True)}

    def units(self, pair: Pair) -> dict[str, str]:
        """Return the unit of each slot for the surfaces ``pair``: that in ``slot_units``, else of the field
        of the same name, else "".
        """
        fields = {field.name: str(field.metadata.get("unit", "")) for field in dataclasses.fields(self)}
        return {
            slot: self.slot_units.get(slot, fields.get(slot, SLOT_UNITS.get(slot, ""))) for slot in self.slots
        }


# Laws that are known in this context only: other threads do not see them.
_STANDING_IN: ContextVar[tuple[type[Law], ...]] = ContextVar("standing_in", default=())


@contextmanager
def registered_here(laws: Sequence[type[Law]]) -> Iterator[None]:
    """Make laws known by their names while a text is read, in this context only, without a change of the
    registry.
    """
    token = _STANDING_IN.set((*_STANDING_IN.get(), *laws))
    try:
        yield
    finally:
        _STANDING_IN.reset(token)


def built_in(kind: type) -> bool:
    """Return whether a law or a model class is part of vfife."""
    return kind.__module__.startswith(("vfife.laws.", "vfife.model."))


@dataclass(frozen=True, kw_only=True)
class ContactLaw(Law):
    """Base of contact laws.

    A law with ``film`` also acts in free flight, through a second static function ``film_force``; see
    ``Hydrodynamic``. A ``tabled`` law has more numbers than slots; ``knots`` returns them in pieces for the
    kernels' ``tabled_law``; see ``Tabulated``.
    """

    film: ClassVar[bool] = False
    tabled: ClassVar[bool] = False
    registry: ClassVar[dict[str, type[Law]]] = {}

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Return elastic force (N) and damping coefficient (N s/m).

        The penetration (m) is never negative. ``slowness`` is 1/impact_speed (s/m), constant from the onset
        of a contact to its end; ``p`` are the parameters of ``slots``.
        """
        raise NotImplementedError

    def require_inside(self, pair: Pair) -> None:
        """Raise ValueError if ``pair`` are two rounds side by side, which the law does not cover."""
        if pair.external:
            raise ValueError(
                f'the law "{self.name}" is for a journal inside a bearing; for two rounds side by side take'
                ' "pereira" or "johnson"'
            )

    def knots(self) -> tuple[tuple[float, ...], ...]:
        """Return the pieces of a law that is a table, each as a record of the block ``knot``; none for other
        laws.
        """
        return ()

    def slowness(self, speed: float, rate: float) -> float:
        """Return the slowness (s/m) for ``force`` in an impact that began at ``speed`` (m/s), at a ``rate``
        of penetration (m/s).
        """
        return 1.0 / speed

    def exponent_at(self, depth: float, pair: Pair) -> float:
        """Return n = d ln F/d ln delta of the elastic force, which is constant if F = K delta^n.

        depth: penetration (m)
        pair: the two surfaces
        """
        p = self.parameters(pair)
        low, high = (self.force(share * depth, 0.0, p)[0] for share in (0.999, 1.001))
        return log(high / low) / log(1.001 / 0.999) if low > 0.0 else math.nan

    def units(self, pair: Pair) -> dict[str, str]:
        """Return the units of the slots; that of a stiffness follows from the exponent."""
        units = super().units(pair)
        if units.get("stiffness", "N/m") in ("", "N/m^n"):
            units["stiffness"] = f"N/m^{self.exponent_at(0.05 * pair.clearance, pair):.4g}".removesuffix("^1")
        return units

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """Return the energy (J) stored at a penetration: the integral of the elastic force.

        penetration: in m, of any shape
        p: the parameters of :meth:`parameters`
        """
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class FrictionLaw(Law):
    """Base of friction laws.

    ``memory`` names the quantities, with units, that the law keeps from step to step: up to three numbers,
    which are zero at the start and wherever the normal force is zero, because bristles spring back when
    nothing presses on them. ``set_valued``: the law holds two surfaces at rest by any force up to a limit; it
    receives the sliding velocity half a step later, where sticking means exactly zero.

    ``regime`` is a static function of the sliding velocity (m/s, 0 for sticking) and the parameters. It
    returns a number for each smooth part of the curve; a step in which it changes is repeated in smaller
    ones. None: the curve has no kinks.
    """

    registry: ClassVar[dict[str, type[Law]]] = {}
    memory: ClassVar[tuple[str, ...]] = ()
    regime: ClassVar[Any] = None
    set_valued: ClassVar[bool] = False

    @property
    def dissipative(self) -> bool:
        """Whether the force only takes energy: its memory has nothing but velocities. Bent bristles return
        energy, other memories may, and of a law of the user's own nothing is known.
        """
        return built_in(type(self)) and all(entry.endswith("(m/s)") for entry in self.memory)

    @staticmethod
    def force(
        normal_force: float,
        free_velocity: float,
        mobility: float,
        memory: Any,
        dt: float,
        p: tuple[float, ...],
    ) -> tuple[float, Any]:
        """Return the friction force (N) and the new memory; the sliding velocity is free_velocity + mobility
        * force.

        normal_force: in N, never negative
        free_velocity: sliding velocity without friction (m/s)
        mobility: change of the sliding velocity by a force of 1 N (m/s/N)
        memory: a number if the law names one, a tuple if it names several, and 0 otherwise
        dt: time step (s)
        p: the parameters of :meth:`parameters`
        """
        raise NotImplementedError


LAWS: dict[str, type[Law]] = {"contact": ContactLaw, "friction": FrictionLaw}


def law_kind(law: type[Law]) -> str:
    """Return the key in ``LAWS`` of a law's base: "contact" or "friction"."""
    return "contact" if issubclass(law, ContactLaw) else "friction"


@lru_cache(maxsize=256)
def _form(law: type[Law]) -> type[Law]:
    """Return the form of a law."""
    force, regime = law.force, getattr(law, "regime", None)  # type: ignore[attr-defined]
    alike = [
        base
        for base in law.__mro__
        if issubclass(base, Law) and getattr(base, "force", None) is force and base.slots == law.slots
    ]
    return [base for base in alike if getattr(base, "regime", None) is regime][-1]
