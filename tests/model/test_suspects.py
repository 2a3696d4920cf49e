"""What may be a mistake though it could be meant: told once, with the likely cause; nothing is said of
mechanisms that are meant.
"""

import dataclasses
import math

import pytest

import vfife
from vfife import gallery
from vfife.errors import AssemblyError
from vfife.model.drivers import Harmonic
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.validation.plausibility import suspects, unconnected
from vfife.model.wear import Wear
from vfife.report.overview import cautions


def linkage(coupler: float = 0.28, unit: float = 1.0) -> Mechanism:
    m = Mechanism("four-bar")
    m.point("A", 0.0, 0.0)
    m.point("D", 0.3 * unit, 0.0)
    for name, length, angle in (("crank", 0.1, 0.0), ("coupler", coupler, 0.9), ("rocker", 0.22, 1.7)):
        m.link(name, length=length * unit, mass=1.0, angle=angle)
    m.revolute("A", "ground.A", "crank.start")
    m.revolute("B", "crank.end", "coupler.start")
    m.revolute("C", "coupler.end", "rocker.end")
    m.revolute("D", "ground.D", "rocker.start")
    m.drive("crank", speed=10.0)
    return m


def turned(m: Mechanism) -> Mechanism:
    m.bodies["coupler"] = type(m.bodies["coupler"])(name="coupler", length=0.28, mass=1.0, angle=50.0)
    return m


def without(m: Mechanism, *joints: str) -> Mechanism:
    for joint in joints:
        del m.joints[joint]
    return m


def with_clearance(m: Mechanism, clearance: float, bearing_radius: float = 0.1) -> Mechanism:
    del m.joints["C"]
    m.clearance_joint("C", "coupler.end", "rocker.end", clearance=clearance, bearing_radius=bearing_radius)
    return m


def with_bearing(m: Mechanism, radius: float) -> Mechanism:
    return with_clearance(m, 1.5e-4, radius)


def rushing(m: Mechanism) -> Mechanism:
    m.drivers["crank"] = dataclasses.replace(m.drivers["crank"], speed=3000.0)
    return m


def spare(m: Mechanism) -> Mechanism:
    m.link("spare", length=0.1, mass=1.0)
    return m


def swinging(m: Mechanism) -> Mechanism:
    m.drivers["crank"] = Harmonic(body="crank", amplitude=30.0, frequency=1.0)
    return m


@pytest.mark.parametrize(
    ("mechanism", "words"),
    [
        (linkage(280.0), ["body.coupler.length is 280 m, 1,273 times the others", "280 mm?"]),
        (linkage(0.28e-3), ["body.coupler.length is 0.28 mm", "times smaller"]),
        (linkage(unit=1e3), ["body.crank.length is 100 m", "ground.D is 300 m", "300 mm?"]),
        (with_bearing(linkage(), 8.0), ["joint.C.bearing_radius is 8 m, more than the", "is it 8 mm?"]),
        (with_clearance(linkage(), 0.08), ["joint.C.clearance is 80 mm, 80 % of", "is it 0.08 mm?"]),
        (rushing(linkage()), ["driver.crank.speed is 3,000 rad/s, which is 28,647.9 rpm", "is it 3000 rpm?"]),
        (turned(linkage()), ["body.coupler.angle is 50 rad, which is 7.96 turns", "50 deg?"]),
        (swinging(linkage()), ["driver.crank.amplitude is 30 rad", "30 deg?"]),
        (spare(linkage()), ["Body spare is not connected"]),
        (without(linkage(), "B", "D"), ["Nothing connects coupler, rocker to the ground", "pivot missing?"]),
        (
            without(linkage(), "C"),
            [
                "chain is open: coupler.end and rocker.end are joined",
                "between rocker.end and coupler.end forgotten?",
            ],
        ),
        (
            without(linkage(), "D"),
            [
                "rocker.start is joined to nothing, and ground.D",
                "between ground.D and rocker.start forgotten?",
            ],
        ),
    ],
    ids=[
        "metres",
        "tiny",
        "all in millimetres",
        "radius in metres",
        "clearance in metres",
        "rpm",
        "radians",
        "amplitude",
        "body on nothing",
        "group on nothing",
        "two ends",
        "pivot",
    ],
)
def test_a_suspect_is_told(mechanism, words):
    told = (*suspects(mechanism), *unconnected(mechanism))
    assert told and all(word in told[0] for word in words), told


