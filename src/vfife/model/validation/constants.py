"""Cautions about physical constants in the units of another program: gravity in mm/s^2, moduli in MPa or GPa,
densities in g/cm^3 or t/mm^3.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...laws import Material
from ...numerics.scalar import hypot
from ..bodies import Frame, Link

if TYPE_CHECKING:
    from ..mechanism import Mechanism

STRONGEST_GRAVITY = 30.0  # m/s^2: Jupiter has 24.8
SOFTEST = 5e5  # Pa: rubbers have 1 to 100 MPa, steel in MPa without a unit is 2.1e5
STIFFEST = 2e12  # Pa: diamond has 1.2e12
GIGA = 1e3  # moduli below may be numbers of GPa, others of MPa
LIGHTEST, DENSEST = 15.0, 25_000.0  # kg/m^3: foams and osmium; metals in g/cm^3 have 1.7 to 22.6
TONNES = 1e-6  # kg/m^3: densities below may be numbers of t/mm^3


def suspect_constants(mechanism: Mechanism) -> Iterator[str]:
    """Yield cautions about gravity and materials beyond any that exist, with the unit that is probably
    meant.
    """
    gravity = hypot(*mechanism.gravity)
    if gravity > STRONGEST_GRAVITY:
        yield (
            f"gravity is {gravity:.6g} m/s^2, {gravity / 9.81:,.0f} times that of the Earth: is it"
            f" {gravity:.6g} mm/s^2? Numbers without a unit are m/s^2."
        )
    for material in dict.fromkeys(materials_of(mechanism)):
        yield from _suspect_material(material)


def materials_of(mechanism: Mechanism) -> Iterator[Material]:
    """Yield the materials that matter: those of sections, and of the surfaces of contacts."""
    for body in mechanism.bodies.values():
        if isinstance(body, Link | Frame) and body.section is not None:
            yield body.material
        if isinstance(body, Frame):
            yield from (member.material for member in body.members if member.material is not None)
    for joint in mechanism.contacts.values():
        for side, (owner, _) in zip(
            (joint.bearing_material, joint.journal_material), joint.sides, strict=True
        ):
            if side is not None:
                yield side
            elif owner != "ground":
                yield mechanism.bodies[owner].material


def _suspect_material(material: Material) -> Iterator[str]:
    modulus, density = material.youngs_modulus, material.density
    name = f"material {material.name}" if material.name else "the material"
    if modulus < SOFTEST:
        unit = "GPa" if modulus < GIGA else "MPa"
        yield (
            f"The Young's modulus of {name} is {modulus:.6g} Pa, below that of rubber: is it"
            f" {modulus:.6g} {unit}? Numbers without a unit are Pa."
        )
    elif modulus > STIFFEST:
        yield (
            f"The Young's modulus of {name} is {modulus:.4g} Pa, above that of diamond: check its unit."
            " Numbers without a unit are Pa."
        )
    if density < LIGHTEST:
        unit = "t/mm^3" if density < TONNES else "g/cm^3"
        yield (
            f"The density of {name} is {density:.6g} kg/m^3, below that of foams: is it {density:.6g} {unit}?"
            " Numbers without a unit are kg/m^3."
        )
    elif density > DENSEST:
        yield (
            f"The density of {name} is {density:.6g} kg/m^3, above that of any metal: check its unit. Numbers"
            " without a unit are kg/m^3."
        )
