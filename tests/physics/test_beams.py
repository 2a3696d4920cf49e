"""Large strains: what length stiffness counts on, against a shooting integration of the extensible elastica
and Exudyn; the energy of both laws.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from support import go, particle, times
from vfife import simulate
from vfife.assembly.assemble import assemble
from vfife.compiler.trace.straight_line import trace
from vfife.gallery import elastic_pendulum
from vfife.laws.law import Material
from vfife.measures import ledger
from vfife.model.bodies import Section
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism, Settings
from vfife.solvers.transient import run

# The cantilever of Exudyn's geometricallyExactBeam2Dtest.py: 2 m at 45 degrees, 0.1 x 0.5 m, a force across
# its end and a moment.
LENGTH, WIDTH, HEIGHT, MODULUS = 2.0, 0.1, 0.5, 2.07e11
FORCE, MOMENT, TILT = 5e8 * HEIGHT**3, -5e8, math.pi / 4.0
EXUDYN = -2.19288  # deflection of its tip (m), shear stiff, 64 elements
STRAINS = ("reference", "current")


def cantilever(elements: int, strain: str) -> float:
    """Deflection of the tip (m)."""
    factors = tuple(
        np.linspace(0.0, 1.0, 5 if strain == "reference" else 13)[1:]
    )  # the present length makes the law one of increments
    settings = Settings(analysis="static", load_factors=factors, residual=1e-9, kinetic_energy=1e-16)
    m = Mechanism("cantilever", settings=settings)
    m.point("O", 0.0, 0.0)
    beam = {
        "model": "elastic",
        "section": Section.rectangle(WIDTH, HEIGHT),
        "material": Material(youngs_modulus=MODULUS),
        "angle": TILT,
    }
    m.link("beam", length=LENGTH, mass=1.0, elements=elements, strain=strain, **beam)
    m.weld("O", "ground.O", "beam.start")
    m.loads["load"] = PointForce(
        name="load", at="beam.end", force=(FORCE * math.sin(TILT), -FORCE * math.cos(TILT)), moment=MOMENT
    )
    record = simulate(m).record
    assert record.status == "complete"
    return float(particle(record, "beam", elements)["y"][-1]) - LENGTH * math.sin(TILT)


def elastica(strain: str) -> float:
    """The same by shooting: x' = (1 + e) cos, y' = (1 + e) sin, theta' = m/EI (1 or 1 + e), m' = - r' x F; e
    = N/EA or exp(N/EA) - 1.
    """
    ea, ei = MODULUS * WIDTH * HEIGHT, MODULUS * WIDTH * HEIGHT**3 / 12.0
    fx, fy = FORCE * math.sin(TILT), -FORCE * math.cos(TILT)

    def rates(s, y):
        c, sine = math.cos(y[2]), math.sin(y[2])
        pull = (fx * c + fy * sine) / ea
        size = 1.0 + pull if strain == "reference" else math.exp(pull)
        bend = y[3] / ei * (1.0 if strain == "reference" else size)
        return [size * c, size * sine, bend, -size * (c * fy - sine * fx)]

    def tip(clamp):
        return solve_ivp(
            rates, (0.0, LENGTH), [0.0, 0.0, TILT, clamp], method="DOP853", rtol=1e-12, atol=1e-12
        ).y[:, -1]

    clamp = brentq(lambda moment: tip(moment)[3] - MOMENT, MOMENT - 1e8, MOMENT + 1e8, xtol=1e-6)
    return float(tip(clamp)[1]) - LENGTH * math.sin(TILT)


@pytest.mark.system("relaxes frames of several sizes")
@pytest.mark.parametrize("strain", STRAINS)
def test_a_thick_cantilever_bends_as_the_extensible_elastica(strain):
    """Of second order in the elements, so 16 and 8 give what shooting gives; the two laws are 0.2 % apart."""
    coarse, fine = cantilever(8, strain), cantilever(16, strain)
    exact = elastica(strain)
    assert fine == pytest.approx(exact, rel=2e-3)
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(exact, rel=3e-5 if strain == "reference" else 3e-4)


def test_the_reference_length_is_that_of_beam_codes():
    """Exudyn's number, and how far the present length is from it."""
    assert elastica("reference") == pytest.approx(EXUDYN, rel=1e-4)
    assert elastica("current") == pytest.approx(EXUDYN * (1.0 - 0.00197), rel=1e-4)


@pytest.mark.system("relaxes 64 elements")
def test_with_as_many_elements_as_exudyn():
    assert cantilever(64, "reference") == pytest.approx(EXUDYN, abs=1.5e-5)


def test_a_cord_hangs_with_the_stretch_of_its_law():
    """A weight on two elements: EA (l/l_0 - 1) at 15 %."""
    area, modulus = 1e-4, 1e6
    m = Mechanism(
        "rubber",
        gravity=(0.0, -9.81),
        settings=Settings(analysis="static", residual=1e-10, kinetic_energy=1e-18),
    )
    m.point("O", 0.0, 0.0)
    rubber = Material(youngs_modulus=modulus, density=1e-3)
    m.link(
        "cord",
        length=1.0,
        mass=1e-9,
        model="elastic",
        elements=2,
        section=Section.square(area),
        material=rubber,
        angle=-math.pi / 2,
    )
    m.revolute("O", "ground.O", "cord.start")
    m.loads["weight"] = PointForce(name="weight", at="cord.end", force=(0.0, -modulus * area * 0.15))
    length = -float(particle(simulate(m).record, "cord", 2)["y"][-1])
    assert length == pytest.approx(1.15, rel=1e-6)