@pytest.mark.parametrize("name", gallery.__all__)
def test_nothing_is_said_of_what_is_meant(name):
    mechanism = getattr(gallery, name)()
    assert suspects(mechanism) == unconnected(mechanism) == ()


@pytest.mark.parametrize(("factor", "radius"), [(1e-6, "0.02887 mm"), (1e6, "2.887e+04 mm")])
def test_an_inertia_in_another_unit_is_told_with_its_radius(factor, radius):
    m = linkage()
    m.bodies["coupler"] = dataclasses.replace(
        m.bodies["coupler"], length=0.1, mass=2.0, inertia=factor * 2.0 * 0.1**2 / 12.0
    )
    (told,) = suspects(m)
    assert "body.coupler.inertia" in told and radius in told and "check its unit" in told


def rod(mass: float, name: str = "coupler") -> Mechanism:
    m = linkage()
    m.bodies[name] = dataclasses.replace(
        m.bodies[name], length=0.04, mass=mass, inertia=9e-6, center_at=0.013
    )
    return m


def of_inertia(m: Mechanism) -> list[str]:
    return [text for text in suspects(m) if "inertia" in text]


@pytest.mark.parametrize("mass", [2.268e-3, 9.0])
def test_a_mass_that_contradicts_the_inertia_is_told(mass):
    """35 grains were taken for 35 g; 9 kg of 9e-6 kg m^2 are a point in a rod of 40 mm."""
    (told,) = of_inertia(rod(mass))
    radius = 1e3 * math.sqrt(9e-6 / mass)
    assert f"with a mass of {mass:.4g} kg" in told and "body.coupler.inertia is 9e-06 kg m^2" in told
    assert f"gyration of {radius:.4g} mm for a body of 40 mm" in told and "rod has 11.5 mm" in told
    assert of_inertia(rod(0.035)) == []


def test_a_crank_with_a_flywheel_is_meant():
    assert of_inertia(rod(2.268e-3, "crank")) == of_inertia(rod(2.268e-3, "rocker")) == []


def test_a_run_and_a_check_tell_of_a_mass_that_contradicts_the_inertia():
    m = gallery.compressor(turns=0.1)
    rod = m.bodies["rod"]
    m.bodies["rod"] = dataclasses.replace(rod, mass=0.002, inertia=0.01)
    words = "body.rod.inertia is 0.01 kg m^2 with a mass of 0.002 kg"
    assert words in str(m.check())
    assert any(words in note for note in vfife.simulate(m, companions=1).summary["run"]["notes"])


def test_python_hears_of_it_too():
    assert "The chain is open" in str(without(linkage(), "D").check())
    with pytest.raises(AssemblyError, match="coupler at least 180 mm"):
        linkage(0.13).check()


def test_what_flies_hangs_on_nothing_and_is_meant_to():
    m = Mechanism("flying", gravity=(0.0, -9.81))
    m.link("stick", length=1.0, mass=1.0, velocity=(1.0, 2.0, 3.0))
    m.link("pushed", length=1.0, mass=1.0)
    m.point_mass("ball", mass=1.0)
    m.loads["push"] = PointForce(name="push", at="pushed.end", force=(1.0, 0.0))
    assert suspects(m) == ()


def test_open_ends_that_are_meant_are_not_told():
    pendulum = Mechanism("pendulum", gravity=(0.0, -9.81))
    pendulum.point("O", 0.0, 0.0)
    pendulum.link("rod", length=1.0, mass=1.0, angle=-0.5 * math.pi)
    pendulum.revolute("O", "ground.O", "rod.start")
    assert suspects(pendulum) == ()
    pendulum.drive("rod", speed=3.0)
    assert suspects(pendulum) == ()


