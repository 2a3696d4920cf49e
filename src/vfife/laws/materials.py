"""Materials by the names that people know. Handbook values at room temperature; where a handbook gives a
range, its middle.

A part's own alloy, heat treatment or filler may differ: a table [material.NAME] in a model file takes the
place of an entry.

And wear coefficients of pairs of materials by name, as their sources have them.

Archard's law, V = K F s/H: volume V that a surface loses under a normal force F over a sliding distance s, H
its hardness, K a number of the pair. What a machine needs is k = K/H in 1/Pa; 1 mm^3/(N m) is 1e-9 1/Pa.
Tests of one pair differ by a factor of ten from each other (``SCATTER``), and oil changes K by a factor of a
thousand and more (``OILED``): a coefficient that was measured on the pair at hand is worth more than any
table.
"""

from __future__ import annotations

from .law import Material

SHIGLEY = "Budynas, Nisbett: Shigley's Mechanical Engineering Design, 10th ed. (2015), Table A-5"
CALLISTER = "Callister, Rethwisch: Materials Science and Engineering, 9th ed. (2014), Appendix B"
ASM = "ASM Handbook, vol. 2: Properties and Selection: Nonferrous Alloys (1990)"
DOMININGHAUS = "Domininghaus: Plastics for Engineers (1993)"
ASHBY = "Ashby: Materials Selection in Mechanical Design, 4th ed. (2011), Appendix A"

# Name: Young's modulus (Pa), Poisson's ratio, density (kg/m^3), what it is, source.
TABLE: dict[str, tuple[float, float, float, str, str]] = {
    "steel": (
        207e9,
        0.3,
        7800.0,
        "carbon steel",
        f"{SHIGLEY} (207 GPa); 0.3 and 7800 kg/m^3 as the VFIFE paper takes them, Section 4.1",
    ),
    "stainless-steel": (190e9, 0.305, 7750.0, "18-8 stainless steel", SHIGLEY),
    "cast-iron": (100e9, 0.211, 7200.0, "grey cast iron", SHIGLEY),
    "aluminium": (71.7e9, 0.333, 2710.0, "aluminium alloys", SHIGLEY),
    "magnesium": (44.8e9, 0.35, 1790.0, "magnesium alloys", SHIGLEY),
    "titanium": (114e9, 0.34, 4420.0, "titanium alloys", SHIGLEY),
    "copper": (119e9, 0.326, 8900.0, "copper", SHIGLEY),
    "brass": (106e9, 0.324, 8540.0, "brass", SHIGLEY),
    "bronze": (110e9, 0.341, 8860.0, "phosphor bronze C51000", ASM),
    "ptfe": (0.475e9, 0.46, 2170.0, "polytetrafluoroethylene, 0.40 to 0.55 GPa", CALLISTER),
    "nylon": (2.69e9, 0.39, 1140.0, "PA 66, dry, 1.59 to 3.79 GPa", CALLISTER),
    "pom": (2.8e9, 0.35, 1410.0, "polyoxymethylene copolymer", DOMININGHAUS),
    "peek": (3.6e9, 0.4, 1300.0, "polyetheretherketone, unfilled", DOMININGHAUS),
    "polycarbonate": (2.38e9, 0.36, 1200.0, "polycarbonate", CALLISTER),
    "rubber": (2e6, 0.4995, 925.0, "natural rubber at small strains, 1.5 to 2.5 MPa", ASHBY),
    "silicon-nitride": (304e9, 0.3, 3300.0, "hot-pressed Si3N4", CALLISTER),
    "alumina": (380e9, 0.22, 3980.0, "99.9 % Al2O3", CALLISTER),
}

MATERIALS: dict[str, Material] = {name: Material(name, *numbers[:3]) for name, numbers in TABLE.items()}

# Name: indentation hardness (Pa) of materials with a handbook value, as Brinell's or Vickers' number times
# 9.80665 MPa; source.
HARDNESS: dict[str, tuple[float, str]] = {
    "steel": (163 * 9.80665e6, "163 HB of AISI 1045, hot-rolled: Shigley, Table A-20"),
    "cast-iron": (201 * 9.80665e6, "201 HB of ASTM No. 30: Shigley, Table A-24"),
    "silicon-nitride": (16.0e9, "16.0 GPa, Vickers: Callister, Table 12.6"),
    "alumina": (26.5e9, "26.5 GPa, Vickers: Callister, Table 12.6"),
}


def hardness_of(material: Material) -> float | None:
    """Return the hardness (Pa) of a material, or that of the table for an unchanged built-in material; None
    if it is unknown.
    """
    if material.hardness is None and MATERIALS.get(material.name) == material and material.name in HARDNESS:
        return HARDNESS[material.name][0]
    return material.hardness


ARCHARD = (
    "Archard: Contact and rubbing of flat surfaces, J. Appl. Phys. 24, 981 (1953), and Archard, Hirst: The"
    " wear of metals under unlubricated conditions, Proc. R. Soc. A 236, 397 (1956), as tables of wear"
    " coefficients repeat them"
)

SCATTER = 10.0  # tests of one pair lie within so many times of K to either side
OILED = 1e-3  # of K, and less, where oil separates the surfaces
# The coefficient of examples: tool steel on tool steel (K = 1.3e-4, hardness 1.6 GPa) with oil.
EXAMPLE_COEFFICIENT, EXAMPLE_LUBRICATION = "8e-17 1/Pa", "steel on steel with oil, and less; dry 8e-14"
# Name: K (1) of the surface that is named first, dry in air; source.
PAIRS: dict[str, tuple[float, str]] = {
    "mild steel on mild steel": (7e-3, ARCHARD),
    "brass on tool steel": (6e-4, ARCHARD),
    "tool steel on tool steel": (1.3e-4, ARCHARD),
    "beryllium copper on tool steel": (3.7e-5, ARCHARD),
    "ptfe on tool steel": (2.5e-5, ARCHARD),
    "ferritic stainless steel on tool steel": (1.7e-5, ARCHARD),
    "pmma on tool steel": (7e-6, ARCHARD),
    "polyethylene on tool steel": (1.3e-7, ARCHARD),
}


def coefficient(named: float | str, material: Material) -> float | None:
    """Return k (1/Pa) of a surface: the number itself, or that of a named pair over the hardness of the
    surface's material; None if the hardness is unknown.
    """
    if not isinstance(named, str):
        return named
    hardness = hardness_of(material)
    return None if hardness is None else PAIRS[named][0] / hardness
