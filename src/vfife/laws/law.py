"""What a law is: a frozen dataclass whose fields a user sets, and one static function of plain numbers that the step runs.

A contact law turns penetration (m) and impact speed (m/s) into an elastic force (N) and a damping coefficient (N s/m):
F_N = elastic + damping * rate, never below zero. It is linear in the rate, so a step solves it in closed form. A friction law solves its own
relation: given the normal force, the sliding velocity without friction, and the mobility, the sliding velocity is free + mobility * force.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, ClassVar


class LawError(ValueError):
    """A law of the user's own that cannot be used: which law, in which file and line, why, and what to do."""


@dataclass(frozen=True)
class Material:
    """Elastic constants of a body: Young's modulus (Pa), Poisson's ratio, density (kg/m^3)."""

    name: str = "steel"
    youngs_modulus: float = 207e9
    poissons_ratio: float = 0.3
    density: float = 7800.0

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E in 1/Pa."""
        return (1.0 - self.poissons_ratio**2) / self.youngs_modulus


@dataclass(frozen=True)
class Pair:
    """The two surfaces that meet: bearing radius, clearance and axial length (m), and their materials."""

    bearing_radius: float
    clearance: float
    axial_length: float
    bearing: Material = Material()
    journal: Material = Material()

    @property
    def journal_radius(self) -> float:
        """R_J = R_B - c (m), Eq. 18."""
        return self.bearing_radius - self.clearance

    @property
    def composite_modulus(self) -> float:
        """E* with 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j (Pa); Eq. 28 for equal materials."""
        return 1.0 / (self.bearing.compliance + self.journal.compliance)


def quantity(
    unit: str,
    meaning: str,
    default: Any = dataclasses.MISSING,
    *,
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
) -> Any:
    """A field of a law: its unit ("1" if it has none), meaning and default, and its limits: at least ``low``, at most ``high``, ``above``."""
    return dataclasses.field(default=default, metadata={"unit": unit, "meaning": meaning, "low": low, "high": high, "above": above})


# Units of slots that several laws have, and that are no fields.
SLOT_UNITS = {"damping_factor": "1", "exponent_beyond_1": "1", "ramp": "m/s"}


@dataclass(frozen=True)
class Law:
    """Shared by contact and friction laws. Subclasses register themselves by ``name``.

    ``slots`` names the numbers that the function receives, ``slot_units`` their units where no field of the same name tells them.
    """

    name: ClassVar[str] = ""
    source: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    slots: ClassVar[tuple[str, ...]] = ()
    slot_units: ClassVar[dict[str, str]] = {}
    registry: ClassVar[dict[str, type[Law]]] = {}

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Registers the law. Raises ValueError where its name is that of a built-in law; a law of one's own may be defined again."""
        super().__init_subclass__(**kwargs)
        if not cls.__dict__.get("name"):
            return
        known = cls.registry.get(cls.name)
        if known is not None and built_in(known) and (cls.__module__, cls.__qualname__) != (known.__module__, known.__qualname__):
            raise ValueError(f"the name {cls.name!r} is taken by a law that vfife brings, {known.__name__}; call {cls.__qualname__} otherwise")
        cls.registry[cls.name] = cls

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """The numbers of ``slots``, derived from the fields and the two surfaces."""
        raise NotImplementedError

    def derived(self, pair: Pair) -> dict[str, str]:
        """Numbers worth printing, by slot name."""
        return {name: f"{value:.6g}" for name, value in zip(self.slots, self.parameters(pair), strict=True)}

    def units(self, pair: Pair) -> dict[str, str]:
        """Unit of each slot: as ``slot_units`` says, else that of the field of the same name; "" where neither knows."""
        fields = {field.name: str(field.metadata.get("unit", "")) for field in dataclasses.fields(self)}
        return {slot: self.slot_units.get(slot, fields.get(slot, SLOT_UNITS.get(slot, ""))) for slot in self.slots}


def built_in(law: type[Law]) -> bool:
    """Whether a law is one that vfife brings."""
    return law.__module__.startswith("vfife.laws.")


@dataclass(frozen=True)
class ContactLaw(Law):
    """Normal contact law.

    One with ``film`` also acts while the surfaces are apart, through a second static function ``film_force``; see ``Hydrodynamic``.
    """

    film: ClassVar[bool] = False
    registry: ClassVar[dict[str, type[Law]]] = {}

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m).

        The penetration (m) is never negative; ``slowness`` is 1/impact_speed (s/m), held from the onset of a contact to its end.
        """
        raise NotImplementedError

    def exponent_at(self, depth: float, pair: Pair) -> float:
        """n = d ln F/d ln delta of the elastic force at a penetration (m): constant where F = K delta^n."""
        p = self.parameters(pair)
        low, high = (self.force(share * depth, 0.0, p)[0] for share in (0.999, 1.001))
        return math.log(high / low) / math.log(1.001 / 0.999) if low > 0.0 else math.nan

    def units(self, pair: Pair) -> dict[str, str]:
        """Units of the slots; that of a stiffness follows from the exponent."""
        found = super().units(pair)
        if found.get("stiffness", "N/m") in ("", "N/m^n"):
            found["stiffness"] = f"N/m^{self.exponent_at(0.05 * pair.clearance, pair):.4g}".removesuffix("^1")
        return found

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """Energy (J) stored at a penetration (m), of any shape: integral of the elastic force."""
        raise NotImplementedError


@dataclass(frozen=True)
class FrictionLaw(Law):
    """Friction law."""

    registry: ClassVar[dict[str, type[Law]]] = {}

    @staticmethod
    def force(normal_force: float, free_velocity: float, mobility: float, memory: float, dt: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Friction force (N) and memory, the sliding velocity being free_velocity + mobility * force."""
        raise NotImplementedError