def resized(m: Mechanism, **lengths: float) -> Mechanism:
    for name, length in lengths.items():
        m.bodies[name] = dataclasses.replace(m.bodies[name], length=length)
    return m


@pytest.mark.parametrize(
    ("crank", "rod", "words"),
    [
        (25.0, 110.0, "body.crank.length is 25 m, body.rod.length is 110 m: are they 25 mm, 110 mm?"),
        (22.5, 92.5, "body.crank.length is 22.5 m, body.rod.length is 92.5 m: are they 22.5 mm, 92.5 mm?"),
    ],
)
def test_lengths_of_links_in_metres_are_named_and_not_what_follows_from_them(crank, rod, words) -> None:
    (told,) = suspects(resized(gallery.compressor(), crank=crank, rod=rod))
    assert told == f"{words} Numbers without a unit are metres."


def test_links_of_a_large_machine_are_not_cautioned_about() -> None:
    beams = resized(with_clearance(linkage(), 1e-4), crank=5.5, coupler=15.4, rocker=12.1)
    assert not any("length" in text for text in suspects(beams))


@pytest.mark.parametrize(("free_length", "said"), [(100.0, True), (0.1, False), (0.0, False), (None, False)])
def test_a_free_length_in_metres_names_its_spring(free_length: float | None, said: bool) -> None:
    m = linkage()
    m.point("S", 0.35, 0.25)
    m.spring("back", "rocker.end", "ground.S", stiffness=3e3, free_length=free_length)
    sentence = "spring.back.free_length is 100 m, 357 times the other lengths: is it 100 mm?"
    told = suspects(m)
    assert len(told) == said and all(text.startswith(sentence) for text in told)


def test_a_free_length_without_other_lengths_is_compared_with_machines() -> None:
    m = Mechanism("weight on a spring")
    m.point("O", 0.0, 0.0)
    m.point_mass("ball", mass=1.0, position=(0.0, -0.1))
    m.spring("coil", "ground.O", "ball.center", stiffness=100.0, free_length=100.0)
    (told,) = suspects(m)
    assert told.startswith("spring.coil.free_length is 100 m: is it 100 mm?")


def test_a_load_of_nothing_is_mentioned() -> None:
    m = linkage()
    m.loads["wind"] = PointForce(name="wind", at="coupler.end")
    assert suspects(m) == ("load.wind has neither a force nor a moment: it changes nothing.",)
    for values in ({"force": (0.0, -1.0)}, {"moment": 0.1}):
        m.loads["wind"] = PointForce(name="wind", at="coupler.end", **values)
        assert suspects(m) == ()


def pressed(m: Mechanism, **changes) -> Mechanism:
    load = m.loads["gas"]
    m.loads["gas"] = dataclasses.replace(load, **changes)
    return m


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m.bodies["piston"].__class__, ""),
        (lambda m: pressed(m, **scaled(m, 1e-3)), "never exceeds"),
        (lambda m: rubbing(m, 5.0), "joint.small-end.friction.coefficient is 5"),
        (lambda m: heavy(m, 1000.0), "body.piston.mass is 150 kg"),
    ],
)
def test_units_of_a_compressor_that_are_plausible_but_wrong_are_cautioned_about(change, words) -> None:
    """As kPa written for bar, per cent for a coefficient, grams for kilograms."""
    model = gallery.compressor()
    assert suspects(model) == ()
    change(model)
    found = suspects(model)
    assert (len(found) == 1 and words in found[0]) if words else found == ()


def scaled(m: Mechanism, factor: float) -> dict:
    load = m.loads["gas"]
    keys = [key for key in ("pressure", "pressure_back") if getattr(load, key) is not None]
    return {key: tuple(factor * value for value in getattr(load, key)) for key in keys}


