"""A rod whose given mass contradicts its section is remarked on."""

from vfife.assembly.assemble import assemble
from vfife.model.bodies import Frame, Member, Section
from vfife.model.mechanism import Mechanism, Settings
from vfife.model.validation.plausibility import contradictions


def rod(**link) -> Mechanism:
    m = Mechanism("rod", gravity=(0.0, -9.81), settings=Settings(duration=1e-3))
    m.point("O", 0.0, 0.0)
    m.link("rod", length=0.5, model="elastic", section=Section.round(0.02), **link)
    m.revolute("a", "ground.O", "rod.start")
    return m


def test_grams_for_kilograms_are_remarked_on() -> None:
    """7800 kg/m^3 pi/4 (20 mm)^2 500 mm = 1.225 kg."""
    (said,) = assemble(rod(mass=1225.0)).notes
    assert (
        said.startswith("Link rod: its mass is given as 1225 kg, its section and density make 1.225 kg")
        and "Leave the mass out" in said
    )


def test_a_mass_that_agrees_or_is_left_out_is_not() -> None:
    assert contradictions(rod()) == () and contradictions(rod(mass=1.2)) == ()
    assert len(contradictions(rod(mass=1.05))) == 1


def test_members_of_a_frame_too() -> None:
    m = Mechanism("frame")
    members = (Member(start="a", end="b", mass=3.0), Member(start="b", end="c"))
    m.bodies["arm"] = Frame(
        name="arm",
        nodes={"a": (0.0, 0.0), "b": (0.5, 0.0), "c": (0.5, 0.5)},
        members=members,
        section=Section.round(0.02),
    )
    (said,) = contradictions(m)
    assert said.startswith("Member a-b of arm")