@pytest.mark.parametrize("path_unit", [1, 7])
def test_path_units_do_not_matter_where_stiffness_counts_on_the_reference(path_unit):
    m = elastic_pendulum()
    m.settings = dataclasses.replace(m.settings, path_unit=path_unit)
    one = particle(go(m, 2e-4, duration=0.2, outputs=4), "rod", 12)
    again = particle(go(elastic_pendulum(), 2e-4, duration=0.2, outputs=4), "rod", 12)
    assert one["y"] == pytest.approx(again["y"], abs=1e-10)


def test_neither_law_costs_a_line():
    """The kind is known when the step is traced."""
    counts = []
    for strain in STRAINS:
        m = elastic_pendulum()
        m.bodies["rod"] = dataclasses.replace(m.bodies["rod"], strain=strain)
        counts.append(len(trace(assemble(m).topology).operations))
    assert counts[0] == counts[1]


# ----------------------------------------------------------------------------------------------------- energy


def test_the_ledger_of_a_rubber_pendulum_falls_with_the_step():
    """Strains of 6 %, large turns: what is stored is the energy of the force law, so the error is that of the
    step, of second order.
    """
    records = [go(elastic_pendulum(), step, duration=0.8, outputs=400) for step in (8e-5, 4e-5)]
    strain = records[0].block("frame_axial_force") / records[0].parameter("frame_axial_stiffness")
    assert np.abs(strain).max() > 0.06
    coarse, fine = (ledger(record).error for record in records)
    assert fine < 1e-7
    assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("strain", STRAINS)
def test_the_energy_of_a_bar_is_that_of_its_law(strain):
    """A two-particle bar whose ends fly apart, 15 % and no bending: at the greatest stretch all is in the
    integral of the force.
    """
    m = Mechanism("bar")
    section, rubber = Section.square(1e-4), Material(youngs_modulus=1e6)
    m.link(
        "bar",
        length=0.5,
        mass=2.0,
        model="two-particle",
        section=section,
        material=rubber,
        release="both",
        strain=strain,
    )
    step, books = 2e-5, []
    for half in (1, 2):
        a = assemble(m, step / half, duration=0.5, outputs=500)
        a.state[a.layout["particle_u"][1:]] = -1.0, 1.0
        record = run(a)
        length = particle(record, "bar", 1)["x"] - particle(record, "bar", 0)["x"]
        books.append(ledger(record))
    top = int(np.argmax(length))
    stretch = length[top] / 0.5
    assert stretch > 1.15 and 0.0 < times(record)[top] < 0.5
    law = 0.5 * (stretch - 1.0) ** 2 if strain == "reference" else stretch * math.log(stretch) - stretch + 1.0
    assert books[1].terms["strain"][top] == pytest.approx(1e6 * 1e-4 * 0.5 * law, rel=1e-3)
    assert books[1].error < (1e-6 if strain == "reference" else 5e-5)
    assert math.log2(books[0].error / books[1].error) > (1.8 if strain == "reference" else 0.8)


# --------------------------------------------------------------------------------------------------- velocity


@pytest.mark.parametrize(
    "model", [{"model": "rigid"}, {"model": "elastic", "elements": 4, "section": Section.square(1e-4)}]
)
def test_velocity_is_that_of_the_origin(model):
    """A bar that is pinned at its origin and turns at -2 rad/s does so, as it would where the same is told as
    a start of the run.
    """
    m = Mechanism("bar")
    m.point("O", 0.3, 0.1)
    m.link("bar", length=0.8, mass=1.0, angle=0.7, velocity=(0.0, 0.0, -2.0), **model)
    m.revolute("O", "ground.O", "bar.start")
    m.start = dataclasses.replace(m.start, mode="rough")
    moved = simulate(m, step=1e-5, duration=1e-4).record
    assert moved.block("particle_w")[0, 1:] == pytest.approx(-2.0, rel=1e-9)
    m.bodies["bar"] = dataclasses.replace(m.bodies["bar"], velocity=(0.0, 0.0, 0.0))
    again = simulate(m, step=1e-5, duration=1e-4, start={"bar": ((0.3, 0.1, 0.7), (0.0, 0.0, -2.0))}).record
    assert moved.block("particle_v")[0] == pytest.approx(again.block("particle_v")[0], rel=1e-9, abs=1e-12)


def test_a_free_body_flies_as_its_origin_says():
    """Its pin at the origin starts at (u, v), its centre of mass at that and w times the arm."""
    m = Mechanism("plate")
    m.rigid_body("plate", mass=2.0, inertia=0.1, center=(0.3, 0.2), angle=0.5, velocity=(1.0, -0.5, 4.0))
    one = particle(go(m, 1e-5, duration=1e-4, outputs=1), "plate")
    c, s = math.cos(0.5), math.sin(0.5)
    assert one["u"][0] == pytest.approx(1.0 - 4.0 * (s * 0.3 + c * 0.2), rel=1e-12)
    assert one["v"][0] == pytest.approx(-0.5 + 4.0 * (c * 0.3 - s * 0.2), rel=1e-12)