def above_ambient(m: Mechanism, zero: float) -> dict:
    """Return the pressures less ``zero`` (Pa)."""
    load = m.loads["gas"]
    return {key: tuple(value - zero for value in getattr(load, key)) for key in ("pressure", "pressure_back")}


@pytest.mark.parametrize(
    ("zero", "ambient", "words"),
    [
        (0.0, 1.013e5, None),
        (1.013e5, 1.013e5, "falls to -0.063 bar, below a vacuum"),
        (0.945e5, 1.013e5, "falls to 0.005 bar, nearly a vacuum"),
        (1.013e5, 0.0, None),
    ],
)
def test_gauge_pressure_beside_an_ambient_is_cautioned_about(zero: float, ambient: float, words) -> None:
    model = gallery.compressor()
    found = suspects(pressed(model, ambient=ambient, **above_ambient(model, zero)))
    assert len(found) == (words is not None)
    assert words is None or (words in found[0] and 'For gauge pressure set ambient = "0 bar"' in found[0])


def test_gauge_pressure_of_an_expression_is_cautioned_about() -> None:
    def gas(expression: str) -> Mechanism:
        model = gallery.compressor()
        unset = dict.fromkeys(("pressure", "pressure_back"))
        return pressed(model, travels=(0.077, 0.123), zero_travel=0.0, expression=expression, **unset)

    (told,) = suspects(gas("8[bar] * (x - 0.078) / 0.05"))
    assert "load.gas falls to -0.16 bar, below a vacuum, and looks like gauge pressure" in told
    assert suspects(gas("1[bar] + 8[bar] * (x - 0.077) / 0.05")) == ()


def rubbing(m: Mechanism, coefficient: float) -> None:
    joint = m.joints["small-end"]
    friction = dataclasses.replace(joint.friction, coefficient=coefficient)
    m.joints["small-end"] = dataclasses.replace(joint, friction=friction)


def heavy(m: Mechanism, factor: float) -> None:
    m.bodies["piston"] = dataclasses.replace(m.bodies["piston"], mass=factor * 0.15)


def test_a_table_of_degrees_taken_for_radians_is_cautioned_about() -> None:
    m = linkage()
    angles = tuple(float(angle) for angle in range(0, 361, 30))
    factors = tuple(abs(angle - 180.0) for angle in angles)
    m.loads["push"] = PointForce(
        name="push", at="rocker.end", force=(1.0, 0.0), crank="crank", angles=angles, factors=factors
    )
    assert any(
        "load.push.angles cover 360 rad, 57.3 turns: are they in degrees?" in text for text in suspects(m)
    )


def test_every_angle_of_many_turns_is_asked_for_in_degrees() -> None:
    m = linkage()
    m.loads["push"] = PointForce(
        name="push", at="rocker.end", force=(1.0, 0.0), crank="crank", angles=(0.0, 6.0), factors=(0.0, 1.0),
        zero_angle=90.0,
    )  # fmt: skip
    m.drivers["crank"] = Harmonic(body="crank", amplitude=0.5, phase=45.0, frequency=1.0)
    said = suspects(m)
    for number in ("load.push.zero_angle is 90 rad", "driver.crank.phase is 45 rad"):
        assert any(number in text for text in said), said
    assert any('write "90 deg", in Python too' in text for text in said)
    assert not any("amplitude" in text for text in said)


def test_a_clearance_without_a_unit_is_asked_for_in_millimetres() -> None:
    joint = gallery.compressor().joints["small-end"]
    (fault,) = dataclasses.replace(joint, clearance=0.08).conflicts()
    assert "Is it 0.08 mm? Numbers without units are metres" in str(fault)
    (fault,) = dataclasses.replace(joint, clearance=80.0).conflicts()
    assert "check the units of both" in str(fault).lower()


@pytest.mark.parametrize("clearance", [1.5e-4, 0.03])
def test_a_doubtful_radius_or_clearance_is_the_first_caution_of_a_run(clearance: float) -> None:
    """It explains those about step, loads and pressures; check() has it too, and a run has it once."""
    m = with_clearance(linkage(), clearance, 8.0 if clearance < 1e-3 else 0.1)
    caution = next(text for text in suspects(m) if text.startswith("joint.C."))
    assert caution in str(m.check())
    summary = vfife.simulate(m, duration=0.002, outputs=10, companions=0).summary
    assert next(cautions(summary)) == caution and list(cautions(summary)).count(caution) == 1


def test_a_speed_as_a_text_without_a_unit_is_questioned_as_the_number_is() -> None:
    questions = []
    for speed in (600, "600"):
        m = vfife.Mechanism("crank")
        m.revolute("O", m.point("O", 0.0, 0.0), m.link("crank", length=0.1, mass=1.0).start)
        m.drive("crank", speed=speed)
        questions.append([text for text in suspects(m) if "is it 600 rpm?" in text])
    assert len(questions[0]) == 1 and questions[0] == questions[1]


def of_steel(**constants: float) -> Mechanism:
    """A linkage whose coupler has a section of a material with these constants."""
    m = linkage()
    material = dataclasses.replace(vfife.laws.Material(), **constants)
    section = vfife.bodies.Section.rectangle(0.01, 0.01)
    m.bodies["coupler"] = dataclasses.replace(m.bodies["coupler"], material=material, section=section)
    return m


@pytest.mark.parametrize(
    ("mechanism", "words"),
    [
        (dataclasses.replace(linkage(), gravity=(0, -9810)), "1,000 times that of the Earth: is it 9810 mm"),
        (of_steel(youngs_modulus=207.0), "of material steel is 207 Pa, below that of rubber: is it 207 GPa?"),
        (of_steel(youngs_modulus=2.07e5), "is 207000 Pa, below that of rubber: is it 207000 MPa?"),
        (of_steel(youngs_modulus=207e12), "is 2.07e+14 Pa, above that of diamond: check its unit."),
        (of_steel(density=7.8), "is 7.8 kg/m^3, below that of foams: is it 7.8 g/cm^3?"),
        (of_steel(density=7.8e-9), "is 7.8e-09 kg/m^3, below that of foams: is it 7.8e-09 t/mm^3?"),
        (of_steel(density=7.8e6), "is 7.8e+06 kg/m^3, above that of any metal: check its unit."),
    ],
)  # fmt: skip
def test_constants_in_units_of_other_programs_are_told(mechanism, words):
    (told,) = suspects(mechanism)
    assert words in told


def test_a_material_of_a_surface_is_told_too():
    m = with_clearance(linkage(), 1e-4)
    plastic = vfife.laws.Material("plastic", 3000.0, 0.4, 1400.0)
    m.joints["C"] = dataclasses.replace(m.joints["C"], journal_material=plastic)
    (told,) = suspects(m)
    assert "material plastic is 3000 Pa" in told and "3000 MPa?" in told
    assert suspects(of_steel(youngs_modulus=7e5, density=20.0)) == ()  # a foamed rubber


def with_joint(name: str, **changes) -> Mechanism:
    m = gallery.slider_crank_loose_guide() if name == "guide" else gallery.slider_crank_loose_pin()
    m.joints[name] = dataclasses.replace(m.joints[name], **changes)
    return m


@pytest.mark.parametrize(
    ("mechanism", "words"),
    [
        (with_joint("pin", axial_length=20.0), "joint.pin.axial_length is 20 m, "),
        (with_joint("pin", landing_depth=0.005), "joint.pin.landing_depth is 0.005 m, "),
        (with_joint("pin", impact_speed_floor=1.0), "joint.pin.impact_speed_floor is 1 m/s, and speeds of"),
        (with_joint("pin", friction=vfife.laws.Ambrosio(v1=10.0)), "joint.pin.friction.v1 is 10 m/s, "),
        (with_joint("guide", height=40.0), "joint.guide.height is 40 m, and the largest length of other"),
    ],
)
def test_sizes_and_speeds_of_a_contact_are_told(mechanism: Mechanism, words: str) -> None:
    (told,) = suspects(mechanism)
    assert told.startswith(words) and "Numbers without a unit are m" in told


def test_the_inertia_of_a_body_with_a_single_pin_is_compared_with_the_mechanism() -> None:
    m = gallery.compressor()
    m.bodies["piston"] = dataclasses.replace(m.bodies["piston"], inertia=150.0)
    (told,) = suspects(m)
    assert told.startswith("body.piston.inertia is 150 kg m^2 with a mass of")


def test_a_rocker_with_a_flywheel_is_meant_after_a_coupler_with_an_inertia() -> None:
    """Which bodies are on the ground does not depend on the bodies before."""
    m = rod(2.268e-3, "rocker")
    m.bodies["coupler"] = dataclasses.replace(m.bodies["coupler"], inertia=0.28**2 / 12.0)
    assert of_inertia(m) == []


def test_a_section_that_contradicts_itself_or_its_link_is_told() -> None:
    def bent(section: vfife.bodies.Section) -> tuple[str, ...]:
        m = linkage()
        m.bodies["coupler"] = dataclasses.replace(m.bodies["coupler"], section=section, mass=None)
        return suspects(m)

    flat = vfife.bodies.Section.rectangle(0.01, 0.01)
    assert bent(flat) == ()
    assert "body.coupler.section is 10 m wide or deep" in bent(vfife.bodies.Section.rectangle(10.0, 10.0))[0]
    (told,) = bent(dataclasses.replace(flat, extreme_fibre=5.0))
    assert told.startswith("body.coupler.section.extreme_fibre is 5000 mm")


def test_large_radii_and_distant_starts_of_free_bodies_are_meant() -> None:
    m = Mechanism("ball", gravity=(0.0, -9.81))
    m.rigid_body("ball", mass=1.0, inertia=1e-4, position=(0.0, 1.5), pins={"mark": (0.01, 0.0)})
    m.external_contact("floor", m.point("floor", 0.0, 0.0), "ball.center", journal_radius=0.02)
    assert suspects(m) == ()


@pytest.mark.parametrize(
    ("length", "words"), [(6e-3, "can turn over in"), (9.5e-3, "can turn by 9.17 deg in"), (0.05, "")]
)
def test_a_block_that_can_turn_far_in_its_guide_is_told(length: float, words: str) -> None:
    sizes = {"height": 0.04, "clearance": 5e-4, "corner_radius": 1e-5}
    m = with_joint("guide", length=length, **sizes)
    told = suspects(m)
    assert len(told) == bool(words) and all(words in text and "joint.guide" in text for text in told)


@pytest.mark.parametrize("length", [0.01, 0.03, 0.08])
def test_at_the_largest_tilt_a_block_is_as_high_as_its_guide_is_wide(length: float) -> None:
    joint = with_joint("guide", length=length, height=0.02, clearance=2e-4).joints["guide"]
    tilt, r = joint.tilt, joint.corner_radius
    extent = (length - 2 * r) * math.sin(tilt) + (0.02 - 2 * r) * math.cos(tilt) + 2 * r
    assert 0.0 < tilt < 0.06 and extent == pytest.approx(0.0204, rel=1e-12)


def motor(factor: float, load: float = 0.0) -> Mechanism:
    """A four-bar with the curve of a motor of 12 N m times ``factor``."""
    m = linkage()
    m.drivers.clear()
    m.torque("crank", value=[12.0 * factor, 8.0 * factor, 0.0], speeds=[0.0, 30.0, 60.0])
    if load:
        m.loads["press"] = PointForce(name="press", at="coupler.end", force=(0.0, load))
    return m


def test_the_curve_of_a_motor_in_newton_millimetres_is_told() -> None:
    """A slow machine with a large load needs the torque that a fast one without load cannot use."""
    assert suspects(motor(1.0)) == suspects(motor(30.0)) == ()
    (told,) = suspects(motor(1000.0))
    assert told.startswith("driver.crank.torque reaches 12000 N m, ") and "is it 12000 N mm?" in told
    assert suspects(motor(1000.0, load=5e3)) == ()
    assert "12000 N m" in motor(1000.0).drivers["crank"].words


def test_a_wear_coefficient_in_cubic_millimetres_is_told() -> None:
    m = gallery.four_bar_case_c()
    steel = "mild steel on mild steel"
    for coefficient, said in ((8e-17, False), (6e-12, False), (8e-8, True), (steel, False)):
        m.joints["C"] = dataclasses.replace(m.joints["C"], wear=Wear(journal=coefficient))
        told = [text for text in suspects(m) if "joint.C.wear.journal" in text]
        assert len(told) == said and all("is it 8e-08 mm^3/(N m)?" in text for text in told)


@pytest.mark.parametrize(
    ("factor", "ambient", "words"),
    [
        (1e-5, 1.013, ("The pressure of load.gas never exceeds 8.4 Pa", "is it 8.4 bar?")),
        (1e-5, 0.0, ("The pressure of load.gas never exceeds 8.4 Pa", "is it 8.4 bar?")),
        (1.0, 1.013, ("load.gas.ambient is 1.013 Pa", "is it 1.013 bar?")),
        (1.0, 0.0, ("The pressure of load.gas falls to 0.95 bar", "is it absolute?")),
        (1.0, 1.013e5, ()),
    ],
)
def test_pressures_in_bar_without_their_unit_are_told(factor: float, ambient: float, words) -> None:
    model = gallery.compressor()
    found = suspects(pressed(model, ambient=ambient, **scaled(model, factor)))
    assert len(found) == bool(words) and all(word in found[0] for word in words)


def test_a_second_moment_that_no_section_of_this_area_has_is_told() -> None:
    m = gallery.lee_frame()
    body = m.bodies["frame"]
    m.bodies["frame"] = dataclasses.replace(
        body, section=dataclasses.replace(body.section, second_moment=2e-4)
    )
    (told,) = suspects(m)
    assert "radius of gyration of 577.4 mm, 23.6 times the root of the area" in told


@pytest.mark.parametrize(
    ("ambient", "lowest", "cautioned"),
    [(0.0, 0.95e5, True), (1e5, 0.95e5, False), (0.0, 0.0, False), (0.0, 2e5, False)],
)
def test_an_absolute_pressure_without_an_ambient_one_is_told(
    ambient: float, lowest: float, cautioned: bool
) -> None:
    m = gallery.compressor()
    m.loads.clear()
    m.guide_force(
        "gas", "cylinder", travels=[-0.046, 0.0], pressure=[lowest, 8e5], bore=0.065, ambient=ambient,
        reverse=True, zero_travel=0.123,
    )  # fmt: skip
    assert ["is it absolute?" in text for text in suspects(m)] == [True] * cautioned


def test_a_stop_at_an_angle_of_many_turns_is_told() -> None:
    m = linkage()
    m.stop("bump", "crank", "coupler", low=0.1, high=170.0, stiffness=1.0)
    (told,) = suspects(m)
    assert "spring.bump.high is 170 rad, which is 27.1 turns" in told


def test_a_piston_with_another_diameter_than_its_cylinder_has_a_caution() -> None:
    """A larger bore alone moves the force of the gas and leaves the piston as it was."""
    model = gallery.compressor()
    assert not suspects(model)
    (text,) = suspects(pressed(model, bore=0.08))
    assert "load.gas.bore is 80 mm, and joint.cylinder.height 65 mm" in text


def test_a_clearance_of_a_seventh_of_the_radius_has_a_caution() -> None:
    """2 mm in a bearing of 14 mm are a slip of the unit, not play."""
    model = gallery.compressor()
    joint = dataclasses.replace(model.joints["big-end"], clearance=0.002)
    (text,) = suspects(dataclasses.replace(model, joints={**model.joints, "big-end": joint}))
    assert "big-end" in text and "clearance" in text
